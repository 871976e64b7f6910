"""The steps: the six of the cell's guide (reference 4.4), and what we check besides.

Every check is the doctor's, so that bring-up and doctor cannot disagree.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from cell.bringup.connecting import Connected
from cell.bringup.step import Looked, Step
from cell.doctor import Component, Finding, Report
from cell.errors import CellError
from cell.profile import Profile

Examine = Callable[[Component], Report]
"""Examines one component of the cell, and what it depends on."""

Connect = Callable[[], Sequence[Connected]]
"""Opens every device and says of each what came of it."""

_NO_POWER = frozenset(
    {
        "arm-silent", "cable-out", "port-missing", "port-taken", "port-forbidden", "tcp-refused",
        "line-garbage", "wrong-device-answers",
    }
)  # fmt: skip
"""Causes that leave open whether the controller has power."""


def bring_up_steps(profile: Profile, examine: Examine, connect: Connect) -> tuple[Step, ...]:
    """Return the steps in the order in which they are taken; none for a disabled device.

    Args:
        profile: The cell's profile.
        examine: The doctor, asked for one component at a time.
        connect: Opens every device.
    """
    is_wanted = {
        "controller": profile.arm.enabled,
        "television": profile.display.enabled,
        "gripper": profile.gripper.enabled,
    }
    return tuple(step for step in _all_steps(examine, connect) if is_wanted.get(step.id, True))


def _all_steps(examine: Examine, connect: Connect) -> tuple[Step, ...]:
    groups = partial(_by_group, examine)
    return (
        Step(
            id="board",
            guide=1,
            title="The distribution board is on",
            instruction="Switch the distribution board on; its green lamp must be lit.",
            look=partial(_look_at_board, examine),
        ),
        Step(
            id="controller",
            guide=2,
            title="The arm controller is ready",
            instruction="Switch the controller on and wait for READY. Turn the key switch to "
            "AUTOMATIC. Switch the teach pendant off: TP ENABLED must be dark.",
            look=partial(groups, "arm", ("Arm", "Lines"), at=("arm",)),
        ),
        Step(
            id="television",
            guide=3,
            title="The television has mains",
            instruction="Switch the television on at its power switch.",
            look=partial(groups, "display", ("Television", "Lines"), at=("display",)),
        ),
        Step(
            id="leftovers",
            guide=4,
            title="No block is left on the playground",
            instruction="Put blocks that were left on the playground back into their slots.",
            look=partial(groups, "store", ("Store",), at=("store",)),
        ),
        Step(
            id="computer",
            guide=5,
            title="The computer is in order",
            instruction="Switch the computer on and log in.",
            look=partial(
                groups, "computer", ("Computer",), at=("computer",), but=("server-port-taken",)
            ),
        ),
        Step(
            id="profile",
            title="The profile fits the cell",
            instruction="Nothing to do: the profile is held against the arm's reach.",
            look=partial(groups, "profile", ("Profile",), at=("profile",)),
        ),
        Step(
            id="gripper",
            title="The gripper answers",
            instruction="Nothing to do: the gripper is powered and asked.",
            look=partial(groups, "gripper", ("Gripper", "Lines"), at=("gripper",)),
        ),
        Step(
            id="cameras",
            title="The cameras see",
            instruction="Take off lens caps; nothing else to do.",
            look=partial(groups, "cameras", ("Cameras", "Lights"), at=("camera", "lights")),
        ),
        Step(
            id="calibration",
            title="The calibration belongs to this cell",
            instruction="Nothing to do: the plane maps are looked at.",
            look=partial(groups, "calibration", ("Calibration",), at=("camera", "calibration")),
        ),
        Step(
            id="connect",
            title="Every device can be opened",
            instruction="Keep clear of the arm: servos go on, and the gripper moves its fingers "
            "to find its zero.",
            look=partial(_look_at_devices, connect),
        ),
        Step(
            id="server",
            guide=6,
            title="The server can start",
            instruction="Start the server with `cell serve` when this is done.",
            look=partial(_look_for_cause, examine, "computer", "server-port-taken"),
        ),
    )


def _look_at_board(examine: Examine) -> Looked:
    report = examine("arm")
    held = _held(report)
    if held is not None:
        return held
    if any(f.cause.id in _NO_POWER and f.component == "arm" for f in report.findings):
        return Looked(
            verdict="cannot tell",
            evidence=("the arm controller, which the board feeds, does not answer",),
            problem="whether the board is on cannot be measured",
            fix="look at its green lamp",
        )
    if any(one.component == "arm" for one in report.fine):
        answers = "the arm controller, which the board feeds, answers"
        return Looked(verdict="done", evidence=(answers,))
    return _unmeasured(report, "arm")


def _by_group(
    examine: Examine,
    component: Component,
    groups: Sequence[str],
    *,
    at: Sequence[str],
    but: Sequence[str] = (),
) -> Looked:
    """Look at a component: what the doctor finds in these groups is what is missing."""
    report = examine(component)
    held = _held(report)
    if held is not None:
        return held
    found = [
        finding
        for finding in report.findings
        if finding.cause.group in groups
        and finding.cause.id not in but
        and finding.component.startswith(tuple(at))
    ]
    if found:
        return _not_done(found)
    fine = [one for one in report.fine if one.component.startswith(tuple(at))]
    if fine:
        return Looked(verdict="done", evidence=tuple(f"{f.component}: {f.what}" for f in fine))
    return _unmeasured(report, component)


def _look_for_cause(examine: Examine, component: Component, cause: str) -> Looked:
    found = [finding for finding in examine(component).findings if finding.cause.id == cause]
    if found:
        return _not_done(found)
    return Looked(verdict="done", evidence=(f"no sign of {cause}",))


def _look_at_devices(connect: Connect) -> Looked:
    try:
        connected = connect()
    except CellError as error:
        # The report is owed all the same: another program may have the cell.
        return Looked(
            verdict="not done",
            evidence=(str(error),),
            problem="no device can be opened",
            fix="do what the evidence says, then look again",
        )
    failed = [one for one in connected if one.problem]
    evidence = tuple(f"{one.device}: {one.problem or one.identity}" for one in connected)
    if failed:
        names = ", ".join(one.device for one in failed)
        return Looked(
            verdict="not done",
            evidence=evidence,
            problem=f"{len(failed)} of {len(connected)} devices cannot be opened: {names}",
            fix="run `cell doctor`; it names the cause",
        )
    return Looked(verdict="done", evidence=evidence)


def _held(report: Report) -> Looked | None:
    """Return what is to be said where another program has the cell: nothing was examined."""
    found = [finding for finding in report.findings if finding.cause.id == "cell-in-use"]
    return _not_done(found) if found else None


def _not_done(found: Sequence[Finding]) -> Looked:
    first = found[0]
    more = tuple(f"also: {finding.component}: {finding.problem}" for finding in found[1:])
    return Looked(
        verdict="not done",
        evidence=(*first.facts, *more),
        problem=f"{first.component}: {first.problem}",
        fix=first.fix,
        link=first.cause.link,
    )


def _unmeasured(report: Report, component: str) -> Looked:
    whys = tuple(f"{one.what}: {one.why}" for one in report.unchecked)
    first = report.findings[0] if report.findings else None
    return Looked(
        verdict="cannot tell",
        evidence=whys,
        problem=f"the {component} could not be examined",
        fix=first.fix if first is not None else "see for yourself",
        link="" if first is None else first.cause.link,
    )
