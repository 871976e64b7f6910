"""Motors and joints under torque words: inertia, viscous and dry friction, end stops.

Each joint by itself: v' = a·(u - c·sign v) - b·v with u the torque counts from the middle.
Between two torque words the solution is exact, so the step may be as long as they stay. What the
links' motion does to each other's inertia is left out: gears hide most of it.
"""

from __future__ import annotations

from math import exp, log1p

from cell.drivers.ibm7545.registers import JOINTS, TORQUE_ZERO
from cell.twin.emulators.ibm7545.settings import SlaveSettings

_AT_REST = 1e-9


class Mechanics:
    """Where the joints really are, in pulses from home, and how fast.

    Args:
        settings: The dynamics.
    """

    def __init__(self, settings: SlaveSettings) -> None:
        self._settings = settings
        self.positions: list[float] = [float(value) for value in settings.start]
        self.speeds: list[float] = [0.0] * JOINTS
        self._torques: list[float] = [0.0] * JOINTS
        self._now_s = 0.0
        self._is_powered = True

    @property
    def is_powered(self) -> bool:
        """Whether the motors have power; without it brakes hold the joints."""
        return self._is_powered

    @property
    def is_moving(self) -> bool:
        """Whether any joint moves."""
        return any(self.speeds)

    def advance(self, now_s: float) -> None:
        """Let time pass up to `now_s`."""
        span_s = now_s - self._now_s
        if span_s <= 0.0:
            return
        self._now_s = now_s
        for joint in range(JOINTS):
            if self.speeds[joint] or self._torques[joint]:
                self._move(joint, span_s)

    def apply(self, words: tuple[int, ...], now_s: float) -> None:
        """Put torque words out from `now_s` on."""
        self.advance(now_s)
        if self._is_powered:
            self._torques = [float(word - TORQUE_ZERO) for word in words]

    def relax(self, now_s: float) -> None:
        """Take all torque away."""
        self.advance(now_s)
        self._torques = [0.0] * JOINTS

    def set_power(self, now_s: float, *, is_on: bool) -> None:
        """Switch the motors' power; without it the brakes fall in at once."""
        self.relax(now_s)
        self._is_powered = is_on
        if not is_on:
            self.speeds = [0.0] * JOINTS

    def place(self, joint: int, position: float) -> None:
        """Put a joint somewhere, at rest: by hand, or at the end of a homing."""
        self.positions[joint] = position
        self.speeds[joint] = 0.0

    def _move(self, joint: int, span_s: float) -> None:
        settings = self._settings
        a, b, c = settings.acceleration[joint], settings.viscous[joint], settings.coulomb[joint]
        torque, speed = self._torques[joint], self.speeds[joint]
        if speed == 0.0:
            if abs(torque) <= c:
                return
            direction = 1.0 if torque > 0.0 else -1.0
        else:
            direction = 1.0 if speed > 0.0 else -1.0
        final = a * (torque - c * direction) / b
        rest_s = span_s
        if speed * direction > 0.0 and final * direction < 0.0:
            # The joint comes to a standstill; what is left of the time it may turn back.
            rest_s = min(span_s, log1p(-speed / final) / b)
        decay = exp(-b * rest_s)
        self.positions[joint] += final * rest_s + (speed - final) * (1.0 - decay) / b
        speed = final + (speed - final) * decay
        is_still = rest_s < span_s or abs(speed) < _AT_REST
        self.speeds[joint] = 0.0 if is_still else speed
        self._meet_stop(joint)
        if rest_s < span_s and abs(torque) > c:
            self._move(joint, span_s - rest_s)

    def _meet_stop(self, joint: int) -> None:
        low, high = self._settings.stop_min[joint], self._settings.stop_max[joint]
        position = self.positions[joint]
        if not low <= position <= high:
            self.positions[joint] = min(max(position, low), high)
            self.speeds[joint] = 0.0
