"""The seeded faults: how each is brought about, and which cause the doctor must name first."""

from __future__ import annotations

import os
import random
import sqlite3
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from functools import partial
from pathlib import Path
from typing import TypeVar

from cell.doctor import Component, PageState, PortState
from cell.drivers.melfa_r3 import tables as melfa
from cell.drivers.schunk_smp.tables import Code, Register
from cell.drivers.sharp_aquos.tables import Word
from cell.ledger import Ledger
from cell.links.base import Link
from cell.links.errors import NotReached, PortForbidden, PortMissing, PortTaken
from cell.lock import CellLock
from cell.store import TablePlace
from cell.twin.emulators.melfa_r3.state import StopButton
from cell.twin.wire_faults import WireFault
from tests.cell.doctor.ward import NOW, Ward, mash, years

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Seed:
    """A fault.

    Attributes:
        name: What was done to the cell.
        cause: Id of the cause that must be named first.
        arrange: Makes the cell with the fault; gets an empty folder.
        only: The component to look at where the rest would only cost time.
    """

    name: str
    cause: str
    arrange: Callable[[Path], Ward]
    only: Component | None = None


def _ward(folder: Path) -> Ward:
    return Ward(folder=folder)


# Lines


def _wire(device: str, fault: WireFault, folder: Path) -> Ward:
    ward = _ward(folder)
    ward.cell.behind.wires[device].inject(fault)
    return ward


