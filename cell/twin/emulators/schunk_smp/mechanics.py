"""The moving part of an emulated module: motions, limits, errors, status.

Knows nothing of bytes. What the module would say by itself is handed to
`report` together with the time at which it happens.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from cell.drivers.schunk_smp.commands import (
    MoveCurrent,
    MoveGrip,
    MovePosition,
    MovePositionTimed,
    MoveVelocity,
)
from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.replies import (
    ErrorReport,
    Impulse,
    MoveBlocked,
    PositionReached,
)
from cell.drivers.schunk_smp.tables import Code, Command, Register, Status
from cell.twin.bodies import FingerBody
from cell.twin.emulators.schunk_smp.motion import Motion, MotionKind, trapezoid_s
from cell.twin.emulators.schunk_smp.registers import Registers
from cell.twin.emulators.schunk_smp.settings import SchunkModuleSettings

_DEFAULT_SHARE: Final = 0.1
"""Velocity and acceleration at power on, as a share of the largest."""

Report = Callable[[Impulse, float], None]


class Mechanics:
    """The fingers' motor, its targets and its faults."""

    def __init__(
        self,
        body: FingerBody,
        registers: Registers,
        settings: SchunkModuleSettings,
        report: Report,
        *,
        is_referenced: bool,
    ) -> None:
        self._body = body
        self._registers = registers
        self._settings = settings
        self._report = report
        self.is_referenced = is_referenced
        self.motion: Motion | None = None
        self.error = 0
        self.warning = 0
        self._holding_a = 0.0
        self._has_reached = False
        self.targets: dict[Command, float] = {}
        self.reset(is_referenced=is_referenced)

    def reset(self, *, is_referenced: bool = False) -> None:
        """Be as after power on."""
        registers = self._registers
        self.is_referenced = is_referenced
        self.motion = None
        self.error = 0
        self.warning = 0
        self._holding_a = 0.0
        self._has_reached = False
        self.targets = {
            Command.SET_TARGET_VELOCITY: _DEFAULT_SHARE * registers[Register.MAX_VELOCITY],
            Command.SET_TARGET_ACCELERATION: _DEFAULT_SHARE * registers[Register.MAX_ACCELERATION],
            Command.SET_TARGET_JERK: 0.5 * registers[Register.MAX_JERK],
            Command.SET_TARGET_CURRENT: registers[Register.NOMINAL_CURRENT],
            Command.SET_TARGET_TIME: 0.0,
        }

    @property
    def reported_code(self) -> int:
        """The error, or else the warning, as the state tells it."""
        return self.error or self.warning

    def status(self) -> int:
        """Return the status byte."""
        status = Status.REFERENCED if self.is_referenced else Status(0)
        if self.error:
            status |= Status.ERROR
        if self.warning:
            status |= Status.WARNING
        if self.motion is not None:
            return status | Status.MOVING
        status |= Status.MOVE_END
        if self._has_reached:
            status |= Status.POSITION_REACHED
        # The brake is closed whenever the motor does not push against something.
        return status if self._holding_a else status | Status.BRAKE

    def position_mm(self, now_s: float) -> float:
        """Return the opening."""
        return self._body.opening_mm(now_s)

    def velocity_mm_s(self, now_s: float) -> float:
        """Return the velocity, negative when closing."""
        return 0.0 if self.motion is None else self.motion.velocity_mm_s(now_s)

    def current_a(self) -> float:
        """Return the motor current."""
        if self.motion is None:
            return self._holding_a
        running_a = min(self._settings.running_current_a, abs(self.motion.current_a))
        return -running_a if self.motion.target_mm < self.motion.start_mm else running_a

    def end_s(self) -> float | None:
        """Return when the motion under way will end, or None."""
        return None if self.motion is None else self.motion.end_s

    def reference(self, now_s: float) -> None:
        """Start to look for the zero position, opening to the upper limit."""
        self._require_no_error()
        if self.motion is not None and self.motion.kind == "reference":
            return
        self.is_referenced = False
        registers = self._registers
        self._begin(
            "reference",
            registers[Register.SOFT_LIMIT_HIGH],
            self._settings.reference_speed_mm_s,
            registers[Register.MAX_ACCELERATION],
            self._settings.nominal_current_a,
            now_s,
            settle_s=self._settings.reference_settle_s,
        )

    def move(self, command: MovePosition | MovePositionTimed, now_s: float) -> float:
        """Start a move to a position; return how long it will take if nothing blocks it."""
        self._require_ready()
        scale = self._registers.mm_per_unit
        here_mm = self._body.opening_mm(now_s)
        target_mm = command.position_mm * scale + (here_mm if command.is_relative else 0.0)
        low_mm = self._registers[Register.SOFT_LIMIT_LOW]
        high_mm = self._registers[Register.SOFT_LIMIT_HIGH]
        # A hundredth is forgiven: positions are told as single floats.
        _require(low_mm - 0.01 <= target_mm <= high_mm + 0.01)
        velocity = self._target(command.velocity_mm_s, Command.SET_TARGET_VELOCITY, scale)
        acceleration = self._target(
            command.acceleration_mm_s2, Command.SET_TARGET_ACCELERATION, scale
        )
        current_a = self._target(command.current_a, Command.SET_TARGET_CURRENT, 1.0)
        self._require_limits(velocity, acceleration, current_a)
        if isinstance(command, MovePositionTimed):
            _require(command.time_s > 0)
            velocity = max(1e-3, min(velocity, abs(target_mm - here_mm) / command.time_s))
        self._begin("position", target_mm, velocity, acceleration, current_a, now_s)
        return trapezoid_s(target_mm - here_mm, velocity, acceleration)

    def push(self, command: MoveGrip | MoveCurrent | MoveVelocity, now_s: float) -> None:
        """Start a motion that goes on until something blocks it."""
        self._require_ready()
        registers = self._registers
        velocity = self.targets[Command.SET_TARGET_VELOCITY]
        acceleration = self.targets[Command.SET_TARGET_ACCELERATION]
        if isinstance(command, MoveVelocity):
            signed = command.velocity_mm_s * registers.mm_per_unit
            velocity = abs(signed)
            current_a = self._target(command.current_a, Command.SET_TARGET_CURRENT, 1.0)
        else:
            signed = command.current_a
            current_a = abs(signed)
        self._require_limits(velocity, acceleration, current_a)
        is_closing = signed < 0
        limit = Register.SOFT_LIMIT_LOW if is_closing else Register.SOFT_LIMIT_HIGH
        self._begin("push", registers[limit], velocity, acceleration, current_a, now_s)

    def stop(self, now_s: float) -> None:
        """End the motion under way; a module that holds something goes on holding it."""
        if self.motion is not None:
            self._body.halt(now_s)
            self.motion = None
            self._has_reached = False

    def fail(self, code: int, now_s: float) -> None:
        """Switch the motor off and report an error until it is acknowledged."""
        if self.motion is not None:
            self._body.halt(now_s)
            self.motion = None
        self._holding_a = 0.0
        self.error = code
        self._report(ErrorReport(code), now_s)

    def finish(self) -> None:
        """End the motion whose time has come."""
        motion = self.motion
        if motion is None:
            return
        self.motion = None
        end_s = motion.end_s
        is_blocked = motion.plan.is_blocked
        position = motion.plan.end_mm / self._registers.mm_per_unit
        if motion.kind == "reference":
            self.is_referenced = True
            self._has_reached = True
            if is_blocked or self._settings.reference_is_blocked:
                self._report(MoveBlocked(position), end_s)
            else:
                self._report(PositionReached(position), end_s)
        elif is_blocked:
            is_closing = motion.target_mm < motion.start_mm
            self._holding_a = -motion.current_a if is_closing else motion.current_a
            self._report(MoveBlocked(position), end_s)
        elif motion.kind == "position":
            self._has_reached = True
            self._report(PositionReached(position), end_s)
        else:
            low_mm = self._registers[Register.SOFT_LIMIT_LOW]
            is_low = motion.target_mm == low_mm
            self.fail(Code.SOFT_LIMIT_LOW if is_low else Code.SOFT_LIMIT_HIGH, end_s)

    def _begin(
        self,
        kind: MotionKind,
        target_mm: float,
        speed_mm_s: float,
        acceleration_mm_s2: float,
        current_a: float,
        now_s: float,
        settle_s: float = 0.0,
    ) -> None:
        start_mm = self._body.opening_mm(now_s)
        plan = self._body.begin(target_mm, speed_mm_s, acceleration_mm_s2, now_s)
        self._has_reached = False
        self._holding_a = 0.0
        self.motion = Motion(
            kind=kind,
            start_s=now_s,
            start_mm=start_mm,
            target_mm=target_mm,
            speed_mm_s=speed_mm_s,
            acceleration_mm_s2=acceleration_mm_s2,
            current_a=current_a,
            plan=plan,
            settle_s=settle_s,
        )

    def _target(self, value: float | None, target: Command, scale: float) -> float:
        return self.targets[target] if value is None else value * scale

    def _require_limits(
        self, velocity_mm_s: float, acceleration_mm_s2: float, current_a: float
    ) -> None:
        registers = self._registers
        _require(0 < velocity_mm_s <= registers[Register.MAX_VELOCITY])
        _require(0 < acceleration_mm_s2 <= registers[Register.MAX_ACCELERATION])
        _require(0 < current_a <= registers[Register.MAX_CURRENT])

    def _require_no_error(self) -> None:
        if self.error:
            raise MalformedMessage("an error is latched", code=Code.FAILED)

    def _require_ready(self) -> None:
        self._require_no_error()
        if not self.is_referenced:
            raise MalformedMessage("not referenced", code=Code.NOT_REFERENCED)


def _require(is_allowed: bool) -> None:
    if not is_allowed:
        raise MalformedMessage("a parameter is out of range", code=Code.WRONG_PARAMETER)
