"""An arm on a Mitsubishi MELFA controller (CR1, CR2, CRnD), over any link.

How a move goes: the target is put into a variable, the move is started and
returns at once; after the expected time the run bit is polled until it falls;
then the alarm and the position are checked, because a move that an operator
stopped ends without an error. Every wait has a deadline, and every failure
stops the arm before it is reported. When the answer to a start is lost, state
and place tell whether the arm has started; only an arm that stands where it stood
is told a second time.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from cell.clock import Clock
from cell.devices.arm import ArmState, Interpolation
from cell.drivers.melfa_r3 import records
from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.drivers.melfa_r3.dialogue import LOST, Dialogue, OnRepeat, told
from cell.drivers.melfa_r3.editor import ProgramEditor
from cell.drivers.melfa_r3.panel import ControlPanel
from cell.drivers.melfa_r3.settings import ArmSettings
from cell.drivers.melfa_r3.statements import SetFigure, print_joints, print_position
from cell.drivers.melfa_r3.tables import BUSY, Run, Stop
from cell.errors import CellError, DeviceError, DeviceTimeout, MotionInterrupted
from cell.geometry import JointPositions, Pose
from cell.links.base import Link
from cell.links.errors import is_lasting

_log = logging.getLogger(__name__)

_RUNNING = int(Run.RUNNING)
_SERVO_ON = int(Run.SERVO_ON)
_TEACH = int(Run.TEACH)
_EMERGENCY = int(Stop.EMERGENCY)
_ENABLED = int(Run.OPERATION_ENABLED)

_INTERRUPTED_HINT = "see whether somebody pressed a stop; check the path is free, then start again"


def _log_warning(text: str) -> None:
    _log.warning("%s", text)


def _log_repeat(device: str, problem: str) -> None:
    _log.warning("%s: asked again: %s", device, problem)


class MelfaArm:
    """The arm, from bring-up to shut-down; used by one thread at a time.

    The link stays open when the arm closes, so that the arm may be opened again;
    whoever made the link closes it.
    """

    def __init__(
        self,
        link: Link,
        clock: Clock,
        settings: ArmSettings,
        *,
        on_warning: Callable[[str], None] = _log_warning,
        on_repeat: OnRepeat = _log_repeat,
    ) -> None:
        self._clock = clock
        self._settings = settings
        self._dialogue = Dialogue(link, clock, settings, on_repeat)
        self._on_warning = on_warning
        self._is_open = False
        self._stood: Pose | JointPositions | None = None
        self.panel = ControlPanel(self._dialogue)
        self.editor = ProgramEditor(self._dialogue)

    def open(self) -> str:
        """Take the arm into service with its servos on; return the identity.

        Opening an open arm brings it into the same state again.

        Raises:
            DeviceError: The key switch is at TEACH, an emergency stop is pressed, an
                alarm stays, the right is held elsewhere, or the controller refuses.
            DeviceTimeout: The controller does not answer or the servos do not come on.
        """
        if not self._settings.was_tried_on_hardware:
            self._on_warning(
                f"{self._dialogue.device}: this driver was never tried on hardware; "
                "keep a hand at the emergency stop"
            )
        identity = self.panel.open_session(self._settings.client)
        try:
            self._require_automatic()
            self._clear_alarm()
            self._take_right()
            self._select_program()
            self.panel.set_override(self._settings.override_percent)
            self._switch_servos_on()
            self.set_speed(self._settings.linear_speed_mm_s, self._settings.joint_speed_percent)
        except CellError:
            self._let_go()
            raise
        self._is_open = True
        return str(identity)

    def close(self) -> None:
        """Stop, switch the servos off, give control back and end the session.

        Every step is tried even when one fails; closing a closed arm does nothing.

        Raises:
            DeviceError: A step failed; the first failure is the one raised.
        """
        if not self._is_open:
            return
        self._is_open = False
        failure = self._let_go()
        if failure is not None:
            raise failure

    def set_speed(self, speed_mm_s: float, joint_percent: float) -> None:
        """Set the speed of straight moves and the share of full speed of joint moves.

        Raises:
            DeviceError: A figure is out of range, or the controller refuses.
        """
        if not (speed_mm_s > 0 and 0 < joint_percent <= 100):
            raise DeviceError(
                self._dialogue.device,
                f"a speed of {speed_mm_s:g} mm/s and {joint_percent:g} % was asked for",
                hint="use more than 0 mm/s and more than 0 to 100 %",
            )
        self.panel.execute(SetFigure("SPD", (speed_mm_s,)))
        self.panel.execute(SetFigure("JOVRD", (joint_percent,)))

    def move(
        self,
        pose: Pose,
        *,
        interpolation: Interpolation,
        posture: int,
        turns: int = 0,
        expected_s: float = 0.0,
    ) -> None:
        """Move the tool point to `pose` and return when it is there.

        Raises:
            DeviceError: The controller refuses, an alarm ends the move, or it ends
                elsewhere; the arm stands still then.
            DeviceTimeout: The move does not end in time; the arm was stopped.
        """
        dialogue = self._dialogue
        dialogue.ask_when_free("EXECP1=", print_position(pose, (posture, turns)))
        self._start("EXECMVS P1" if interpolation == "linear" else "EXECMOV P1", pose)
        if expected_s > 0:
            self._clock.sleep(expected_s + self._settings.ramp_s)
            if self._stands_at(pose):
                self._stood = pose
                return
        self._await_end(expected_s, pose)
        here = self.read_pose()
        away_mm = _away_mm(here, pose)
        if away_mm > self._settings.arrival_mm:
            raise MotionInterrupted(
                dialogue.device,
                f"the move to {pose} ended at {here}, {away_mm:.1f} mm away, without an alarm",
                hint=_INTERRUPTED_HINT,
            )

    def _stands_at(self, pose: Pose) -> bool:
        """Return whether the tool point is at a pose and no alarm is active.

        One question tells both, so a move that ends when expected costs no other.
        """
        reply = self._dialogue.request("PPOSF")
        if not reply.is_accepted or reply.has_alarm:
            return False
        try:
            here = records.pose_of(records.parse_axes(reply.data))
        except GarbledMessage as error:
            self._dialogue.on_repeat(self._dialogue.device, error.problem)
            return False
        return _away_mm(here, pose) <= self._settings.arrival_mm

    def _start(self, command: str, target: Pose | JointPositions) -> None:
        """Start a move; when the answer is lost, find out first whether it has started.

        Raises:
            DeviceError: The controller refuses, or nobody knows where the arm stood.
            DeviceTimeout: It is busy for too long, or silent.
        """
        stood, self._stood = self._stood, None
        try:
            self._dialogue.ask_when_free(command)
        except LOST as error:
            is_busy = isinstance(error, DeviceTimeout) and error.code == BUSY
            if stood is None or is_busy or is_lasting(error):
                raise
            is_waiting = self._still_waits(stood, target)
            self._dialogue.on_repeat(
                self._dialogue.device,
                f"{told(error)}; the arm {'has not moved' if is_waiting else 'has started'}",
            )
            if is_waiting:
                self._dialogue.ask_when_free(command)

    def _still_waits(self, stood: Pose | JointPositions, target: Pose | JointPositions) -> bool:
        """Return whether the arm stands where it stood, and that is not where it is to go."""
        state = self._sure_state()
        if state.run & _RUNNING or state.error:
            return False
        return self._is_at(stood) and not self._is_at(target)

    def _is_at(self, place: Pose | JointPositions) -> bool:
        if isinstance(place, Pose):
            return _away_mm(self.read_pose(), place) <= self._settings.arrival_mm
        here = self.read_joints().values
        return max(abs(a - b) for a, b in zip(here, place.values, strict=True)) <= (
            self._settings.arrival_deg
        )

    def move_joints(self, joints: JointPositions, *, expected_s: float = 0.0) -> None:
        """Move every joint to its angle and return when all are there.

        Raises:
            DeviceError: The controller refuses, an alarm ends the move, or it ends
                elsewhere; the arm stands still then.
            DeviceTimeout: The move does not end in time; the arm was stopped.
        """
        self._dialogue.ask_when_free("EXECJ1=", print_joints(joints))
        self._start("EXECMOV J1", joints)
        if expected_s > 0:
            self._clock.sleep(expected_s + self._settings.ramp_s)
        self._await_end(expected_s, joints)
        self._require_joints(joints)
        self._stood = joints

    def move_to_safe_position(self, *, expected_s: float = 0.0) -> None:
        """Move to the controller's own safe position (parameter JSAFE).

        Raises:
            DeviceError: The controller refuses, or an alarm ends the move.
            DeviceTimeout: The move does not end in time; the arm was stopped.
        """
        self._dialogue.ask_when_free("MOVSP")
        if expected_s > 0:
            self._clock.sleep(expected_s + self._settings.ramp_s)
        self._await_end(expected_s, "the safe position")

    def read_pose(self) -> Pose:
        """Return where the tool point is."""
        pose = self._dialogue.read(_pose, "PPOSF")
        self._stood = pose
        return pose

    def read_joints(self) -> JointPositions:
        """Return the joint angles."""
        joints = self._dialogue.read(_joints, "JPOSF")
        self._stood = joints
        return joints

    def read_state(self) -> ArmState:
        """Return the controller's state; a number of an alarm comes with its text."""
        state = self.panel.state()
        alarm = state.error or self.panel.alarm()
        return ArmState(
            is_servo_on=bool(state.run & _SERVO_ON),
            is_moving=bool(state.run & _RUNNING),
            is_automatic=not state.run & _TEACH,
            is_emergency_stopped=bool(state.stop & _EMERGENCY),
            alarm=alarm,
            alarm_text=self.panel.alarm_text(alarm) if alarm else "",
            override_percent=state.override_percent,
            has_right=bool(state.run & _ENABLED),
        )

    def stop(self) -> None:
        """Stop any motion now; sent at once, whatever was asked before.

        Raises:
            DeviceError: The controller did not accept or did not answer.
        """
        reply = self._dialogue.insist("STOP")
        if not reply.is_accepted:
            raise self._dialogue.refusal("STOP", reply)

    def reset_alarm(self) -> None:
        """Clear an active alarm whose cause is gone.

        Servos that the alarm has switched off stay off until the arm is opened again.

        Raises:
            DeviceError: The alarm stays; the text names its cause.
        """
        self._clear_alarm()

    def set_output(self, bit: int, *, is_on: bool) -> None:
        """Switch one output of the controller."""
        self.panel.switch_output(bit, is_on=is_on)

    def read_output(self, bit: int) -> bool:
        """Return whether one output is on."""
        return bool(self.panel.outputs(bit) & 1)

    def _require_automatic(self) -> None:
        state = self.panel.state()
        if state.run & _TEACH:
            raise DeviceError(
                self._dialogue.device,
                "the controller's key switch stands at TEACH",
                hint="turn it to AUTO and switch the teach pendant off, then open the arm again",
            )

    def _clear_alarm(self) -> None:
        alarm = self.panel.alarm()
        if not alarm:
            return
        self.panel.reset_alarm()
        alarm = self.panel.alarm()
        if alarm:
            text, hint = self._dialogue.explain(alarm)
            raise DeviceError(
                self._dialogue.device,
                f"the alarm cannot be reset while its cause remains: {text}",
                code=alarm,
                hint=hint,
            )

    def _take_right(self) -> None:
        for _ in range(self._settings.control_tries):
            reply = self._dialogue.request("CNTLON")
            if reply.is_accepted:
                return
            self._clock.sleep(self._settings.control_pause_s)
        raise self._dialogue.refusal("CNTLON", reply)

    def _select_program(self) -> None:
        self.panel.reset_program()
        self.panel.load_program(self._settings.program)

    def _switch_servos_on(self) -> None:
        self.panel.switch_servos(is_on=True)
        deadline_s = self._clock.now_s() + self._settings.servo_timeout_s
        state = self.panel.short_state()
        while not state.run & _SERVO_ON:
            if state.error:
                text, hint = self._dialogue.explain(state.error)
                raise DeviceError(
                    self._dialogue.device,
                    f"an alarm kept the servos off: {text}",
                    code=state.error,
                    hint=hint,
                )
            if self._clock.now_s() >= deadline_s:
                raise DeviceTimeout(
                    self._dialogue.device,
                    f"the servos did not come on within {self._settings.servo_timeout_s:g} s",
                    hint="see the controller's panel; check the safety circuit",
                )
            self._clock.sleep(self._settings.servo_poll_s)
            state = self.panel.short_state()

    def _await_end(self, expected_s: float, target: Pose | JointPositions | str) -> None:
        """Wait until the move is over; on an alarm or a time-out stop the arm and raise."""
        clock = self._clock
        deadline_s = clock.now_s() + self._settings.move_timeout_s
        while True:
            state = self._sure_state()
            if state.error:
                self.stop()
                text, hint = self._dialogue.explain(state.error)
                raise DeviceError(
                    self._dialogue.device,
                    f"an alarm ended the move to {target}: {text}",
                    code=state.error,
                    hint=hint,
                )
            if not state.run & _RUNNING:
                return
            if clock.now_s() >= deadline_s:
                self.stop()
                raise DeviceTimeout(
                    self._dialogue.device,
                    f"the move to {target} did not end within "
                    f"{expected_s + self._settings.move_timeout_s:g} s and was stopped",
                    hint="look whether something holds the arm; check speed and override",
                )
            clock.sleep(self._settings.poll_s)

    def _sure_state(self) -> records.ShortState:
        """Return the state; an alarm in it is asked for twice, for a bit may have turned over."""
        state = self.panel.short_state()
        if state.error:
            again = self.panel.short_state()
            if again.error != state.error:
                self._dialogue.on_repeat(
                    self._dialogue.device, f"alarm {state.error} was told once and not again"
                )
            state = again
        return state

    def _require_joints(self, joints: JointPositions) -> None:
        here = self.read_joints()
        for number, (is_deg, want_deg) in enumerate(
            zip(here.values, joints.values, strict=True), 1
        ):
            if abs(is_deg - want_deg) > self._settings.arrival_deg:
                raise MotionInterrupted(
                    self._dialogue.device,
                    f"the move ended with J{number} at {is_deg:.2f} deg instead of "
                    f"{want_deg:.2f} deg, without an alarm",
                    hint=_INTERRUPTED_HINT,
                )

    def _let_go(self) -> CellError | None:
        """Try every step of the shut-down; return the first failure."""
        failure: CellError | None = None
        for step in (
            self.stop,
            lambda: self.panel.switch_servos(is_on=False),
            self.panel.give_right_back,
            self.panel.close_session,
        ):
            try:
                step()
            except CellError as error:
                failure = failure or error
        return failure


def _pose(data: str) -> Pose:
    return records.pose_of(records.parse_axes(data))


def _joints(data: str) -> JointPositions:
    return records.joints_of(records.parse_axes(data))


def _away_mm(here: Pose, there: Pose) -> float:
    """Return the largest difference of two poses' coordinates."""
    return max(
        abs(here.x_mm - there.x_mm), abs(here.y_mm - there.y_mm), abs(here.z_mm - there.z_mm)
    )
