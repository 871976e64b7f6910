"""The master's half of the servo: torques from positions, once each sample period.

torque = 0x800 + kp·e + kv·(e - e_prev)/Ts for each joint, e in pulses. A torque beyond 12
bits is not cut down but refused, by the slave's own check: an arm that needs it is held by
something. However a run ends, the torques are put to zero and the command is cleared.
"""

from __future__ import annotations

from collections.abc import Sequence

from cell.drivers.ibm7545.bus import Answer, RegisterBus
from cell.drivers.ibm7545.framing import Await, Read, Step, Write
from cell.drivers.ibm7545.pulses import positions_of
from cell.drivers.ibm7545.registers import (
    JOINT_NAMES,
    JOINTS,
    MOTOR_POWER_OFF,
    TORQUE_MAX,
    TORQUE_REFUSED,
    TORQUE_ZERO,
    Command,
    Register,
    TimingA,
    TimingB,
    explain,
)
from cell.drivers.ibm7545.settings import ScaraSettings
from cell.drivers.ibm7545.trajectory import Trajectory
from cell.errors import CellError, DeviceError, DeviceTimeout
from cell.stop import StopToken

SAFE_STOP: tuple[Step, ...] = (
    Write(Register.TORQUES, (TORQUE_ZERO,) * JOINTS),
    Write(Register.COMMAND, (0,)),
    Write(Register.TIMING_A, (0, 0)),
)
"""No torque, no command, no timing."""

_STATE: tuple[Step, ...] = (Read(Register.COMMAND, 2), Read(Register.POSITIONS, 2 * JOINTS))


class Servo:
    """Leads the joints along trajectories.

    Args:
        bus: The registers.
        settings: Period, gains and tolerances.
        token: Asked each period whether to go on.
    """

    def __init__(self, bus: RegisterBus, settings: ScaraSettings, token: StopToken) -> None:
        self._bus = bus
        self._settings = settings
        self._token = token
        self._wait_s = settings.wait_ms / 1000.0
        ready = Await(
            Register.TIMING_A,
            TimingA.POSITIONS,
            TimingA.POSITIONS,
            Register.ERROR,
            settings.wait_ms,
        )
        self._start: tuple[Step, ...] = (
            Write(Register.TORQUES, (TORQUE_ZERO,) * JOINTS),
            Write(Register.TIMING_A, (0, 0)),
            Write(Register.COMMAND, (Command.SERVO,)),
            ready,
            *_STATE,
        )
        taken = Await(Register.TIMING_B, TimingB.TORQUES, 0, Register.ERROR, settings.wait_ms)
        self._period: tuple[Step, ...] = (
            Write(Register.TIMING_B, (TimingB.TORQUES,)),
            taken,
            Write(Register.TIMING_A, (0,)),
            ready,
            *_STATE,
        )

    def follow(self, trajectory: Trajectory) -> float:
        """Lead the joints along a trajectory (in pulses) and hold its end until they settle.

        Returns:
            The time it took, in sample periods of simulated or real time.

        Raises:
            DeviceError: An error bit came up or motor power went; the arm has no torque then.
            DeviceTimeout: The bridge or the slave falls silent, or a joint does not settle.
            Stopped: Somebody asked for a stop.
        """
        try:
            samples = self._run(trajectory)
        except CellError:
            self.halt_after_fault()
            raise
        self.halt()
        return samples * self._settings.period_s

    def halt(self) -> None:
        """Put all torques to zero and end the command."""
        self._bus.perform(SAFE_STOP, timeout_s=0.0)

    def halt_after_fault(self) -> None:
        """Halt; a second fault here must not hide the first."""
        try:
            self.halt()
        except DeviceError:
            # The slave, hearing no torques, lets go by itself within a sample period.
            return

    def _run(self, trajectory: Trajectory) -> int:
        settings, token = self._settings, self._token
        period_s = settings.period_s
        end_s = trajectory.duration_s
        limit_s = end_s + settings.settle_timeout_s
        gains = tuple(zip(settings.kp, (kv / period_s for kv in settings.kv), strict=True))
        positions = self._checked(self._bus.perform(self._start, timeout_s=self._wait_s))
        before: tuple[float, ...] | None = None
        sample = settled = 0
        while True:
            token.check()
            time_s = sample * period_s
            wanted = trajectory.at(time_s)
            errors = tuple([w - p for w, p in zip(wanted, positions, strict=True)])
            if time_s >= end_s:
                near = max(abs(e) for e in errors) <= settings.settled_pulses
                settled = settled + 1 if near else 0
                if settled >= settings.settled_samples:
                    return sample
                if time_s > limit_s:
                    raise self._unsettled(errors)
            words = _torques(gains, errors, before or errors)
            before = errors
            answer = self._bus.perform(
                (Write(Register.TORQUES, words), *self._period), timeout_s=2.0 * self._wait_s
            )
            positions = self._checked(answer)
            sample += 1

    def _checked(self, answer: Answer) -> tuple[int, ...]:
        """Return the positions in an answer, or raise what the slave reports."""
        if answer.is_power_off or answer.was_power_off:
            raise fault(self._bus.device, MOTOR_POWER_OFF)
        if not answer.is_wait_over:
            raise DeviceTimeout(
                self._bus.device,
                f"the slave did not keep its sample period within {self._settings.wait_ms} ms",
                hint="check that the robot's controller is switched on; open the arm again",
            )
        command, error = answer.words[0], answer.words[1]
        if error:
            raise fault(self._bus.device, error)
        if not command & Command.SERVO:
            raise DeviceError(
                self._bus.device,
                "the slave left the servo loop by itself",
                hint="look whether its power failed; open the arm again",
            )
        return positions_of(answer.words[2:])

    def _unsettled(self, errors: Sequence[float]) -> DeviceTimeout:
        axis = max(range(JOINTS), key=lambda index: abs(errors[index]))
        return DeviceTimeout(
            self._bus.device,
            f"{JOINT_NAMES[axis]} is {errors[axis]:.0f} pulses from its target "
            f"{self._settings.settle_timeout_s:g} s after the move's end",
            hint="look whether something holds the joint; check the servo's gains",
        )


def fault(device: str, alarm: int) -> DeviceError:
    """Return the error for alarm bits, in words."""
    text, hint = explain(alarm)
    return DeviceError(device, text, code=alarm, hint=hint)


def _torques(
    gains: Sequence[tuple[float, float]], errors: Sequence[float], before: Sequence[float]
) -> tuple[int, ...]:
    words = []
    for (kp, kv), e, e0 in zip(gains, errors, before, strict=True):
        word = TORQUE_ZERO + int(kp * e + kv * (e - e0))
        words.append(word if 0 <= word <= TORQUE_MAX else TORQUE_REFUSED)
    return tuple(words)
