"""The arm's controller: stops, switches, alarms, right, programs, parameters. Nothing moves."""

from __future__ import annotations

from collections.abc import Sequence

from cell.doctor.notes import Notes
from cell.doctor.patient import Patient
from cell.drivers.melfa_r3 import records, tables
from cell.drivers.melfa_r3.dialogue import Dialogue
from cell.drivers.melfa_r3.panel import ControlPanel
from cell.drivers.melfa_r3.settings import ArmSettings
from cell.drivers.melfa_r3.tables import Run
from cell.errors import DeviceError, LinkError
from cell.links.base import Link
from cell.profile import MelfaProfile

_CLIENT = "DOCTOR"
_ROBOTS = {"melfa-rv6sdl": "RV-6SDL"}
"""What the controller calls the arm of each model of the profile."""

_EMERGENCIES = (
    (0x2, tables.EMERGENCY_PANEL, "arm-emergency-stop-panel", "the panel"),
    (0x4, tables.EMERGENCY_PENDANT, "arm-emergency-stop-pendant", "the teach pendant"),
    (0x1, tables.EMERGENCY_EXTERNAL, "arm-emergency-stop-external", "an external button"),
)
"""Bit in STPSIG, alarm, cause, words."""

_STOPPERS = ((0x2, "the computer"), (0x4, "an input"), (0x8, "the operation panel"))
"""Bits of the stop sources in STPSIG; bit 0, the pendant, has a cause of its own."""

_PENDANT = 0x1
_EMERGENCY_ALARMS = frozenset(alarm for _, alarm, _, _ in _EMERGENCIES)
_ASIDE_DEG = 0.5
_SAME = 0.05
"""Parameters are printed with two decimals."""