class _GarbageLink:
    """A line set to the wrong speed: every answer is other bytes."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._random = random.Random(name)
        self._waiting = 0

    @property
    def name(self) -> str:
        return self._name

    def write(self, data: bytes) -> None:
        self._waiting = len(data) + 9

    def read(self, timeout_s: float) -> bytes:
        count, self._waiting = self._waiting, 0
        return bytes(self._random.randrange(0x80, 0x100) for _ in range(count))

    def close(self) -> None:
        pass


def _garbage(device: str, folder: Path) -> Ward:
    ward = _ward(folder)
    ward.lines[device] = lambda: _GarbageLink(device)
    return ward


def _swapped(first: str, second: str, folder: Path) -> Ward:
    # The gripper is powered as it is in the middle of work: otherwise nobody answers there.
    ward = _ward(folder)
    ward.cell.world.set_output(ward.profile.outputs.gripper_power, is_on=True, now_s=ward.now_s)
    ward.cell.clock.sleep(1.0)
    ward.lines[first], ward.lines[second] = ward.line(second), ward.line(first)
    return ward


def _unopenable(device: str, error: Exception, folder: Path) -> Ward:
    def refuse() -> Link:
        raise error

    ward = _ward(folder)
    ward.lines[device] = refuse
    return ward


# The arm


def _alarm(number: int, folder: Path) -> Ward:
    ward = _ward(folder)
    ward.cell.behind.controller.raise_alarm(number, ward.now_s)
    return ward


def _hand(act: Callable[[Ward], None], folder: Path, *, in_service: bool = False) -> Ward:
    """Return a ward at whose arm controller somebody did something."""
    ward = _ward(folder)
    if in_service:
        ward.in_service()
    act(ward)
    return ward


def _emergency_stop(where: StopButton, ward: Ward) -> None:
    ward.cell.behind.controller.press_emergency_stop(ward.now_s, where)


def _key(ward: Ward) -> None:
    ward.cell.behind.controller.set_key_switch(ward.now_s, is_automatic=False)


def _right(ward: Ward) -> None:
    ward.cell.behind.controller.hold_right_by_panel(ward.now_s, is_held=True)


def _pendant(ward: Ward) -> None:
    ward.cell.behind.controller.enable_pendant(ward.now_s, is_enabled=True)


def _machine_lock(ward: Ward) -> None:
    ward.cell.behind.controller.lock_machine(is_locked=True)


def _other_arm(ward: Ward) -> None:
    ward.cell.behind.controller.connect_arm("RV-6SD")


def _no_program(ward: Ward) -> None:
    ward.cell.behind.controller.delete_program("1")


def _program_runs(ward: Ward) -> None:
    ward.cell.behind.controller.start_program("4", ("M1=1",), ward.now_s)


def _stop_input(ward: Ward) -> None:
    ward.cell.behind.controller.set_stop_input(ward.now_s, is_on=True)


def _dead_power_output(ward: Ward) -> None:
    ward.cell.behind.controller.break_output(ward.profile.outputs.gripper_power, ward.now_s)


def _servo_off(folder: Path) -> Ward:
    ward = _ward(folder).in_service()
    arm = ward.line("arm")()
    arm.write(b"1;1;SRVOFF\r")
    arm.read(1.0)
    return ward


def _override(folder: Path) -> Ward:
    ward = _ward(folder).in_service()
    arm = ward.line("arm")()
    arm.write(b"1;1;OVRD=10\r")
    arm.read(1.0)
    return ward


def _profile_with(folder: Path, **tables: dict[str, object]) -> Ward:
    """Return a ward whose cell is as ever and whose profile says something else."""
    changed = mash()
    for table, fields in tables.items():
        part = getattr(changed, table).model_copy(update=fields)
        changed = changed.model_copy(update={table: part})
    return _ward(folder).believing(profile=changed)


# The gripper


def _powered(folder: Path) -> Ward:
    return _ward(folder).in_service()


def _module_fault(code: int, folder: Path, *, is_warning: bool = False) -> Ward:
    ward = _powered(folder)
    module = ward.cell.behind.module
    (module.raise_warning if is_warning else module.raise_error)(code)
    return ward


def _power_off(folder: Path) -> Ward:
    ward = _powered(folder)
    ward.cell.set_output(ward.profile.outputs.gripper_power, is_on=False)
    return ward


def _register(register: Register, value: float, folder: Path) -> Ward:
    ward = _powered(folder)
    ward.cell.behind.module.set_register(register, value)
    return ward


def _unreferenced(folder: Path) -> Ward:
    ward = _powered(folder)
    ward.cell.behind.module.lose_reference()
    return ward


def _dead_gripper(folder: Path) -> Ward:
    ward = _ward(folder)
    ward.cell.behind.module.go_silent()
    return ward


# The television


def _tv_unplugged(folder: Path) -> Ward:
    ward = _ward(folder)
    ward.cell.behind.television.unplug(ward.now_s)
    return ward


def _tv_by_hand(folder: Path) -> Ward:
    """Mains were away; then somebody pressed the key: it is on and has no permission."""
    ward = _tv_unplugged(folder)
    ward.cell.behind.television.press_power(ward.now_s)
    ward.cell.clock.sleep(15.0)
    return ward


def _tv_standby(folder: Path) -> Ward:
    ward = _ward(folder).in_service()
    ward.cell.behind.television.press_power(ward.now_s)
    return ward


def _tv_input(folder: Path) -> Ward:
    ward = _ward(folder).in_service()
    ward.cell.display.select_input(3)
    return ward


def _tv_tuner(folder: Path) -> Ward:
    ward = _ward(folder).in_service()
    link = ward.line("display")()
    link.write(f"{Word.TUNER}0   \r".encode("ascii"))
    link.read(1.0)
    return ward


def _tv_timer(folder: Path) -> Ward:
    ward = _ward(folder).in_service()
    link = ward.line("display")()
    link.write(f"{Word.SLEEP_TIMER}1   \r".encode("ascii"))
    link.read(1.0)
    return ward


def _page(page: PageState, folder: Path) -> Ward:
    ward = _ward(folder)
    ward.surroundings.page_told = page
    return ward


# Lights and cameras


def _lights_off(folder: Path) -> Ward:
    ward = _ward(folder).with_pictures().in_service()
    ward.cell.switch_lights(is_on=False)
    return ward


def _camera(name: str, fault: str, folder: Path, *args: object) -> Ward:
    ward = _ward(folder).with_pictures()
    getattr(ward.cell.behind.cameras[name], fault)(*args)
    return ward


def _swapped_cameras(how: str, folder: Path) -> Ward:
    ward = _ward(folder).with_pictures()
    cameras = ward.cell.behind.cameras
    getattr(cameras["top"], how)(cameras["oblique"])
    return ward


def _camera_profile(name: str, folder: Path, **fields: object) -> Ward:
    cameras = dict(mash().cameras)
    cameras[name] = cameras[name].model_copy(update=fields)
    ward = _ward(folder).with_pictures()
    return ward.believing(profile=mash().model_copy(update={"cameras": cameras}))


def _overexposed(folder: Path) -> Ward:
    """Profile and camera agree on settings that are far too bright."""
    settings = replace(mash().cameras["top"].settings, gain_db=18.0)
    ward = _camera_profile("top", folder, settings=settings).with_pictures()
    ward.cell.behind.cameras["top"].configure(settings).require()
    return ward


# Store and files


def _ledger(folder: Path, *places: tuple[int, float, float]) -> Ward:
    ward = _ward(folder)
    for slot, x_mm, y_mm in places:
        ward.cell.ledger.released(slot, TablePlace(x_mm=x_mm, y_mm=y_mm, yaw_deg=0.0))
    return ward


def _interrupted(folder: Path) -> Ward:
    ward = _ward(folder)
    ward.cell.ledger.plan(7, None, TablePlace(x_mm=600.0, y_mm=0.0, yaw_deg=0.0))
    ward.cell.ledger.gripped()
    return ward


def _state(folder: Path) -> Ward:
    hour_ago = (NOW - timedelta(hours=1)).timestamp()
    for path in folder.iterdir():
        os.utime(path, (hour_ago, hour_ago))
    ward = _ward(folder)
    ward.surroundings.state_folder = folder
    return ward


def _broken_ledger(folder: Path) -> Ward:
    (folder / "ledger.sqlite").write_bytes(b"this is no database, and never was one" * 20)
    return _state(folder)


def _foreign_ledger(folder: Path) -> Ward:
    database = sqlite3.connect(folder / "ledger.sqlite")
    database.execute("CREATE TABLE birds (name TEXT)")
    database.close()
    return _state(folder)


def _closed_ledger(folder: Path) -> Ward:
    ward = _ward(folder)
    ledger = Ledger(folder / "ledger.sqlite")
    ledger.close()
    return ward.believing(ledger=ledger)


def _folder_for_ledger(folder: Path) -> Ward:
    (folder / "ledger.sqlite").mkdir()
    return _state(folder)


def _held_ledger(folder: Path) -> Ward:
    Ledger(folder / "ledger.sqlite").close()
    other = sqlite3.connect(folder / "ledger.sqlite", isolation_level=None)
    other.execute("PRAGMA locking_mode = EXCLUSIVE")
    other.execute("BEGIN EXCLUSIVE")
    ward = _state(folder)
    ward.to_close.append(other.close)
    return ward


def _broken_history(folder: Path) -> Ward:
    (folder / "watchdog.sqlite").write_bytes(b"this is no database, and never was one" * 20)
    return _state(folder)


def _full_and_no_ledger(folder: Path) -> Ward:
    (folder / "ledger.sqlite").mkdir()
    return _full(folder)


def _file_for_folder(folder: Path, *, is_state: bool) -> Ward:
    ward = _ward(folder)
    (folder / "taken").write_text("a file")
    if is_state:
        ward.surroundings.state_folder = folder / "taken" / "cell"
    else:
        ward.surroundings.recordings_folder = folder / "taken" / "sessions"
    return ward


def _full(folder: Path) -> Ward:
    ward = _state(folder)
    ward.surroundings.free = 50_000_000
    return ward


def _world(folder: Path) -> Ward:
    ward = _state(folder)
    ward.surroundings.world_trouble = "world.json does not hold a world of the twin"
    return ward


def _locked(folder: Path) -> Ward:
    ward = _state(folder)
    ward.to_close.append(CellLock(folder).release)
    return ward


def _date(now: datetime, folder: Path) -> Ward:
    ward = _ward(folder)
    ward.surroundings.wall = lambda: now
    return ward


def _late_record(folder: Path) -> Ward:
    recordings = folder / "sessions"
    recordings.mkdir()
    file = recordings / "tomorrow.mcap"
    file.write_bytes(b"")
    tomorrow = (NOW + timedelta(days=1)).timestamp()
    os.utime(file, (tomorrow, tomorrow))
    ward = _ward(folder)
    ward.surroundings.recordings_folder = recordings
    return ward


def _jump(folder: Path) -> Ward:
    def ticks() -> Iterator[datetime]:
        yield NOW
        yield NOW
        while True:
            yield NOW + timedelta(seconds=90)

    ward = _ward(folder)
    times = ticks()
    ward.surroundings.wall = lambda: next(times)
    return ward


def _port_taken(folder: Path) -> Ward:
    ward = _ward(folder)
    ward.surroundings.port = PortState(is_free=False, seen="Address already in use")
    return ward


def _same_port(folder: Path) -> Ward:
    profile = mash()
    serial = profile.gripper.serial.model_copy(update={"port": profile.arm.serial.port})
    return _profile_with(folder, gripper={"serial": serial})


def _same_guid(folder: Path) -> Ward:
    return _camera_profile("top", folder, guid=mash().cameras["oblique"].guid)


def _wrong_map(folder: Path) -> Ward:
    rows = [list(row) for row in mash().cameras["top"].plane_map or ()]
    rows[0][2] += 900.0
    return _camera_profile("top", folder, plane_map=tuple(tuple(row) for row in rows))


def _p(arrange: Callable[..., R], *args: object) -> Callable[..., R]:
    return partial(arrange, *args)


def _at_work(act: Callable[[Ward], None]) -> Callable[[Path], Ward]:
    return lambda folder: _hand(act, folder, in_service=True)


SEEDS: tuple[Seed, ...] = (
    Seed("the arm's cable is out", "cable-out", _p(_wire, "arm", WireFault.UNPLUGGED)),
    Seed("the gripper's cable is out", "cable-out", _p(_wire, "gripper", WireFault.UNPLUGGED)),
    Seed("the television's cable is out", "cable-out", _p(_wire, "display", WireFault.UNPLUGGED)),
    Seed("the arm has another baud rate", "line-garbage", _p(_garbage, "arm")),
    Seed("the gripper has another baud rate", "line-garbage", _p(_garbage, "gripper")),
    Seed("the television has another baud rate", "line-garbage", _p(_garbage, "display")),
    Seed(
        "arm and television have changed cables",
        "wrong-device-answers",
        _p(_swapped, "arm", "display"),
    ),
    Seed(
        "arm and gripper have changed cables",
        "wrong-device-answers",
        _p(_swapped, "arm", "gripper"),
    ),
    Seed(
        "the arm's adapter is not plugged in",
        "port-missing",
        _p(_unopenable, "arm", PortMissing("arm", "COM9", ("COM1",))),
    ),
    Seed(
        "a terminal program has the gripper's port",
        "port-taken",
        _p(_unopenable, "gripper", PortTaken("gripper", "COM8")),
    ),
    Seed(
        "the user may not open the television's port",
        "port-forbidden",
        _p(_unopenable, "display", PortForbidden("display", "COM7")),
    ),
    Seed(
        "the arm controller's network is off",
        "tcp-refused",
        _p(_unopenable, "arm", NotReached("arm", "10.0.0.9:10001", "connection refused")),
    ),
    Seed("the arm loses an answer", "line-unreliable", _p(_wire, "arm", WireFault.LOST)),
    Seed("the television's answer is cut", "line-unreliable", _p(_wire, "display", WireFault.HALF)),
    Seed("the arm sends garbage once", "line-unreliable", _p(_wire, "arm", WireFault.GARBAGE)),
    Seed("the controller is off", "arm-silent", _p(_wire, "arm", WireFault.SILENT)),
    Seed(
        "the panel's stop is pressed",
        "arm-emergency-stop-panel",
        _p(_hand, _p(_emergency_stop, "panel")),
    ),
    Seed(
        "the stop is pressed at work",
        "arm-emergency-stop-panel",
        _at_work(_p(_emergency_stop, "panel")),
    ),
    Seed(
        "the pendant's stop is pressed",
        "arm-emergency-stop-pendant",
        _p(_hand, _p(_emergency_stop, "pendant")),
    ),
    Seed(
        "a stop at the cell is pressed",
        "arm-emergency-stop-external",
        _p(_hand, _p(_emergency_stop, "external")),
    ),
    Seed("the key stands at TEACH", "arm-key-at-teach", _p(_hand, _key)),
    Seed("somebody turned the key at work", "arm-key-at-teach", _at_work(_key)),
    Seed("the pendant is enabled", "arm-pendant-enabled", _p(_hand, _pendant)),
    Seed("the pendant is enabled at work", "arm-pendant-enabled", _at_work(_pendant)),
    Seed("the panel holds the right", "arm-right-held", _p(_hand, _right)),
    Seed("the panel took the right at work", "arm-right-held", _at_work(_right)),
    Seed("a servo amplifier failed", "arm-alarm-high", _p(_alarm, melfa.SERVO_AMPLIFIER)),
    Seed("a target was out of range", "arm-alarm-low", _p(_alarm, melfa.TARGET_OUT_OF_RANGE)),
    Seed("a caution is shown", "arm-alarm-caution", _p(_alarm, melfa.UNKNOWN_COMMAND)),
    Seed("machine lock is on", "arm-machine-lock", _p(_hand, _machine_lock)),
    Seed("another arm is connected", "arm-wrong-robot", _p(_hand, _other_arm)),
    Seed("the empty program was deleted", "arm-program-missing", _p(_hand, _no_program)),
    Seed("a program runs", "arm-program-running", _p(_hand, _program_runs)),
    Seed("a stop input is on", "arm-stop-signal", _p(_hand, _stop_input)),
    Seed(
        "the profile's limits are others",
        "arm-limits-differ",
        lambda folder: _profile_with(folder, arm={"joint_max_deg": (170, 135, 166, 160, 110, 200)}),
    ),
    Seed(
        "the profile's tool is another",
        "arm-tool-differs",
        lambda folder: _profile_with(folder, arm={"tool_mm": (0.0, 0.0, 160.2)}),
    ),
    Seed("the servos went off at work", "arm-servo-off", _servo_off),
    Seed("the override was lowered at work", "arm-override-low", _override),
    Seed("the gripper's power went off at work", "gripper-no-power", _power_off),
    Seed(
        "the power output does not come on",
        "gripper-no-power",
        _p(_hand, _dead_power_output),
    ),
    Seed("the gripper is dead", "gripper-silent", _dead_gripper),
    Seed(
        "the gripper has another id",
        "gripper-wrong-id",
        lambda folder: _profile_with(folder, gripper={"module_id": 11}),
    ),
    Seed("an error is latched", "gripper-error-latched", _p(_module_fault, int(Code.COMMUTATION))),
    Seed("the fingers lag", "gripper-blocked", _p(_module_fault, int(Code.TOW))),
    Seed("the motor's voltage fell", "gripper-voltage", _p(_module_fault, Code.MOTOR_VOLTAGE_LOW)),
    Seed(
        "the logic's voltage is low",
        "gripper-voltage",
        lambda folder: _module_fault(Code.LOGIC_VOLTAGE_LOW, folder, is_warning=True),
    ),
    Seed(
        "the gripper is hot",
        "gripper-warning",
        lambda folder: _module_fault(Code.TEMPERATURE_HIGH, folder, is_warning=True),
    ),
    Seed(
        "the gripper counts in inch", "gripper-unit-system", _p(_register, Register.UNIT_SYSTEM, 2)
    ),
    Seed(
        "the gripper's limit is narrow",
        "gripper-stroke-differs",
        _p(_register, Register.SOFT_LIMIT_HIGH, 50.0),
    ),
    Seed("the gripper lost its zero", "gripper-not-referenced", _unreferenced),
    Seed("the television has no mains", "tv-silent", _tv_unplugged),
    Seed("the television was switched on by hand", "tv-no-permission", _tv_by_hand),
    Seed("the television went off at work", "tv-standby", _tv_standby),
    Seed("another input is shown", "tv-wrong-input", _tv_input),
    Seed("the tuner is shown", "tv-wrong-input", _tv_tuner),
    Seed("the sleep timer runs", "tv-sleep-timer", _tv_timer),
    Seed(
        "the picture page is closed", "page-not-connected", _p(_page, PageState(is_connected=False))
    ),
    Seed(
        "the picture page is zoomed",
        "page-wrong-size",
        _p(_page, PageState(is_connected=True, width_px=1536, height_px=864)),
    ),
    Seed("the lights went off at work", "lights-off", _lights_off),
    Seed(
        "the wrong output is switched for the lights",
        "lamp-dead",
        lambda folder: _profile_with(folder, outputs={"lights": 12}).with_pictures(),
    ),
    Seed("a camera's cable is out", "camera-missing", _p(_camera, "top", "pull_cable")),
    Seed("a camera gives nothing", "camera-missing", _p(_camera, "gripper", "fall_silent")),
    Seed("cameras have changed cables", "camera-swapped", _p(_swapped_cameras, "swap_cables")),
    Seed("cameras have changed places", "camera-swapped", _p(_swapped_cameras, "swap_places")),
    Seed(
        "a camera was replaced",
        "camera-unknown",
        lambda folder: _camera_profile("oblique", folder, guid="00B09D0100000001"),
    ),
    Seed("the top camera hangs", "camera-frozen", _p(_camera, "top", "freeze")),
    Seed("half a picture comes", "camera-torn", _p(_camera, "oblique", "half_frame")),
    Seed(
        "the shutter is automatic",
        "camera-automatic",
        lambda folder: _camera("top", "leave_auto", folder, "shutter"),
    ),
    Seed(
        "the gain was turned",
        "camera-settings-differ",
        lambda folder: _camera("oblique", "set_absolute", folder, "gain", 8.0),
    ),
    Seed("a cap is on the lens", "camera-dark", _p(_camera, "oblique", "cover_lens")),
    Seed("a camera is far too bright", "camera-overexposed", _overexposed),
    Seed(
        "the top camera is out of focus",
        "camera-defocused",
        lambda folder: _camera("top", "defocus", folder, 4.0),
    ),
    Seed(
        "somebody knocked against a camera",
        "camera-moved",
        lambda folder: _camera("oblique", "knock", folder, 14.0, -6.0),
    ),
    Seed(
        "there is no plane map",
        "plane-map-missing",
        lambda folder: _camera_profile("top", folder, plane_map=None),
    ),
    Seed(
        "the plane map is of another camera",
        "plane-map-other-camera",
        lambda folder: _camera_profile("top", folder, plane_map_guid="00B09D01009A0000"),
    ),
    Seed("the plane map was mistyped", "plane-map-implausible", _wrong_map),
    Seed(
        "the plane map is three years old",
        "plane-map-old",
        lambda folder: _camera_profile("top", folder, plane_map_date=(NOW - years(3)).date()),
    ),
    Seed("two devices have one port", "profile-same-port", _same_port),
    Seed("two cameras have one GUID", "profile-same-guid", _same_guid),
    Seed(
        "the laying height is too low",
        "profile-laying-height",
        lambda folder: _profile_with(folder, heights={"laying_mm": 45.0}),
    ),
    Seed(
        "the store's corner is wrong",
        "profile-slot-unreachable",
        lambda folder: _profile_with(folder, store={"corner_mm": (-250.0, 1100.0)}),
    ),
    Seed(
        "the lattice's origin is the printed one",
        "profile-corner-unreachable",
        lambda folder: _profile_with(folder, lattice={"origin_mm": (711.0, -600.0)}),
    ),
    Seed(
        "the rest place is beyond a limit",
        "profile-rest-refused",
        lambda folder: _profile_with(folder, arm={"rest_deg": (90, -30, 120, 0, 101, 90)}),
    ),
    Seed(
        "a view's camera is not in the profile",
        "profile-camera-missing",
        lambda folder: _ward(folder).believing(views=("top", "left")),
    ),
    Seed("another server has the cell", "cell-in-use", _locked),
    Seed(
        "the state folder is a file",
        "state-folder-unwritable",
        lambda folder: _file_for_folder(folder, is_state=True),
    ),
    Seed(
        "the recordings folder is a file",
        "recordings-unwritable",
        lambda folder: _file_for_folder(folder, is_state=False),
    ),
    Seed("the disk is nearly full", "disk-nearly-full", _full),
    Seed("the twin's world is damaged", "world-file-broken", _world),
    Seed(
        "the clock stands at 1970",
        "clock-implausible",
        _p(_date, datetime.fromtimestamp(0, NOW.tzinfo)),
    ),
    Seed("a record is of tomorrow", "clock-behind-records", _late_record),
    Seed("the clock jumps", "clock-jumped", _jump),
    Seed("another program listens", "server-port-taken", _port_taken),
    Seed("the ledger is damaged", "ledger-unreadable", _broken_ledger),
    Seed("the ledger is another database", "ledger-unreadable", _foreign_ledger),
    Seed("the ledger was closed", "ledger-out-of-reach", _closed_ledger),
    Seed("the ledger's name is a folder's", "ledger-out-of-reach", _folder_for_ledger),
    Seed("another program writes the ledger", "ledger-out-of-reach", _held_ledger),
    Seed(
        "a full disk keeps the ledger from being read",
        "disk-nearly-full",
        _full_and_no_ledger,
    ),
    Seed("the watchdog's history is damaged", "watchdog-history-unreadable", _broken_history),
    Seed("a transfer was cut short", "transfer-interrupted", _interrupted),
    Seed(
        "two blocks are noted at one place",
        "blocks-at-one-place",
        lambda folder: _ledger(folder, (7, 600.0, 0.0), (8, 604.0, 3.0)),
    ),
    Seed(
        "a block of another store lies out",
        "block-unknown",
        lambda folder: _ledger(folder, (77, 600.0, 0.0)),
    ),
    Seed(
        "blocks were left out",
        "block-out",
        lambda folder: _ledger(folder, (7, 600.0, 0.0), (8, 500.0, 100.0)),
    ),
)
