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
from cell.drivers.ssc32.commands import Move, ServoTarget
from cell.drivers.ssc32.dialogue import Dialogue, log_repeat
from cell.drivers.ssc32.line import straight_line
from cell.drivers.ssc32.panel import ServoPanel, agree
from cell.drivers.ssc32.servo_map import speed_cap_us_s
from cell.drivers.ssc32.settings import Ssc32Settings
from cell.drivers.ssc32.tables import CHANNELS, GREATEST_TIME_MS
from cell.errors import CellError, DeviceError, DeviceTimeout, UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.kinematics.lynx import LynxArm
from cell.links.base import Link
from cell.stop import StopToken

_log = logging.getLogger(__name__)

FIRST_ORDER = (1, 2, 3, 4, 0)
"""Joints of the first pose, one after the other: the arm is lifted before it is turned."""

_MOVING_US = 50
"""How far pulses may change between two questions while the arm moves."""
_HOLD_LOOKS = 25
_HOLD_PAUSE_S = 0.02
_LIMIT_SLACK_DEG = 1e-6
_TURN_STEP_DEG = 2.0
_UNPROVEN = "this driver was never tried on hardware; keep a hand at the servo supply's switch"
_BLIND = (
    "this controller has no emergency stop and no alarms, and it measures nothing: positions "
    "are commanded ones, and the arm is held after closing, too; only the servo supply's "
    "switch lets it go"
)
_OPEN_HINT = "support the arm, then open it again; its first move jumps"


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
        self._channels = tuple(servo.channel for servo in settings.servos)
        self._caps_us_s = tuple(
            speed_cap_us_s(servo.map, low, high, speed, settings.segment_s)
            for servo, low, high, speed in zip(
                settings.servos,
                kinematics.joint_min,
                kinematics.joint_max,
                kinematics.joint_speed,
                strict=True,
            )
        )
        self._sent_us: tuple[int, ...] | None = None
        self._outputs: dict[int, bool] = {}
        self._identity = ""
        self._is_first_pose_confirmed = False
        self._linear_speed_mm_s = settings.linear_speed_mm_s
        self._joint_share = settings.joint_speed_percent / 100.0
        self.panel = ServoPanel(
            Dialogue(link, clock, link.name, settings.line, on_repeat=on_repeat)
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
        if self._identity and all(self._told_on_the_way_us()):
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
        pulses_us = self._told_us()
        if all(pulses_us):
            self._adopt(pulses_us)
        else:
            self._take_first_pose(pulses_us)
        self.set_speed(self._settings.linear_speed_mm_s, self._settings.joint_speed_percent)
        self._identity = identity
        return identity

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
            self._stream(start, stances)
        else:
            self._go(start, stances[0])

    def move_joints(self, joints: JointPositions, *, expected_s: float = 0.0) -> None:
        """Move every joint to its angle and return when the servos are told to be there.

        Raises:
            DeviceError: An angle is out of range, or the controller lost its pulses.
            DeviceTimeout: The controller does not answer or does not finish.
            Stopped: A stop was asked for; the arm stands still.
        """
        arm = self._kinematics
        if len(joints.values) != len(self._channels):
            raise DeviceError(
                self._device, f"{joints} is no position: the arm has {len(self._channels)} joints"
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
        self._go(self._ready(), joints)

    def stop(self) -> None:
        """Stop any motion now; works in every state.

        Late firmware is sent STOP. Any other is told to go where its pulses are at the
        moment, which may be 10 us (about 1 deg) beside. Servos without pulses are left alone.

        Raises:
            DeviceTimeout: The controller does not answer.
        """
        if self._settings.knows_stop:
            self.panel.stop_servos(self._channels)
        is_moving, sent = self.panel.is_moving(), self._sent_us
        pulses_us = self.panel.sure_pulses_us(self._channels, sent, within_us=_MOVING_US)
        # One strange answer must not keep a moving arm from being stopped.
        if not is_moving and (sent is None or agree(sent, pulses_us)):
            return
        held = tuple(
            ServoTarget(channel, pulse, cap)
            for channel, pulse, cap in zip(self._channels, pulses_us, self._caps_us_s, strict=True)
            if pulse
        )
        if held:
            self.panel.move(Move(held))
            self._await_held()
        self._sent_us = pulses_us if all(pulses_us) else None

    def _await_held(self) -> None:
        """Wait until the arm stands that was told to stay where it is."""
        for _ in range(_HOLD_LOOKS):
            if not self.panel.is_moving():
                return
            self._clock.sleep(_HOLD_PAUSE_S)
        raise DeviceTimeout(
            self._device,
            f"still moving {_HOLD_LOOKS * _HOLD_PAUSE_S:g} s after it was told to stop",
            hint="switch the servo supply off; check that nobody else sends to the controller",
        )

    # What it tells

    def read_joints(self) -> JointPositions:
        """Return the commanded joint angles; nothing measures where they really are.

        Raises:
            DeviceError: The controller was restarted and does not know.
            DeviceTimeout: It does not answer.
        """
        return self._standing()

    def read_pose(self) -> Pose:
        """Return where the tool point is for the commanded joint angles.

        Raises:
            DeviceError: The controller was restarted and does not know.
            DeviceTimeout: It does not answer.
        """
        return self._kinematics.forward(self._standing())

    def read_state(self) -> ArmState:
        """Return what can be told: whether there are pulses, and whether they change.

        A servo that gets pulses counts as on, although nothing tells whether its supply is.
        An emergency stop or an alarm is never reported, because there is none.
        """
        pulses_us = self._told_on_the_way_us()
        is_on = all(pulses_us)
        return ArmState(
            is_servo_on=is_on,
            is_moving=self.panel.is_moving(),
            is_automatic=True,
            is_emergency_stopped=False,
            alarm=0,
            alarm_text="" if is_on else f"{self._unpulsed(pulses_us)}; {_OPEN_HINT}",
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
        missing = self._unpulsed(pulses_us)
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
        targets = self._pulses(rest)
        for index in FIRST_ORDER:
            if pulses_us[index] == 0:
                self._check_token()
                self.panel.move(Move((ServoTarget(self._channels[index], targets[index]),)))
                self._sleep(settings.first_joint_s)
        now_us = self.panel.sure_pulses_us(self._channels)
        if not all(now_us):
            raise DeviceError(
                self._device, f"the first pose was not taken: {self._unpulsed(now_us)}",
                hint="check the controller's supply",
            )  # fmt: skip
        self._sent_us = None
        self._adopt(
            tuple(
                target if was == 0 else now
                for was, now, target in zip(pulses_us, now_us, targets, strict=True)
            )
        )

    def _adopt(self, pulses_us: tuple[int, ...]) -> None:
        """Take over what the controller commands, more exactly where it was sent from here."""
        sent = self._sent_us
        if sent is None or not agree(sent, pulses_us):
            self._sent_us = pulses_us

    def _told_us(self) -> tuple[int, ...]:
        """Return the pulses of an arm at rest, believed only if told twice or sent."""
        return self.panel.sure_pulses_us(self._channels, self._sent_us)

    def _told_on_the_way_us(self) -> tuple[int, ...]:
        """Return pulses that may be changing; that there are none is believed if told twice."""
        pulses_us = self.panel.pulses_us(self._channels)
        if all(pulses_us):
            return pulses_us
        return self.panel.sure_pulses_us(self._channels, within_us=_MOVING_US)

    def _standing(self) -> JointPositions:
        """Return the commanded joint angles, asked for now."""
        pulses_us = self._told_us()
        self._require_pulses(pulses_us)
        self._adopt(pulses_us)
        return self._joints(self._sent_us or pulses_us)

    def _ready(self) -> JointPositions:
        """Return the commanded joint angles of an arm that may move."""
        joints = self._standing()
        if not self._identity:
            raise DeviceError(self._device, "the arm is not open", hint="open the arm first")
        return joints

    def _go(self, start: JointPositions, target: JointPositions) -> None:
        """Move all joints together, as fast as the slowest may."""
        slowest_s = max(
            abs(there - here) / (speed * self._joint_share)
            for here, there, speed in zip(
                start.values, target.values, self._kinematics.joint_speed, strict=True
            )
        )
        self._run([(self._pulses(target), max(slowest_s, self._settings.segment_s))], 0)

    def _stream(self, start: JointPositions, stances: list[JointPositions]) -> None:
        """Move through many stances, each a short joint move."""
        segments, here = [], start
        for there in stances:
            slowest_s = max(
                abs(b - a) / speed
                for a, b, speed in zip(
                    here.values, there.values, self._kinematics.joint_speed, strict=True
                )
            )
            segments.append((self._pulses(there), max(slowest_s, self._settings.segment_s)))
            here = there
        every = max(1, round(self._settings.watch_s / self._settings.segment_s))
        self._run(segments, every)

    def _run(self, segments: list[tuple[tuple[int, ...], float]], every: int) -> None:
        """Send moves in step with the clock, watch them, and see them end.

        Args:
            segments: Pulse widths and time of each move.
            every: After how many moves the pulses are asked for; 0 to ask by time.
        """
        for _, duration_s in segments:
            self._require_time(duration_s)
        due_s = self._clock.now_s()
        try:
            for number, (pulses_us, duration_s) in enumerate(segments, 1):
                self._check_token()
                self._send(pulses_us, duration_s)
                now_s = self._clock.now_s()
                # Whoever is late starts a new beat: the servos waited where they were.
                due_s = max(due_s, now_s - self._settings.segment_s) + duration_s
                if every and number % every == 0:
                    self._require_pulses(self._told_on_the_way_us())
                if not every:
                    self._watch(duration_s)
                self._clock.sleep(due_s - self._clock.now_s())
            self._await_end(segments[-1][0])
        except CellError:
            self._stop_after_failure()
            raise

    def _send(self, pulses_us: tuple[int, ...], duration_s: float) -> None:
        targets = tuple(
            ServoTarget(channel, pulse, cap)
            for channel, pulse, cap in zip(self._channels, pulses_us, self._caps_us_s, strict=True)
        )
        self._sent_us = pulses_us
        self.panel.move(Move(targets, max(1, math.ceil(duration_s * 1000.0 - 1e-6))))

    def _watch(self, duration_s: float) -> None:
        """Look at the pulses now and then for as long as a move lasts."""
        for _ in range(int(duration_s / self._settings.watch_s)):
            self._clock.sleep(self._settings.watch_s)
            self._check_token()
            self._require_pulses(self._told_on_the_way_us())

    def _await_end(self, pulses_us: tuple[int, ...]) -> None:
        deadline_s = self._clock.now_s() + self._settings.margin_s
        while self.panel.is_moving():
            self._check_token()
            if self._clock.now_s() >= deadline_s:
                raise DeviceTimeout(
                    self._device,
                    f"the move did not end within {self._settings.margin_s:g} s after its time",
                    hint="check that nobody else sends to the controller",
                )
            self._clock.sleep(self._settings.segment_s)
        self._clock.sleep(self._settings.settle_s)
        now_us = self.panel.sure_pulses_us(self._channels, pulses_us)
        self._require_pulses(now_us)
        if not agree(pulses_us, now_us):
            raise DeviceError(
                self._device,
                f"the move ended at {self._joints(now_us)} deg instead of "
                f"{self._joints(pulses_us)} deg",
                hint="an order was lost on the line, or somebody else sends to the controller",
            )

    def _stop_after_failure(self) -> None:
        """Stop without hiding the failure that led here."""
        try:
            self.stop()
        except CellError as error:
            self._on_warning(f"{error}; the arm could not be told to stop")

    def _pulses(self, joints: JointPositions) -> tuple[int, ...]:
        return tuple(
            min(max(round(servo.map.pulse_us(angle)), servo.min_us), servo.max_us)
            for servo, angle in zip(self._settings.servos, joints.values, strict=True)
        )

    def _joints(self, pulses_us: Sequence[int]) -> JointPositions:
        return JointPositions(
            tuple(
                servo.map.position(pulse)
                for servo, pulse in zip(self._settings.servos, pulses_us, strict=True)
            )
        )

    def _unpulsed(self, pulses_us: Sequence[int]) -> str:
        names = [f"J{number}" for number, pulse in enumerate(pulses_us, 1) if not pulse]
        return f"since its power-up the controller has sent no pulses to {', '.join(names)}"

    def _require_pulses(self, pulses_us: Sequence[int]) -> None:
        if not all(pulses_us):
            self._sent_us = None
            self._identity = ""
            raise DeviceError(self._device, self._unpulsed(pulses_us), hint=_OPEN_HINT)

    def _require_time(self, duration_s: float) -> None:
        if duration_s * 1000.0 > GREATEST_TIME_MS:
            raise DeviceError(
                self._device,
                f"the move would take {duration_s:.0f} s, longer than the controller can count",
                hint=f"allowed are {GREATEST_TIME_MS / 1000.0:.1f} s; set a higher speed",
            )

    def _require_output(self, bit: int) -> None:
        if not 0 <= bit < CHANNELS:
            raise DeviceError(
                self._device, f"there is no output {bit}", hint=f"allowed are 0 to {CHANNELS - 1}"
            )
        if bit in self._channels or bit in self._settings.other_channels:
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