class ArmExamination:
    """One conversation with the controller, from session to session's end.

    The doctor opens a session only where none is open, and ends only its own.
    """

    def __init__(self, patient: Patient, link: Link, notes: Notes) -> None:
        self._patient = patient
        self._profile: MelfaProfile = patient.profile.arm
        self._notes = notes
        settings = ArmSettings(
            robot=self._profile.robot,
            slot=self._profile.slot,
            linear_speed_mm_s=self._profile.linear_speed_mm_s,
            joint_speed_percent=self._profile.joint_speed_percent,
            reply_timeout_s=0.6,
        )
        self._dialogue = Dialogue(link, patient.clock, settings, notes.repeated)
        self.panel = ControlPanel(self._dialogue)
        self._program = settings.program
        self._is_session_ours = False
        self._holds_right = False

    def run(self) -> None:
        """Make every check of the controller.

        Raises:
            DeviceError: The controller stopped answering as it should.
        """
        self._open_session()
        state = self.panel.state()
        self._check_switches(state)
        self._check_alarm(state)
        self._check_right(state)
        self._check_service(state)
        self._check_programs()
        self._check_parameters()

    def close(self) -> None:
        """Give back what was taken.

        Raises:
            DeviceError: The controller does not let go.
        """
        if self._holds_right:
            self._holds_right = False
            self.panel.give_right_back()
        if self._is_session_ours:
            self._is_session_ours = False
            self.panel.close_session()

    def take_right(self) -> bool:
        """Take the operation right if it is free; return whether it is held now."""
        if not (self._holds_right or self._patient.is_in_service):
            self._holds_right = self._dialogue.exchange("CNTLON").is_accepted
        return self._holds_right or self._patient.is_in_service

    def switch_output(self, bit: int, *, is_on: bool) -> bool:
        """Switch one output and leave its neighbours; return what it reads afterwards.

        Raises:
            DeviceError: The controller refuses.
        """
        word = self.panel.outputs(bit)
        self.panel.set_outputs(bit, word | 1 if is_on else word & ~1)
        return self.reads_on(bit)

    def reads_on(self, bit: int) -> bool:
        """Return whether an output reads on."""
        return bool(self.panel.outputs(bit) & 1)

    def stands_at(self, joints_deg: Sequence[float]) -> bool:
        """Return whether the joints stand at these angles; False where that cannot be told."""
        try:
            here = records.joints_of(self.panel.axes("JPOSF"))
        except (DeviceError, LinkError):
            return False
        pairs = zip(here.values, joints_deg, strict=True)
        return all(abs(is_deg - want_deg) <= _ASIDE_DEG for is_deg, want_deg in pairs)

    def _open_session(self) -> None:
        reply = self._dialogue.exchange("STATE")
        if not reply.is_accepted and reply.error == tables.NOT_OPEN:
            self._is_session_ours = True
        identity = self.panel.open_session(_CLIENT)
        wanted = _ROBOTS[self._profile.model]
        if identity.robot.upper() != wanted:
            self._notes.find(
                "arm-wrong-robot",
                "arm",
                f"the controller drives an arm of type {identity.robot}, the profile has {wanted}",
                f"identity: {identity}",
            )
        else:
            self._notes.fine("arm", f"identity: {identity}")

    def _check_switches(self, state: records.FullState) -> None:
        notes = self._notes
        sources = self.panel.stop_sources()
        told = f"stop sources {sources.stops:X}, emergency sources {sources.emergencies:X}"
        found = False
        for bit, alarm, cause, words in _EMERGENCIES:
            if sources.emergencies & bit or state.error == alarm:
                found = True
                notes.find(
                    cause, "arm", f"the emergency stop at {words} is pressed", *_facts(state, told)
                )
        if not found and state.stop & tables.Stop.EMERGENCY:
            problem = "an emergency stop is pressed; the controller does not tell which"
            notes.find("arm-emergency-stop-external", "arm", problem, *_facts(state, told))
            found = True
        if not found:
            notes.fine("arm", "no emergency stop is pressed")
        if state.run & Run.TEACH:
            notes.find("arm-key-at-teach", "arm", "the key switch stands at TEACH", *_facts(state))
        else:
            notes.fine("arm", "the key stands at AUTOMATIC")
        if state.run & Run.MACHINE_LOCK:
            notes.find("arm-machine-lock", "arm", "machine lock is on", *_facts(state))
        if found:
            return
        if sources.stops & _PENDANT and not state.run & Run.TEACH:
            problem = "the teach pendant is enabled and holds the arm"
            notes.find("arm-pendant-enabled", "arm", problem, *_facts(state, told))
        for bit, words in _STOPPERS:
            if sources.stops & bit:
                problem = f"a stop signal of {words} is on"
                notes.find("arm-stop-signal", "arm", problem, *_facts(state, told))

    def _check_alarm(self, state: records.FullState) -> None:
        number = state.error or self.panel.alarm()
        if not number:
            self._notes.fine("arm", "no alarm is active")
            return
        if number in _EMERGENCY_ALARMS:
            return
        text, hint = self._dialogue.explain(number)
        entry = tables.describe(number)
        severity = "L" if entry is None else entry.severity
        cause = {"H": "arm-alarm-high", "L": "arm-alarm-low", "C": "arm-alarm-caution"}[severity]
        self._notes.find(
            cause,
            "arm",
            f"alarm {number} is active: {text}",
            f"alarm {number}, class {severity}",
            fix=f"{hint}; then reset the alarm at the panel",
        )

    def _check_right(self, state: records.FullState) -> None:
        notes = self._notes
        if self._patient.is_in_service:
            if state.run & Run.OPERATION_ENABLED:
                notes.fine("arm", "the operation right is ours")
            elif not self._is_stopped():
                problem = "the operation right was taken away in the middle of work"
                notes.find("arm-right-held", "arm", problem, *_facts(state))
            return
        if state.run & Run.RUNNING:
            problem = f"program {state.slot_program or state.program} runs in the controller"
            notes.find("arm-program-running", "arm", problem, *_facts(state))
            return
        if self._is_stopped():
            notes.skip("arm", "operation right", "an emergency stop, the key or the pendant")
            return
        reply = self._dialogue.exchange("CNTLON")
        if reply.is_accepted:
            self._holds_right = True
            notes.fine("arm", "the operation right is free")
        elif reply.error == tables.NOT_AUTOMATIC:
            problem = "the right is refused as not automatic, though the key is: the pendant is on"
            fact = f"CNTLON refused with {reply.error}"
            notes.find("arm-pendant-enabled", "arm", problem, *_facts(state, fact))
        elif not notes.has("arm-alarm-high", "arm-alarm-low"):
            problem = "somebody else holds the operation right"
            fact = f"CNTLON refused with {reply.error}"
            notes.find("arm-right-held", "arm", problem, *_facts(state, fact))

    def _check_service(self, state: records.FullState) -> None:
        """Look at what is on only while the cell works."""
        if not self._patient.is_in_service:
            return
        notes = self._notes
        calm = not (self._is_stopped() or notes.has("arm-alarm-high", "arm-alarm-low"))
        if not state.run & Run.SERVO_ON and calm and not notes.has("arm-right-held"):
            notes.find("arm-servo-off", "arm", "the servos are off", *_facts(state))
        elif state.run & Run.SERVO_ON:
            notes.fine("arm", "the servos are on")
        if state.override_percent < 100:
            notes.find(
                "arm-override-low",
                "arm",
                f"the override is {state.override_percent} %",
                f"override {state.override_percent} %",
            )

    def _check_programs(self) -> None:
        names = self.panel.programs()
        if self._program in names:
            self._notes.fine("arm", f"program {self._program} is there")
            return
        listed = ", ".join(names) or "none"
        problem = f"the controller has no program {self._program}, which direct commands need"
        self._notes.find("arm-program-missing", "arm", problem, f"programs: {listed}")

    def _check_parameters(self) -> None:
        arm = self._profile
        pairs = zip(arm.joint_min_deg, arm.joint_max_deg, strict=True)
        limits = [limit for pair in pairs for limit in pair]
        self._compare("MEJAR", limits, "arm-limits-differ", "joint limits")
        self._compare("MEXTL", list(arm.tool_mm), "arm-tool-differs", "tool")

    def _compare(self, parameter: str, wanted: list[float], cause: str, words: str) -> None:
        try:
            printed = self.panel.parameter(parameter)
            told = [float(value) for value in printed[: len(wanted)]]
        except ValueError:
            self._notes.skip("arm", words, f"parameter {parameter} holds what is no number")
            return
        except DeviceError as error:
            self._notes.skip("arm", words, f"parameter {parameter}: {error.problem}")
            return
        if len(told) == len(wanted) and all(
            abs(a - b) <= _SAME for a, b in zip(told, wanted, strict=True)
        ):
            self._notes.fine("arm", f"{words} agree with the controller's {parameter}")
            return
        shown = ", ".join(f"{value:g}" for value in wanted)
        self._notes.find(
            cause,
            "arm",
            f"the {words} of the profile are not those of the controller",
            f"controller's {parameter}: {', '.join(printed)}",
            f"profile: {shown}",
        )

    def _is_stopped(self) -> bool:
        return self._notes.has(
            "arm-emergency-stop-panel",
            "arm-emergency-stop-pendant",
            "arm-emergency-stop-external",
            "arm-key-at-teach",
            "arm-pendant-enabled",
        )


def _facts(state: records.FullState, *more: str) -> tuple[str, ...]:
    """Return the state's bits as facts, so that anybody can check the judgement."""
    return f"run status {state.run:02X}, stop status {state.stop:02X}", *more
