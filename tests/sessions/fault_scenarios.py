"""How each row of the table of faults is made to happen in a session, and how its cause ends."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field

from cell.drivers.melfa_r3 import tables
from cell.drivers.schunk_smp.tables import Code, Command
from cell.drivers.sharp_aquos.tables import HDMI_FIRST
from cell.twin.screen import PageFault, TwinScreen
from cell.twin.wire_faults import WireFault
from tests.sessions.fault_rig import FaultRig, starts_motion

Moment = str
"""`lay-out`, `again` (a second set-up), `step`, `view`, `clean-up`."""

Arm = Callable[[FaultRig, random.Random, Moment], None]
Mend = Callable[[FaultRig], None]
Key = tuple[str, str, str]

LATE_S = {"arm": 2.2, "gripper": 0.6, "display": 3.3}
HEARD = {
    ("arm", "lay-out"): 40, ("arm", "step"): 3, ("arm", "clean-up"): 30,
    ("gripper", "lay-out"): 25, ("gripper", "clean-up"): 12,
    ("display", "again"): 2,
}  # fmt: skip
MOVED = {"lay-out": 8, "step": 1, "clean-up": 6}
GRIPPED = {"lay-out": 4, "clean-up": 4}


@dataclass(frozen=True)
class Scenario:
    """How a fault begins and ends.

    Attributes:
        moments: In which parts of a session it may happen.
        begin: Lets it happen, or sees to it that it will.
        mend: Takes its cause away.
    """

    moments: tuple[Moment, ...]
    begin: Arm
    mend: Mend = field(default=lambda rig: mend_wires(rig))


def mend_wires(rig: FaultRig) -> None:
    for wire in rig.behind.wires.values():
        wire.clear()


def on_reply(link: str, fault: WireFault, delay_s: float = 0.0) -> Arm:
    """Spoil the reply to a request drawn by chance."""

    def begin(rig: FaultRig, generator: random.Random, moment: Moment) -> None:
        # A gripper that starts is asked again and again, which is no fault.
        first = 4 if (link, moment) == ("gripper", "lay-out") else 1
        number = generator.randint(first, HEARD[link, moment])
        wire = rig.behind.wires[link]
        rig.timetable.at_request(link, number, lambda now: wire.inject(fault, delay_s=delay_s))

    return begin


def on_motion(link: str, act: Callable[[FaultRig, float], None], after_s: float = 0.0) -> Arm:
    """Do something at the start of a motion drawn by chance, or a little after it."""

    def begin(rig: FaultRig, generator: random.Random, moment: Moment) -> None:
        most = MOVED[moment] if link == "arm" else GRIPPED[moment]

        def due(now_s: float) -> None:
            if after_s:
                rig.timetable.at_time(now_s + after_s, lambda then: act(rig, then))
            else:
                act(rig, now_s)

        rig.timetable.at_request(
            link,
            generator.randint(1, most),
            due,
            counts=lambda data: starts_motion(link, data) and not references(link, data),
        )

    return begin


def references(link: str, data: bytes) -> bool:
    """Return whether a request belongs to the opening of the gripper."""
    return link == "gripper" and data[3] == Command.REFERENCE


def while_holding(act: Callable[[FaultRig, float], None], stages: tuple[int, ...]) -> Arm:
    """Do something when the arm is asked for the n-th time with a block between the fingers."""

    def begin(rig: FaultRig, generator: random.Random, moment: Moment) -> None:
        world = rig.cell.world
        rig.timetable.at_request(
            "arm",
            generator.choice(stages),
            lambda now_s: act(rig, now_s),
            counts=lambda data: world.held is not None,
        )

    return begin


def on_output(fault: WireFault) -> Arm:
    def begin(rig: FaultRig, generator: random.Random, moment: Moment) -> None:
        wire = rig.behind.wires["arm"]
        number = generator.randint(1, 2)
        rig.timetable.at_request(
            "arm", number, lambda now: wire.inject(fault), counts=lambda data: b"M_OUT" in data
        )

    return begin


def at_once(act: Callable[[FaultRig, float], None]) -> Arm:
    def begin(rig: FaultRig, generator: random.Random, moment: Moment) -> None:
        act(rig, rig.now_s())

    return begin


def break_wire(link: str, fault: WireFault) -> Callable[[FaultRig, float], None]:
    return lambda rig, now_s: rig.behind.wires[link].inject(fault)


def pull_for(link: str, for_s: float) -> Callable[[FaultRig, float], None]:
    def act(rig: FaultRig, now_s: float) -> None:
        wire = rig.behind.wires[link]
        wire.inject(WireFault.UNPLUGGED)
        rig.timetable.at_time(now_s + for_s, lambda then: wire.clear())

    return act


def refuse(rig: FaultRig, now_s: float) -> None:
    rig.behind.controller.replace_next_reply(f"QeR{tables.ARGUMENT_RANGE}\r".encode())


def before_motion(rig: FaultRig, generator: random.Random, moment: Moment) -> None:
    rig.timetable.at_request(
        "arm",
        generator.randint(1, MOVED[moment]),
        lambda now_s: refuse(rig, now_s),
        counts=lambda data: b"EXECP1=" in data,
    )


def press_stop(rig: FaultRig, now_s: float) -> None:
    rig.behind.controller.press_stop_button(now_s)


def slip(rig: FaultRig, now_s: float) -> None:
    assert rig.cell.world.slip(now_s)
    rig.behind.module.raise_error(Code.SOFT_LIMIT_LOW)


def all_reply_faults(device: str) -> dict[Key, Scenario]:
    moments = tuple(moment for link, moment in HEARD if link == device)
    kinds = {
        "lost reply": WireFault.LOST,
        "garbage": WireFault.GARBAGE,
        "half a frame": WireFault.HALF,
    }
    rows = {
        (device, name, "once"): Scenario(moments, on_reply(device, fault))
        for name, fault in kinds.items()
    }
    late = on_reply(device, WireFault.LATE, LATE_S[device])
    return rows | {
        (device, "late", "once"): Scenario(moments, late),
        (device, "slow reply", "once"): Scenario(moments, on_reply(device, WireFault.SLOW)),
    }


def camera(act: Callable[[FaultRig], None]) -> Arm:
    return lambda rig, generator, moment: act(rig)


def replug_camera(rig: FaultRig) -> None:
    rig.behind.cameras["top"].pull_cable()
    rig.behind.cameras["top"].plug_in()


def page(rig: FaultRig) -> TwinScreen:
    screen = rig.cell.screen
    assert isinstance(screen, TwinScreen)
    return screen


def disturb_page(fault: PageFault, pictures: int | None = None) -> Arm:
    return lambda rig, generator, moment: page(rig).disturb(fault, pictures=pictures)


def mend_page(rig: FaultRig) -> None:
    page(rig).mend()


def write_protect(rig: FaultRig, now_s: float) -> None:
    rig.cell.ledger._database.execute("PRAGMA query_only = ON")


def allow_writing(rig: FaultRig) -> None:
    rig.cell.ledger._database.execute("PRAGMA query_only = OFF")


LAID = ("lay-out", "step", "clean-up")
FINGERS = ("lay-out", "clean-up")
PICTURES = ("lay-out", "again")
SCENARIOS: dict[Key, Scenario] = {
    **all_reply_faults("arm"),
    **all_reply_faults("gripper"),
    **all_reply_faults("display"),
    ("arm", "unplugged and replugged", "under 0.5 s"): Scenario(
        LAID, on_motion("arm", pull_for("arm", 0.3))
    ),
    ("arm", "silence", "while opening"): Scenario(
        ("lay-out",), at_once(break_wire("arm", WireFault.SILENT))
    ),
    ("arm", "silence", "lasting"): Scenario(
        LAID, on_motion("arm", break_wire("arm", WireFault.SILENT))
    ),
    ("arm", "unplugged", "lasting"): Scenario(
        LAID, on_motion("arm", break_wire("arm", WireFault.UNPLUGGED))
    ),
    ("arm", "refusal", "any"): Scenario(LAID, before_motion),
    ("arm", "alarm", "in motion"): Scenario(
        LAID,
        on_motion(
            "arm", lambda rig, s: rig.behind.controller.raise_alarm(tables.OUT_OF_RANGE, s), 0.03
        ),
    ),
    ("arm", "power loss", "any"): Scenario(
        LAID, on_motion("arm", lambda rig, s: rig.behind.controller.lose_power(s, for_s=1.5))
    ),
    ("arm", "emergency stop", "in motion"): Scenario(
        LAID,
        on_motion("arm", lambda rig, s: rig.behind.controller.press_emergency_stop(s), 0.03),
        lambda rig: rig.behind.controller.release_emergency_stop(rig.now_s()),
    ),
    ("arm", "stop button", "in motion"): Scenario(LAID, on_motion("arm", press_stop, 0.03)),
    ("arm", "key to TEACH", "any"): Scenario(
        LAID,
        on_motion(
            "arm", lambda rig, s: rig.behind.controller.set_key_switch(s, is_automatic=False), 0.03
        ),
        lambda rig: rig.behind.controller.set_key_switch(rig.now_s(), is_automatic=True),
    ),
    ("arm", "right taken", "any"): Scenario(
        LAID,
        lambda rig, generator, moment: rig.timetable.at_request(
            "arm",
            generator.randint(1, MOVED[moment]),
            lambda s: rig.behind.controller.hold_right_by_panel(s, is_held=True),
            counts=lambda data: b"EXECP1=" in data,
        ),
        lambda rig: rig.behind.controller.hold_right_by_panel(rig.now_s(), is_held=False),
    ),
    ("arm", "stop asked for", "any"): Scenario(
        FINGERS,
        on_motion("arm", lambda rig, s: rig.cell.stop.stop("somebody asked for it")),
        lambda rig: rig.cell.stop.clear(),
    ),
    ("gripper", "wrong checksum", "once"): Scenario(
        FINGERS,
        on_reply("gripper", WireFault.CORRUPTED),
    ),
    ("gripper", "unplugged and replugged", "under 0.5 s"): Scenario(
        FINGERS, on_motion("gripper", pull_for("gripper", 0.3))
    ),
    ("gripper", "silence", "while opening"): Scenario(
        ("lay-out",), at_once(break_wire("gripper", WireFault.SILENT))
    ),
    ("gripper", "silence", "lasting"): Scenario(
        FINGERS, on_motion("gripper", break_wire("gripper", WireFault.SILENT))
    ),
    ("gripper", "unplugged", "lasting"): Scenario(
        FINGERS, on_motion("gripper", break_wire("gripper", WireFault.UNPLUGGED))
    ),
    ("gripper", "error latched", "its cause is gone"): Scenario(
        FINGERS, on_motion("gripper", lambda rig, s: rig.behind.module.raise_error(Code.TOW))
    ),
    ("gripper", "error latched", "its cause stays"): Scenario(
        FINGERS,
        on_motion(
            "gripper", lambda rig, s: rig.behind.module.raise_error(Code.TOW, is_lasting=True)
        ),
        lambda rig: rig.behind.module.cure(),
    ),
    ("gripper", "power loss", "back at once, fingers empty"): Scenario(
        FINGERS,
        lambda rig, generator, moment: rig.timetable.at_request(
            "gripper",
            1,
            lambda s: rig.behind.module.lose_power(s, for_s=0.3),
            counts=lambda data: data[3] == Command.MOVE_POSITION,
        ),
    ),
    ("gripper", "power loss", "back at once, holding a block"): Scenario(
        FINGERS,
        while_holding(lambda rig, s: rig.behind.module.lose_power(s, for_s=0.3), (1, 2, 4, 5, 7)),
    ),
    ("gripper", "power loss", "lasting"): Scenario(
        FINGERS,
        on_motion("gripper", lambda rig, s: rig.behind.module.lose_power(s, for_s=1e9)),
        lambda rig: rig.behind.module.lose_power(rig.now_s(), for_s=0.0),
    ),
    ("gripper", "blocked", "any"): Scenario(
        FINGERS,
        while_holding(lambda rig, s: rig.cell.world.jam_fingers(are_jammed=True), (1, 3, 5)),
        lambda rig: rig.cell.world.jam_fingers(are_jammed=False),
    ),
    ("gripper", "block lost", "on the way"): Scenario(FINGERS, while_holding(slip, (1, 2, 6, 7))),
    ("display", "unplugged and replugged", "under 0.5 s"): Scenario(
        ("again",),
        lambda rig, generator, moment: rig.timetable.at_request(
            "display", generator.randint(1, 2), lambda s: pull_for("display", 0.3)(rig, s)
        ),
    ),
    ("display", "silence", "while opening"): Scenario(
        ("lay-out",), at_once(break_wire("display", WireFault.SILENT))
    ),
    ("display", "silence", "lasting"): Scenario(
        ("again",), at_once(break_wire("display", WireFault.SILENT))
    ),
    ("display", "unplugged", "lasting"): Scenario(
        ("again",), at_once(break_wire("display", WireFault.UNPLUGGED))
    ),
    ("display", "asleep", "any"): Scenario(
        ("again",), at_once(lambda rig, s: rig.behind.television.press_power(s))
    ),
    ("display", "wrong input", "any"): Scenario(
        ("again",),
        lambda rig, generator, moment: rig.behind.television.press_input(
            rig.now_s(), generator.choice([0, *(n for n in HDMI_FIRST if n != 1)])
        ),
    ),
    ("display", "power loss", "any"): Scenario(
        ("again",),
        at_once(lambda rig, s: rig.behind.television.unplug(s)),
        lambda rig: rig.behind.television.press_power(rig.now_s()),
    ),
    **{
        ("screen", name, "any"): Scenario(PICTURES, disturb_page(fault), mend_page)
        for name, fault in (
            ("no page connected", PageFault.CLOSED),
            ("page hidden", PageFault.HIDDEN),
            ("page of a wrong size", PageFault.WRONG_SIZE),
        )
    },
    ("screen", "painted late", "once"): Scenario(
        PICTURES, disturb_page(PageFault.LATE, pictures=1), mend_page
    ),
    ("screen", "painted late", "lasting"): Scenario(
        PICTURES, disturb_page(PageFault.LATE), mend_page
    ),
    ("lights", "lost reply", "once"): Scenario(("lay-out",), on_output(WireFault.LOST)),
    ("lights", "garbage", "once"): Scenario(("lay-out",), on_output(WireFault.GARBAGE)),
    ("lights", "silence", "lasting"): Scenario(("lay-out",), on_output(WireFault.SILENT)),
    ("camera", "torn picture", "once"): Scenario(
        ("view",), camera(lambda rig: rig.behind.cameras["top"].half_frame())
    ),
    ("camera", "frozen picture", "any"): Scenario(
        ("view",), camera(lambda rig: rig.behind.cameras["top"].freeze())
    ),
    ("camera", "unplugged and replugged", "any"): Scenario(("view",), camera(replug_camera)),
    ("camera", "silence", "lasting"): Scenario(
        ("view",),
        camera(lambda rig: rig.behind.cameras["top"].fall_silent()),
        lambda rig: rig.behind.cameras["top"].fall_silent(False),
    ),
    ("camera", "unplugged", "lasting"): Scenario(
        ("view",),
        camera(lambda rig: rig.behind.cameras["top"].pull_cable()),
        lambda rig: rig.behind.cameras["top"].plug_in(),
    ),
    ("ledger", "disk error", "any"): Scenario(
        FINGERS, on_motion("gripper", write_protect), allow_writing
    ),
}
