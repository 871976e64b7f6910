"""The slave's program on its registers, told the time from outside (Bloch 1994, appendix B).

It idles until a bit of the command or gripper register is set. In the servo loop each
sample period begins with the state's registers; then it waits for torques, takes them,
and waits for the master to end the period. It leaves the loop with an error bit when a
torque is out of range, either wait is longer than the period, or a joint stands past its
limit; without one when the master clears the command. Whenever it idles there is no
torque. Errors keep it from any command until they are gone.

Of the state, all four timing bits come up at one moment here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Annotated

from pydantic import Field

from cell.drivers.ibm7545.pulses import words_of
from cell.drivers.ibm7545.registers import (
    JOINTS,
    OVERRUNS,
    TORQUE_MAX,
    Command,
    Fault,
    GripperBit,
    Register,
    TimingA,
    TimingB,
)
from cell.twin.emulators.ibm7545.mechanics import Mechanics
from cell.twin.emulators.ibm7545.settings import SlaveSettings

SIZE = 0x48
"""Bytes of the dual-port memory that are in use."""
_HOMING_ORDER = (2, 0, 1, 3)
_ALL_READY = int(TimingA.STARTED | TimingA.POSITIONS | TimingA.VELOCITIES | TimingA.ACCELERATIONS)
_MIN_PERIOD_S = 0.0005
"""The slave's own loop takes this long, whatever the register says."""


Word = Annotated[int, Field(ge=0, le=0xFFFF)]


class Mode(Enum):
    """What the slave is at."""

    OFF = "off"
    IDLE = "idle"
    MEASURING = "reads the joints at a period's start"
    AWAITING_TORQUES = "waits for torques"
    AWAITING_MASTER = "waits for the master to end the period"
    AWAITING_PERIOD = "waits for the next period"
    HOMING = "finds home"
    GRIPPING = "works the gripper"


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptSlave:
    """An idle slave and its arm.

    Attributes:
        positions: Where the joints stand, in pulses from home.
        origin: Where their counters were last put to zero, likewise.
        sample_period_us: The register of that name; 0 if home was not found since power-up.
        error: The error register.
        lamps: Which lamps are on.
        is_closed: Whether the gripper is closed.
    """

    positions: tuple[float, float, float, float]
    origin: tuple[float, float, float, float]
    sample_period_us: Word
    error: Word
    lamps: Word
    is_closed: bool


