"""An IBM 7545 whose slave is reached through shared registers.

The slave only closes contacts, counts pulses and puts torques out; everything else is the
master's work, which is this driver: it plans each move, computes the torques in every
sample period and stops when a bit of the error register comes up. Between moves no torque
is put out; friction holds the arm, as in the original program.

That the registers are reached over a bridge on a serial line is our assumption (see
`framing`): the original master sat on the same bus as the memory.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from math import isfinite

from cell.clock import Clock
from cell.devices.arm import ArmState, Interpolation
from cell.drivers.ibm7545.bus import Answer, RegisterBus
from cell.drivers.ibm7545.framing import Acknowledge, Read, Write
from cell.drivers.ibm7545.outputs import Outputs
from cell.drivers.ibm7545.pulses import positions_of, to_joints, to_pulses
from cell.drivers.ibm7545.registers import (
    JOINT_NAMES,
    JOINTS,
    MOTOR_POWER_OFF,
    Command,
    Register,
    explain,
)
from cell.drivers.ibm7545.servo import Servo, fault
from cell.drivers.ibm7545.settings import ScaraSettings
from cell.drivers.ibm7545.trajectory import Course, Pace, Trajectory, joint_course, line_course
from cell.errors import (
    CellError,
    DeviceError,
    DeviceRestarted,
    DeviceTimeout,
    UnreachablePose,
)
from cell.geometry import JointPositions, Pose
from cell.kinematics.arm import ArmKinematics
from cell.stop import StopToken

_log = logging.getLogger(__name__)

_LIMIT_SLACK = 0.01
_REOPEN_HINT = "open the arm again"


def _log_warning(text: str) -> None:
    _log.warning("%s", text)


class Ibm7545Arm:
    """The arm, from bring-up to shut-down; used by one thread at a time.

    Args:
        bus: The registers.
        kinematics: The arm's geometry and limits.
        clock: Time of every wait.
        settings: The driver's figures.
        token: Asked in every sample period whether to go on.
        on_warning: Told what a technician should know although nothing failed.
    """

    def __init__(
        self,
        bus: RegisterBus,
        kinematics: ArmKinematics,
        clock: Clock,
        settings: ScaraSettings,
        *,
        token: StopToken | None = None,
        on_warning: Callable[[str], None] = _log_warning,
    ) -> None:
        self._bus = bus
        self._kinematics = kinematics
        self._clock = clock
        self._settings = settings
        self._on_warning = on_warning
        self._token = token or StopToken()
        self._servo = Servo(bus, settings, self._token)
        self._outputs = Outputs(bus, clock, settings)
        self._is_open = False
        self._is_ready = False
        self._is_home_known = False
        self._speed_mm_s = settings.linear_speed_mm_s
        self._percent = settings.joint_speed_percent

    @property
    def outputs(self) -> Outputs:
        """Lamps and the gripper's valve, which hang on the same registers."""
        return self._outputs

    def open(self) -> str:
        """Clear errors, find home unless it is known, and hold the arm ready.

        Home is known to a slave whose sample period is ours: it is written when home was
        found, and gone after a power-up. Finding home moves the slide up first, then joints 1,
        2 and 4, on the slave's own account: see that the way is free. Once begun, only the
        emergency stop ends it.

        Raises:
            DeviceError: Motor power is off, a joint stands past its limit, or home cannot
                be found.
            DeviceTimeout: The bridge or the slave does not answer.
        """
        if not self._settings.was_tried_on_hardware:
            self._on_warning(
                f"{self._bus.device}: this driver was never tried on hardware, and the bridge to "
                "the registers is an assumption; keep a hand at the emergency stop"
            )
        self._is_ready = False
        self._servo.halt()
        self._clear()
        if not self.knows_position():
            self._find_home()
        self._bus.write(Register.SAMPLE_PERIOD, (self._settings.period_us,))
        self._is_home_known = self._is_open = self._is_ready = True
        return (
            f"IBM 7545 behind shared registers, sample period {self._settings.period_us} µs, "
            "home found"
        )

    def knows_position(self) -> bool:
        """Return whether home was found since the slave's power-up; nothing moves.

        Raises:
            DeviceTimeout: The bridge or the slave does not answer.
        """
        return self._state().words[0] == self._settings.period_us

    def reopen(self) -> None:
        """Bring the arm back into service without moving it.

        Raises:
            DeviceRestarted: Home has to be found first, which moves the arm.
            DeviceError: As `open`.
        """
        if not self.knows_position():
            raise self._restarted()
        self.open()

    def close(self) -> None:
        """Take all torque away; closing a closed arm does nothing."""
        if not self._is_open:
            return
        self._is_open = self._is_ready = False
        self._servo.halt()

    def set_speed(self, speed_mm_s: float, joint_percent: float) -> None:
        """Set the greatest speed along lines and the share of the joints' speed.

        Raises:
            DeviceError: A figure is out of range.
            DeviceTimeout: The bridge does not answer.
        """
        if not (0 < speed_mm_s < float("inf") and 0 < joint_percent <= 100):
            raise DeviceError(
                self._bus.device,
                f"a speed of {speed_mm_s:g} mm/s and {joint_percent:g} % was asked for",
                hint="use more than 0 mm/s and more than 0 to 100 %",
            )
        self._bus.read(Register.ERROR)
        self._speed_mm_s, self._percent = speed_mm_s, joint_percent

    def move(
        self,
        pose: Pose,
        *,
        interpolation: Interpolation,
        posture: int,
        turns: int = 0,
        expected_s: float = 0.0,
    ) -> None:
        """Move the tool point to `pose` and return when it stands there.

        `turns` and `expected_s` are not needed: the driver itself plans the motion.

        Raises:
            DeviceError: The pose is out of reach, or the move ended with a fault; the arm
                has no torque then.
            DeviceTimeout: The bridge falls silent or a joint does not settle.
            Stopped: Somebody asked for a stop.
        """
        if not all(isfinite(v) for v in (pose.x_mm, pose.y_mm, pose.z_mm, pose.c_deg)):
            raise DeviceError(self._bus.device, f"{pose} is no position", hint="check the target")
        start = self._ready_at()
        try:
            if interpolation == "joint":
                end = self._kinematics.solve(pose, posture, start)
                course = joint_course(start, end, self._pace())
            else:
                course = line_course(
                    self._kinematics, start, pose, posture, self._pace(), via_s=self._settings.via_s
                )
        except UnreachablePose as error:
            raise DeviceError(
                self._bus.device, f"the target is out of range: {error}", hint="choose another pose"
            ) from error
        self._follow(course)

    def move_joints(self, joints: JointPositions, *, expected_s: float = 0.0) -> None:
        """Move every joint to its position and return when all stand there.

        Raises:
            DeviceError: A position is beyond its limit, or the move ended with a fault.
            DeviceTimeout: The bridge falls silent or a joint does not settle.
            Stopped: Somebody asked for a stop.
        """
        self._require_limits(joints)
        self._follow(joint_course(self._ready_at(), joints, self._pace()))

    def read_pose(self) -> Pose:
        """Return where the tool point is."""
        return self._kinematics.forward(self.read_joints())

    def read_joints(self) -> JointPositions:
        """Return the joints: deg, deg, mm, deg."""
        return to_joints(positions_of(self._bus.read(Register.POSITIONS, 2 * JOINTS)))

    def read_state(self) -> ArmState:
        """Return the state; the alarm is the error register's bits (`registers.Fault`).

        Motor power cut off adds `registers.MOTOR_POWER_OFF`.
        """
        answer = self._state()
        alarm = _alarm(answer)
        if alarm or self._was_restarted(answer):
            self._is_ready = False
        command = answer.words[3]
        return ArmState(
            is_servo_on=self._is_ready,
            is_moving=bool(command & (Command.SERVO | Command.FIND_HOME)),
            is_automatic=True,
            is_emergency_stopped=answer.is_power_off,
            alarm=alarm,
            alarm_text=explain(alarm)[0],
            override_percent=100,
        )

    def stop(self) -> None:
        """Take all torque away now and end the slave's command; works in every state."""
        self._servo.halt()

    def reset_alarm(self) -> None:
        """Clear error bits whose cause is gone; the arm must be opened again after any.

        Raises:
            DeviceError: A bit stays; the text names its cause.
        """
        self._clear()

    def set_output(self, bit: int, *, is_on: bool) -> None:
        """Switch an output: 0 halogen lamp, 1 fluorescent lamps, 8 gripper closed."""
        self._outputs.switch(bit, is_on=is_on)

    def read_output(self, bit: int) -> bool:
        """Return whether an output is on; the gripper's valve as it was last switched."""
        return self._outputs.is_on(bit)

    def _pace(self) -> Pace:
        settings = self._settings
        return Pace(settings.joint_speed, self._percent, self._speed_mm_s, settings.segment_extra_s)

    def _state(self) -> Answer:
        return self._bus.perform((Read(Register.SAMPLE_PERIOD, 5),), timeout_s=0.0)

    def _was_restarted(self, answer: Answer) -> bool:
        """Return whether the registers have forgotten what was written at the last opening."""
        return self._is_home_known and answer.words[0] != self._settings.period_us

    def _ready_at(self) -> JointPositions:
        """Return where the joints stand, if the arm may move."""
        answer = self._bus.perform(
            (Read(Register.SAMPLE_PERIOD, 5), Read(Register.POSITIONS, 2 * JOINTS)), timeout_s=0.0
        )
        alarm = _alarm(answer)
        if alarm:
            self._is_ready = False
            raise fault(self._bus.device, alarm)
        if self._was_restarted(answer):
            self._is_ready = self._is_home_known = False
            raise self._restarted()
        if not self._is_ready:
            raise DeviceError(self._bus.device, "the arm is not in service", hint=_REOPEN_HINT)
        return to_joints(positions_of(answer.words[5:]))

    def _restarted(self) -> DeviceRestarted:
        return DeviceRestarted(
            self._bus.device,
            "the slave was switched off and on, so it does not know where home is",
            hint=f"see that the way home is free, then {_REOPEN_HINT}",
        )

    def _follow(self, course: Course) -> None:
        points = [to_pulses(point.values) for point in course.points]
        try:
            self._servo.follow(Trajectory(points, course.durations_s))
        except DeviceError:
            self._is_ready = False
            raise

    def _require_limits(self, joints: JointPositions) -> None:
        arm = self._kinematics
        for name, value, low, high, unit in zip(
            JOINT_NAMES, joints.values, arm.joint_min, arm.joint_max, arm.joint_units, strict=True
        ):
            if not low - _LIMIT_SLACK <= value <= high + _LIMIT_SLACK:
                raise DeviceError(
                    self._bus.device,
                    f"{name} at {value:g} {unit} is out of range",
                    hint=f"keep it between {low:g} and {high:g} {unit}",
                )

    def _clear(self) -> None:
        """Clear the error register and look again at what stays."""
        self._bus.perform((Acknowledge(), Write(Register.ERROR, (0,))), timeout_s=0.0)
        self._clock.sleep(self._settings.reset_s)
        alarm = _alarm(self._state())
        if alarm:
            self._is_ready = False
            text, hint = explain(alarm)
            raise DeviceError(
                self._bus.device,
                f"the alarm cannot be reset while its cause remains: {text}",
                code=alarm,
                hint=hint,
            )

    def _find_home(self) -> None:
        """Let the slave find home; it clears the command register when it has."""
        self._is_home_known = False
        self._outputs.forget()
        # Whoever opens after a home that was not found must not take it for known.
        self._bus.write(Register.SAMPLE_PERIOD, (0,))
        self._bus.write(Register.COMMAND, (Command.FIND_HOME,))
        deadline_s = self._clock.now_s() + self._settings.home_timeout_s
        try:
            while True:
                self._token.check()
                self._clock.sleep(self._settings.poll_s)
                answer = self._state()
                alarm = _alarm(answer)
                if alarm:
                    raise fault(self._bus.device, alarm)
                if not answer.words[3]:
                    return
                if self._clock.now_s() >= deadline_s:
                    raise DeviceTimeout(
                        self._bus.device,
                        f"home was not found within {self._settings.home_timeout_s:g} s",
                        hint="look whether something holds the arm; check the home sensors",
                    )
        except CellError:
            self._servo.halt_after_fault()
            raise


def _alarm(answer: Answer) -> int:
    """Return the alarm in an answer that begins with registers 00 to 08."""
    power = MOTOR_POWER_OFF if answer.is_power_off or answer.was_power_off else 0
    return answer.words[4] | power
