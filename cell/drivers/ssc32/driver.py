"""The Lynx arm on an SSC-32 servo controller.

The controller knows pulse widths, not angles, and it measures nothing: what it tells is what
it was told. It has no alarms, no emergency stop and no switch for the servos' supply, whose
loss it does not notice. What follows from that:

* Every joint angle in here is a commanded one, to the last microsecond. Where the arm really
  stands differs by the servos' errors and by sag, and only a camera can tell.
* Orders are not answered, so every motion begins, goes on and ends with a question for the
  pulses. A controller that was restarted has none (0): it must not be sent a move then,
  because the first pulse after power-up makes a servo jump to it at full speed.
* Every order but the first carries each servo's greatest speed besides the time, so that the
  controller itself keeps an arm from leaping that is not where the driver thinks.
* Straight lines are cut into short joint moves here, planned and checked as a whole before
  the first is sent, and streamed in step with the clock. A stop falls between two of them.
* After `close` the servos go on holding the arm. Without pulses it would fall.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence

from cell.clock import Clock
from cell.devices.arm import ArmState, Interpolation
from cell.drivers.ssc32.dialogue import Dialogue, log_repeat
from cell.drivers.ssc32.joints import ServoJoints
from cell.drivers.ssc32.line import straight_line
from cell.drivers.ssc32.panel import ServoPanel
from cell.drivers.ssc32.sending import MoveSender
from cell.drivers.ssc32.settings import Ssc32Settings
from cell.drivers.ssc32.tables import CHANNELS
from cell.errors import DeviceError, DeviceRestarted, UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.kinematics.lynx import LynxArm
from cell.links.base import Link
from cell.stop import StopToken

_log = logging.getLogger(__name__)

FIRST_ORDER = (1, 2, 3, 4, 0)
"""Joints of the first pose, one after the other: the arm is lifted before it is turned."""

_LIMIT_SLACK_DEG = 1e-6
_TURN_STEP_DEG = 2.0
_UNPROVEN = "this driver was never tried on hardware; keep a hand at the servo supply's switch"
_BLIND = (
    "this controller has no emergency stop and no alarms, and it measures nothing: positions "
    "are commanded ones, and the arm is held after closing, too; only the servo supply's "
    "switch lets it go"
)


def _log_warning(text: str) -> None:
    _log.warning("%s", text)


class Ssc32Arm:
    """An `Arm` of five servos; used by one thread at a time.

    The link stays open when the arm closes; whoever made it closes it.

    Args:
        link: The line to the controller.
        clock: What deadlines are measured with and segments are sent by.
        settings: Figures of the cell and patience.
        kinematics: The arm's geometry and limits.
        on_warning: Told what a technician should know although nothing failed.
        on_repeat: Told device and problem when a question is asked again.
        token: Asked, if given, during every motion; a stop ends it.
    """

    def __init__(
        self,
        link: Link,
        clock: Clock,
        settings: Ssc32Settings,
        kinematics: LynxArm,
        *,
        on_warning: Callable[[str], None] = _log_warning,
        on_repeat: Callable[[str, str], None] = log_repeat,
        token: StopToken | None = None,
    ) -> None:
        self._clock = clock
        self._settings = settings
        self._kinematics = kinematics
        self._device = link.name
        self._on_warning = on_warning
        self._token = token
        self._outputs: dict[int, bool] = {}
        self._identity = ""
        self._is_first_pose_confirmed = False
        self._linear_speed_mm_s = settings.linear_speed_mm_s
        self._joint_share = settings.joint_speed_percent / 100.0
        self.panel = ServoPanel(
            Dialogue(link, clock, link.name, settings.line, on_repeat=on_repeat)
        )
        self._joints = ServoJoints(self.panel, clock, link.name, settings, kinematics)
        self._sender = MoveSender(
            self.panel,
            self._joints,
            clock,
            link.name,
            settings,
            kinematics.joint_speed,
            check=self._check_token,
            on_warning=on_warning,
        )

    # In and out of service

    def confirm_first_pose(self) -> None:
        """Say that the arm was put into its rest pose by hand; holds for the next `open`."""
        self._is_first_pose_confirmed = True

    def open(self) -> str:
        """Take the arm into service and return the controller's identity.

        A controller that was never sent a move since power-up does not know where the arm
        is, and its first move jumps there at full speed, whatever speed is asked for. So the
        first pose is the rest pose, into which somebody should have put the arm by hand, and
        it is taken one joint after the other. By the setting `first_pose` it is either
        announced by a warning some seconds ahead, or refused until `confirm_first_pose`.

        Raises:
            DeviceError: The first pose is not confirmed, or an answer is strange.
            DeviceTimeout: The controller does not answer.
            Stopped: A stop was asked for while the first pose was announced or taken.
        """
        is_in_service = bool(self._identity) and not self._joints.were_lost
        if is_in_service and all(self._joints.told_on_the_way_us()):
            return self._identity
        self._identity = ""
        if not self._settings.was_tried_on_hardware:
            self._on_warning(f"{self._device}: {_UNPROVEN}")
        self._on_warning(f"{self._device}: {_BLIND}")
        self.panel.cancel_line()
        self.stop()
        identity = self._read_version()
        offsets = [(s.channel, s.offset_us) for s in self._settings.servos if s.offset_us]
        if offsets:
            self.panel.set_offsets(offsets)
        pulses_us = self._joints.told_us()
        if all(pulses_us):
            self._joints.adopt(pulses_us)
        else:
            self._take_first_pose(pulses_us)
        self.set_speed(self._settings.linear_speed_mm_s, self._settings.joint_speed_percent)
        self._identity = identity
        self._joints.were_lost = False
        return identity

    @property
    def wants_confirmation(self) -> bool:
        """Whether a first pose is refused until `confirm_first_pose`."""
        return self._settings.first_pose == "confirmed"

    def first_pose_needed(self) -> str:
        """Return what the next `open` will move, as a sentence; empty if it moves nothing.

        Raises:
            DeviceTimeout: The controller does not answer.
        """
        pulses_us = self._joints.told_on_the_way_us()
        if all(pulses_us):
            return ""
        rest = JointPositions(self._settings.rest_deg)
        return (
            f"{self._joints.unpulsed(pulses_us)}: the arm's pose is unknown. Its joints jump at "
            f"full speed to the rest pose {rest} deg, one after the other"
        )

    def reopen(self) -> None:
        """Bring the arm back into service where it stands; nothing moves.

        Raises:
            DeviceRestarted: The controller was restarted, and the first pose would move the arm.
            DeviceError: As `open`.
        """
        pulses_us = self._joints.told_on_the_way_us()
        if not all(pulses_us):
            raise DeviceRestarted(
                self._device,
                self._joints.unpulsed(pulses_us),
                hint="support the arm, put it into its rest pose, then open it again",
            )
        self.open()

    def close(self) -> None:
        """Stop; the servos go on holding the arm. Closing a closed arm does nothing.

        Raises:
            DeviceTimeout: The controller does not answer.
        """
        if self._identity:
            self._identity = ""
            self._is_first_pose_confirmed = False
            self.stop()

    # Motion

    def set_speed(self, speed_mm_s: float, joint_percent: float) -> None:
        """Set the speed of straight moves and the share of full speed of joint moves.

        The controller has no such settings: nothing is sent.

        Raises:
            DeviceError: A figure is out of range.
        """
        if not (speed_mm_s > 0 and 0 < joint_percent <= 100):
            raise DeviceError(
                self._device,
                f"a speed of {speed_mm_s:g} mm/s and {joint_percent:g} % was asked for",
                hint="use more than 0 mm/s and more than 0 to 100 %",
            )
        self._linear_speed_mm_s = speed_mm_s
        self._joint_share = joint_percent / 100.0

    def move(
        self,
        pose: Pose,
        *,
        interpolation: Interpolation,
        posture: int,
        turns: int = 0,
        expected_s: float = 0.0,
    ) -> None:
        """Move the tool point to `pose` and return when the servos are told to be there.

        `turns` and `expected_s` change nothing: no joint turns further than once, and how
        long it takes is known here.

        Raises:
            DeviceError: The pose or a point on the way to it is out of range (nothing was
                sent), or the controller lost its pulses.
            DeviceTimeout: The controller does not answer or does not finish.
            Stopped: A stop was asked for; the arm stands still.
        """
        if not all(math.isfinite(v) for v in _figures(pose)):
            raise DeviceError(self._device, f"{pose} is no position")
        start = self._ready()
        try:
            if interpolation == "linear":
                stances = straight_line(
                    self._kinematics,
                    start,
                    pose,
                    posture,
                    step_mm=self._linear_speed_mm_s * self._settings.segment_s,
                    step_deg=_TURN_STEP_DEG,
                )
            else:
                stances = [self._kinematics.solve(pose, posture, start)]
        except UnreachablePose as error:
            raise DeviceError(
                self._device,
                f"a {interpolation} move to {pose} is out of range: {error}",
                hint="nothing was sent; the arm stands where it stood",
            ) from error
        if interpolation == "linear":
            self._sender.stream(start, stances)
        else:
            self._sender.go(start, stances[0], self._joint_share)

    def move_joints(self, joints: JointPositions, *, expected_s: float = 0.0) -> None:
        """Move every joint to its angle and return when the servos are told to be there.

        Raises:
            DeviceError: An angle is out of range, or the controller lost its pulses.
            DeviceTimeout: The controller does not answer or does not finish.
            Stopped: A stop was asked for; the arm stands still.
        """
        arm = self._kinematics
        if len(joints.values) != len(self._joints.channels):
            raise DeviceError(
                self._device,
                f"{joints} is no position: the arm has {len(self._joints.channels)} joints",
            )
        for number, (value, low, high) in enumerate(
            zip(joints.values, arm.joint_min, arm.joint_max, strict=True), 1
        ):
            if not low - _LIMIT_SLACK_DEG <= value <= high + _LIMIT_SLACK_DEG:
                raise DeviceError(
                    self._device,
                    f"J{number} at {value:.2f} deg is out of range",
                    hint=f"allowed are {low:.2f} to {high:.2f} deg",
                )
        self._sender.go(self._ready(), joints, self._joint_share)

    def stop(self) -> None:
        """Stop any motion now; works in every state.

        Late firmware is sent STOP. Any other is told to go where its pulses are at the
        moment, which may be 10 us (about 1 deg) beside. Servos without pulses are left alone.

        Raises:
            DeviceTimeout: The controller does not answer.
        """
        self._joints.stop()

    # What it tells

    def read_joints(self) -> JointPositions:
        """Return the commanded joint angles; nothing measures where they really are.

        Raises:
            DeviceError: The controller was restarted and does not know.
            DeviceTimeout: It does not answer.
        """
        return self._joints.standing()

    def read_pose(self) -> Pose:
        """Return where the tool point is for the commanded joint angles.

        Raises:
            DeviceError: The controller was restarted and does not know.
            DeviceTimeout: It does not answer.
        """
        return self._kinematics.forward(self._joints.standing())

    def read_state(self) -> ArmState:
        """Return what can be told: whether there are pulses, and whether they change.

        A servo that gets pulses counts as on, although nothing tells whether its supply is.
        An emergency stop or an alarm is never reported, because there is none.
        """
        pulses_us = self._joints.told_on_the_way_us()
        return ArmState(
            is_servo_on=all(pulses_us),
            is_moving=self.panel.is_moving(),
            is_automatic=True,
            is_emergency_stopped=False,
            alarm=0,
            alarm_text=self._joints.advice(pulses_us),
            override_percent=100,
        )

    def reset_alarm(self) -> None:
        """Do nothing but see that the controller is there: it has no alarms."""
        self.panel.is_moving()

    def set_output(self, bit: int, *, is_on: bool) -> None:
        """Switch one channel that drives no servo.

        Raises:
            DeviceError: There is no such channel, or a servo is on it.
            DeviceTimeout: The controller does not answer.
        """
        self._require_output(bit)
        self.panel.switch_output(bit, is_on=is_on)
        self._outputs[bit] = is_on

    def read_output(self, bit: int) -> bool:
        """Return whether an output is on: as it was switched here, if it was.

        Raises:
            DeviceError: It was not switched since this driver was made, and the controller
                does not tell.
            DeviceTimeout: The controller does not answer.
        """
        self._require_output(bit)
        self.panel.is_moving()
        if bit not in self._outputs:
            raise DeviceError(
                self._device,
                f"output {bit} is not known: it was not switched yet, and the controller "
                "does not tell its outputs",
                hint="switch it once",
            )
        return self._outputs[bit]

    # Inside

    def _read_version(self) -> str:
        try:
            return f"Lynx on {self.panel.version()}"
        except DeviceError as error:
            # What VER answers was never seen; an old firmware may not know it at all.
            self._on_warning(f"{error}; going on without the version")
            return "Lynx on an SSC-32 of unknown version"

    def _take_first_pose(self, pulses_us: Sequence[int]) -> None:
        settings = self._settings
        rest = JointPositions(settings.rest_deg)
        missing = self._joints.unpulsed(pulses_us)
        if settings.first_pose == "confirmed" and not self._is_first_pose_confirmed:
            raise DeviceError(
                self._device,
                f"{missing}, so the arm's pose is unknown and its first move jumps",
                hint=f"put the arm by hand near its rest pose {rest} deg and confirm that",
            )
        when = "now" if self._is_first_pose_confirmed else f"in {settings.announce_s:g} s"
        self._on_warning(
            f"{self._device}: {missing}; {when} the joints jump at full speed to the rest pose "
            f"{rest} deg, one after the other. Put the arm there by hand, or stand clear"
        )
        if not self._is_first_pose_confirmed:
            self._sleep(settings.announce_s)
        self._is_first_pose_confirmed = False
        self._joints.forget()
        targets = self._joints.pulses(rest)
        for index in FIRST_ORDER:
            if pulses_us[index] == 0:
                self._check_token()
                self._joints.send_first(index, targets[index])
                self._sleep(settings.first_joint_s)
        now_us = self._joints.told_us()
        if not all(now_us):
            raise DeviceError(
                self._device, f"the first pose was not taken: {self._joints.unpulsed(now_us)}",
                hint="check the controller's supply",
            )  # fmt: skip
        self._joints.adopt(
            tuple(
                target if was == 0 else now
                for was, now, target in zip(pulses_us, now_us, targets, strict=True)
            )
        )

    def _ready(self) -> JointPositions:
        """Return the commanded joint angles of an arm that may move."""
        joints = self._joints.standing()
        if not self._identity or self._joints.were_lost:
            raise DeviceError(self._device, "the arm is not open", hint="open the arm first")
        return joints

    def _require_output(self, bit: int) -> None:
        if not 0 <= bit < CHANNELS:
            raise DeviceError(
                self._device, f"there is no output {bit}", hint=f"allowed are 0 to {CHANNELS - 1}"
            )
        if bit in self._joints.channels or bit in self._settings.other_channels:
            raise DeviceError(
                self._device,
                f"channel {bit} drives a servo and cannot be an output",
                hint="the servo would lose its pulses",
            )

    def _check_token(self) -> None:
        if self._token is not None:
            self._token.check()

    def _sleep(self, duration_s: float) -> None:
        """Let time pass in slices short enough for a stop."""
        slices = max(1, math.ceil(duration_s / self._settings.watch_s))
        for _ in range(slices):
            self._check_token()
            self._clock.sleep(duration_s / slices)


def _figures(pose: Pose) -> tuple[float, ...]:
    return (pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg)
