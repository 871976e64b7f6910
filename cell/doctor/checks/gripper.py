"""The gripper: power, id, errors, warnings, units, zero. The fingers do not move."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from cell.doctor.checks.arm import ArmExamination
from cell.doctor.checks.lines import hear_device, judge_line, opened_line
from cell.doctor.environment import Environment
from cell.doctor.notes import Notes
from cell.doctor.patient import Patient
from cell.drivers.schunk_smp.conversation import Conversation
from cell.drivers.schunk_smp.replies import StateReply
from cell.drivers.schunk_smp.requests import ModuleRequests
from cell.drivers.schunk_smp.scan import find_modules
from cell.drivers.schunk_smp.settings import SchunkSettings
from cell.drivers.schunk_smp.tables import (
    UNIT_MILLIMETRE,
    UNIT_SYSTEMS,
    Code,
    Register,
    Status,
    problem_of,
)
from cell.errors import CellError
from cell.links.base import Link

_BOOT_TRIES = 5
_POLL_S = 0.25
_SCANNED = range(1, 33)
_BLOCKED = frozenset({Code.TOW, Code.CURRENT, Code.HARD_LIMIT_LOW, Code.HARD_LIMIT_HIGH, Code.I2T})
_VOLTAGES = frozenset(
    {
        Code.LOGIC_VOLTAGE_LOW,
        Code.LOGIC_VOLTAGE_HIGH,
        Code.MOTOR_VOLTAGE_LOW,
        Code.MOTOR_VOLTAGE_HIGH,
    }
)
_SLACK_MM = 0.05


def check_gripper(
    patient: Patient, environment: Environment, arm: ArmExamination | None, notes: Notes
) -> None:
    """Examine the gripper, with its power switched on for that long if it is off.

    Args:
        patient: The cell.
        environment: The computer.
        arm: The conversation with the arm's controller, which switches the power; None
            where the controller cannot be asked.
        notes: Where to write.
    """
    if arm is None:
        why = "the arm controller, which switches its power, cannot be asked"
        _listen_only(patient, environment, notes, why)
        return
    with _powered(patient, arm, notes) as was_on:
        if was_on is not None:
            _ask(patient, environment, notes, was_on=was_on)


@contextmanager
def _powered(patient: Patient, arm: ArmExamination, notes: Notes) -> Iterator[bool | None]:
    """Have the gripper powered for a while.

    Yields:
        Whether it was powered before; None if it has no power, which is written down.
    """
    bit = patient.profile.outputs.gripper_power
    if arm.reads_on(bit):
        yield True
        return
    if patient.is_in_service:
        problem = "the gripper's power is off in the middle of work"
        notes.find("gripper-no-power", "gripper", problem, f"output {bit} reads off")
        yield None
        return
    if not arm.take_right():
        notes.skip("gripper", "everything", f"its power (output {bit}) is off, and the arm "
                   "controller does not give the right to switch it on")  # fmt: skip
        yield None
        return
    if not arm.switch_output(bit, is_on=True):
        problem = "the gripper's power does not come on"
        notes.find("gripper-no-power", "gripper", problem, f"output {bit} switched on, reads off")
        yield None
        return
    try:
        yield False
    finally:
        arm.switch_output(bit, is_on=False)


def _listen_only(patient: Patient, environment: Environment, notes: Notes, why: str) -> None:
    """Say of a gripper whose power is unknown only what its line tells."""
    with opened_line(patient, environment, notes, "gripper") as link:
        if link is None:
            return
        heard = hear_device(patient, link, "gripper")
        if heard.verdict == "silent":
            notes.skip("gripper", "everything", why)
        elif judge_line(environment, notes, "gripper", heard):
            _examine(patient, link, notes, was_on=True)


def _ask(patient: Patient, environment: Environment, notes: Notes, *, was_on: bool) -> None:
    with opened_line(patient, environment, notes, "gripper") as link:
        if link is None:
            return
        if not was_on:
            _await_boot(patient, link, notes)
        heard = hear_device(patient, link, "gripper")
        if heard.verdict == "silent" and _found_elsewhere(patient, link, notes):
            return
        if judge_line(environment, notes, "gripper", heard):
            _examine(patient, link, notes, was_on=was_on)


def _await_boot(patient: Patient, link: Link, notes: Notes) -> None:
    """Give a module that was just switched on the time to start, no longer."""
    module = _requests(patient, link, notes)
    # Counted, not timed: on a line that answers at once with nothing a clock may stand still.
    for _ in range(_BOOT_TRIES):
        try:
            module.state(attempts=1)
            return
        except CellError:
            patient.clock.sleep(_POLL_S)


def _found_elsewhere(patient: Patient, link: Link, notes: Notes) -> bool:
    """Look for a module under another id; return whether one was found."""
    wanted = patient.profile.gripper.module_id
    ids = [module_id for module_id in _SCANNED if module_id != wanted]
    found = find_modules(link, patient.clock, ids=ids, timeout_s=0.05)
    if not found:
        return False
    module = found[0]
    notes.find(
        "gripper-wrong-id",
        "gripper",
        f"a module answers under id {module.module_id}, the profile has {wanted}",
        f"ids {min(_SCANNED)} to {max(_SCANNED)} asked; {module.kind} under {module.module_id}",
        fix=f"set gripper.module_id to {module.module_id} in the profile",
    )
    return True


def _examine(patient: Patient, link: Link, notes: Notes, *, was_on: bool) -> None:
    module = _requests(patient, link, notes)
    notes.fine("gripper", f"identity: {module.identity()}")
    state = module.state()
    if state.error or state.status & (Status.ERROR | Status.WARNING):
        _judge_code(state, notes)
    else:
        notes.fine("gripper", "no error is latched")
    unit = int(module.register(Register.UNIT_SYSTEM))
    if unit != UNIT_MILLIMETRE:
        words = UNIT_SYSTEMS.get(unit, str(unit))
        problem = f"the gripper counts in {words}, not in millimetre"
        notes.find("gripper-unit-system", "gripper", problem, f"register 0x06 reads {unit}")
        return
    notes.fine("gripper", "it counts in millimetre")
    _check_stroke(patient, module, notes)
    if not was_on:
        notes.skip("gripper", "zero", "its power was off; it references itself when it is opened")
    elif state.status & Status.REFERENCED:
        notes.fine("gripper", "it knows its zero")
    else:
        problem = "the gripper has power and does not know its zero"
        notes.find("gripper-not-referenced", "gripper", problem, f"status {state.status:02X}")


def _judge_code(state: StateReply, notes: Notes) -> None:
    """Write down a latched error or a warning under the cause that its code tells."""
    entry = problem_of(state.error)
    fact = f"status {state.status:02X}, code {state.error:#04x}"
    if state.error in _VOLTAGES:
        cause = "gripper-voltage"
    elif not state.status & Status.ERROR:
        cause = "gripper-warning"
    else:
        cause = "gripper-blocked" if state.error in _BLOCKED else "gripper-error-latched"
    notes.find(cause, "gripper", f"the gripper reports: {entry.text}", fact, fix=entry.advice)


def _check_stroke(patient: Patient, module: ModuleRequests, notes: Notes) -> None:
    high_mm = module.register(Register.SOFT_LIMIT_HIGH)
    gripper = patient.profile.gripper
    needed_mm = max(gripper.open_mm, gripper.stroke_mm)
    if high_mm < needed_mm - _SLACK_MM:
        notes.find(
            "gripper-stroke-differs",
            "gripper",
            f"the fingers open to {high_mm:.1f} mm, the profile says {needed_mm:.1f} mm",
            f"upper soft limit {high_mm:.2f} mm",
        )
    else:
        notes.fine("gripper", f"its stroke is {high_mm:.1f} mm")


def _requests(patient: Patient, link: Link, notes: Notes) -> ModuleRequests:
    settings = SchunkSettings.from_profile(patient.profile.gripper)
    conversation = Conversation(
        link,
        patient.clock,
        device="gripper",
        module=settings.module_id,
        attempts=2,
        on_repeat=notes.repeated,
    )
    return ModuleRequests(conversation, settings)