class Slave:
    """The slave with the arm behind it.

    Attributes:
        mechanics: The joints' truth; only tests may look into it.
        is_closed: Whether the gripper is closed.
    """

    def __init__(self, settings: SlaveSettings) -> None:
        self._settings = settings
        self.mechanics = Mechanics(settings)
        self.is_closed = False
        self.mode = Mode.IDLE
        self._words = [0] * (SIZE // 2)
        self._lamps = 0
        self._now_s = 0.0
        self._event_s: float | None = None
        self._period_start_s = 0.0
        self._homing: list[tuple[float, int, float]] = []
        self._gripper_word = 0
        self._last: tuple[int, ...] = (0,) * JOINTS
        self._last_speeds: tuple[int, ...] = (0,) * JOINTS
        self._origin: list[float] = []
        self._start_program(0.0)

    @property
    def now_s(self) -> float:
        """Up to when the slave has run."""
        return self._now_s

    def next_event_s(self) -> float | None:
        """Return when the slave next does something by itself, or None."""
        return self._event_s

    def advance(self, now_s: float) -> None:
        """Let the slave's program run up to `now_s`."""
        while self._event_s is not None and self._event_s <= now_s:
            self._now_s = max(self._now_s, self._event_s)
            self._happen()
        self._now_s = max(self._now_s, now_s)
        if self.mode is Mode.HOMING:
            end_s, joint, speed = self._homing[0]
            self.mechanics.place(joint, speed * (end_s - self._now_s))

    def has(self, offset: int, count: int) -> bool:
        """Return whether there are `count` registers from an offset on."""
        if offset == Register.LAMPS:
            return count == 1
        return offset % 2 == 0 and offset >= 0 and offset + 2 * count <= SIZE

    def read(self, offset: int, count: int) -> tuple[int, ...]:
        """Return registers as they stand now."""
        if offset == Register.LAMPS:
            return (self._lamps,)
        if self.mode is Mode.OFF:
            return (0xFFFF,) * count
        if self.mode not in _IN_SERVO_LOOP and self.mode is not Mode.HOMING:
            self._look()
        first = offset // 2
        return tuple(self._words[first : first + count])

    def write(self, offset: int, words: tuple[int, ...]) -> None:
        """Write registers now; the slave sees them at once."""
        if offset == Register.LAMPS:
            self._lamps = words[0]
            return
        if self.mode is Mode.OFF:
            return
        first = offset // 2
        self._words[first : first + len(words)] = words
        self._react()

    def lamps(self) -> int:
        """Return which lamps are on (`registers.Lamp`)."""
        return self._lamps

    def cut_motor_power(self, now_s: float, *, is_on: bool) -> None:
        """Cut the motors' power (an emergency stop) or give it back."""
        self.advance(now_s)
        self.mechanics.set_power(self._now_s, is_on=is_on)
        if not is_on and self.mode is Mode.HOMING:
            self._idle()

    def switch(self, now_s: float, *, is_on: bool) -> None:
        """Switch the whole controller off or on; the joints' counters start at zero again."""
        self.advance(now_s)
        self.mechanics.set_power(self._now_s, is_on=is_on)
        self.mode, self._event_s = Mode.OFF, None
        if is_on:
            self._start_program(self._now_s)

    def push_joint(self, joint: int, pulses: float, now_s: float) -> None:
        """Put a joint somewhere by hand, in pulses from home."""
        self.advance(now_s)
        self.mechanics.advance(self._now_s)
        self.mechanics.place(joint, pulses)

    def kept(self, now_s: float) -> KeptSlave:
        """Return what a slave that stays powered goes on with; it idles then."""
        self.advance(now_s)
        self.counters()
        return KeptSlave(
            positions=_four(self.mechanics.positions),
            origin=_four(self._origin),
            sample_period_us=self._get(Register.SAMPLE_PERIOD),
            error=self._get(Register.ERROR),
            lamps=self._lamps,
            is_closed=self.is_closed,
        )

    def restore(self, kept: KeptSlave) -> None:
        """Go on from what was kept, at time 0; it was powered all the time."""
        for joint, position in enumerate(kept.positions):
            self.mechanics.place(joint, position)
        self._origin = list(kept.origin)
        self._put(Register.SAMPLE_PERIOD, kept.sample_period_us)
        self._put(Register.ERROR, kept.error)
        self._lamps, self.is_closed = kept.lamps, kept.is_closed
        self._last = self.counters()

    def counters(self) -> tuple[int, ...]:
        """Return the position counters: pulses from where they were last put to zero."""
        self.mechanics.advance(self._now_s)
        return tuple(
            [round(p - o) for p, o in zip(self.mechanics.positions, self._origin, strict=True)]
        )

    def _start_program(self, now_s: float) -> None:
        self._words = [0] * (SIZE // 2)
        self._origin = list(self.mechanics.positions)
        self.is_closed = False
        self.mode, self._event_s = Mode.IDLE, None
        self._now_s = max(self._now_s, now_s)

    def _get(self, register: Register) -> int:
        return self._words[register // 2]

    def _put(self, register: Register, word: int) -> None:
        self._words[register // 2] = word

    def _look(self) -> None:
        """Read the joints into the registers and check them against their limits."""
        counters = self.counters()
        speeds = tuple([p - q for p, q in zip(counters, self._last, strict=True)])
        words = self._words
        words[0x08:0x10] = words_of(counters)
        words[0x10:0x14] = [speed & 0xFFFF for speed in speeds]
        words[0x18:0x1C] = [
            (v - w) & 0xFFFF for v, w in zip(speeds, self._last_speeds, strict=True)
        ]
        self._last, self._last_speeds = counters, speeds
        overruns = 0
        settings = self._settings
        for joint, position in enumerate(counters):
            if position > settings.overrun_max[joint]:
                overruns |= 1 << (2 * joint)
            elif position < settings.overrun_min[joint]:
                overruns |= 2 << (2 * joint)
        words[4] = words[4] & ~OVERRUNS | overruns

    def _react(self) -> None:
        """Do what the registers now ask for."""
        if self.mode is Mode.IDLE:
            self._take_command()
        elif self.mode is Mode.AWAITING_TORQUES:
            if not self._get(Register.COMMAND):
                self._idle()
            elif self._get(Register.TIMING_B) & TimingB.TORQUES:
                self._take_torques()
        elif self.mode is Mode.AWAITING_MASTER and not self._get(Register.TIMING_A):
            self.mode = Mode.AWAITING_PERIOD
            self._event_s = max(self._now_s, self._period_start_s + self._period_s())

    def _take_command(self) -> None:
        self._look()
        if self._get(Register.ERROR):
            return
        command, gripper = self._get(Register.COMMAND), self._get(Register.GRIPPER)
        if command & Command.SERVO:
            self._put(Register.TIMING_B, 0)
            self._start_period(self._now_s)
        elif command & Command.FIND_HOME:
            if self.mechanics.is_powered:
                self._plan_homing()
        elif gripper & (GripperBit.OPEN | GripperBit.CLOSE):
            self.mode, self._gripper_word = Mode.GRIPPING, gripper
            self._event_s = self._now_s + self._settings.gripper_s

    def _happen(self) -> None:
        """Do what is due now."""
        mode = self.mode
        if mode is Mode.MEASURING:
            self._look()
            self._put(Register.TIMING_A, _ALL_READY)
            if self._get(Register.ERROR):
                self._idle()
                return
            self.mode = Mode.AWAITING_TORQUES
            self._event_s = self._deadline_s()
            self._react()
        elif mode is Mode.AWAITING_TORQUES:
            self._fail(Fault.TORQUES_LATE)
        elif mode is Mode.AWAITING_MASTER:
            self._fail(Fault.LOOP_TOO_SLOW)
        elif mode is Mode.AWAITING_PERIOD:
            self._start_period(self._now_s)
        elif mode is Mode.HOMING:
            self._reach_home()
        elif mode is Mode.GRIPPING:
            self.is_closed = not self._gripper_word & GripperBit.OPEN
            self._idle()

    def _start_period(self, now_s: float) -> None:
        self._period_start_s = now_s
        self._put(Register.TIMING_A, int(TimingA.STARTED))
        self.mode = Mode.MEASURING
        self._event_s = now_s + self._settings.measure_s

    def _take_torques(self) -> None:
        first = Register.TORQUES // 2
        words = tuple(self._words[first : first + JOINTS])
        faults = 0
        for joint, word in enumerate(words):
            if word > TORQUE_MAX:
                faults |= Fault.TORQUE_1 << joint
        if faults:
            self._fail(faults)
            return
        self._put(Register.TIMING_B, 0)
        self.mechanics.apply(words, self._now_s)
        self.mode = Mode.AWAITING_MASTER
        self._event_s = self._deadline_s()
        self._react()

    def _fail(self, faults: int) -> None:
        self._put(Register.ERROR, self._get(Register.ERROR) | faults)
        self._idle()

    def _idle(self) -> None:
        """Go back to idling: no torque, no command."""
        self.mechanics.relax(self._now_s)
        self._put(Register.COMMAND, 0)
        self._put(Register.GRIPPER, 0)
        self.mode, self._event_s = Mode.IDLE, None

    def _period_s(self) -> float:
        return max(self._get(Register.SAMPLE_PERIOD) / 1e6, _MIN_PERIOD_S)

    def _deadline_s(self) -> float:
        return self._period_start_s + self._period_s() + self._settings.lateness_s

    def _plan_homing(self) -> None:
        """Find home joint by joint, the slide first, each at an even speed."""
        self.mechanics.relax(self._now_s)
        self.mode, self._homing = Mode.HOMING, []
        at_s = self._now_s
        for joint in _HOMING_ORDER:
            position, speed = self.mechanics.positions[joint], self._settings.homing_speed[joint]
            at_s += abs(position) / speed
            self._homing.append((at_s, joint, speed if position > 0 else -speed))
        self._event_s = self._homing[0][0]

    def _reach_home(self) -> None:
        _, joint, _ = self._homing.pop(0)
        self.mechanics.place(joint, 0.0)
        self._origin[joint] = 0.0
        if self._homing:
            self._event_s = self._homing[0][0]
        else:
            self._idle()


_IN_SERVO_LOOP = frozenset(
    {Mode.MEASURING, Mode.AWAITING_TORQUES, Mode.AWAITING_MASTER, Mode.AWAITING_PERIOD}
)


def _four(values: Sequence[float]) -> tuple[float, float, float, float]:
    one, two, three, four = values
    return one, two, three, four
