"""Between where a servo shall stand and the pulse width that brings it there.

Positions are degrees for joints and millimetres for fingers. Hobby servos are not linear: a
straight line is what one starts with, a measured map is what one ends with.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

from cell.drivers.ssc32.tables import GREATEST_SPEED_US_S
from cell.errors import ProfileError
from cell.profile.lynx import ServoProfile

_SLOPE_STEPS = 200


class ServoMap(Protocol):
    """A monotone map of positions to pulse widths and back."""

    def pulse_us(self, position: float) -> float:
        """Return the pulse width for a position."""

    def position(self, pulse_us: float) -> float:
        """Return the position that a pulse width stands for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearServoMap:
    """A straight line.

    Attributes:
        centre_us: Pulse width at position 0.
        us_per_unit: Pulse width for one degree or millimetre; negative turns the other way.
    """

    centre_us: float
    us_per_unit: float

    def pulse_us(self, position: float) -> float:
        """Return the pulse width for a position."""
        return self.centre_us + self.us_per_unit * position

    def position(self, pulse_us: float) -> float:
        """Return the position that a pulse width stands for."""
        return (pulse_us - self.centre_us) / self.us_per_unit


class MeasuredServoMap:
    """Straight pieces between measured points; the outer ones go on beyond the last points.

    Args:
        points: Pairs of position and pulse width, two at least, positions rising, pulse
            widths all rising or all falling.

    Raises:
        ProfileError: The points are too few or not monotone.
    """

    def __init__(self, points: tuple[tuple[float, float], ...]) -> None:
        steps = list(zip(points, points[1:], strict=False))
        if len(points) < 2 or any(b[0] <= a[0] for a, b in steps):
            raise ProfileError("a servo's map needs two points or more with rising positions")
        if any(a[1] == b[1] for a, b in steps) or len({b[1] > a[1] for a, b in steps}) > 1:
            raise ProfileError("a servo's map needs pulse widths that all rise or all fall")
        self.points = points
        self._by_position = points
        self._by_pulse = tuple(sorted((pulse, position) for position, pulse in points))

    def pulse_us(self, position: float) -> float:
        """Return the pulse width for a position."""
        return _along(self._by_position, position)

    def position(self, pulse_us: float) -> float:
        """Return the position that a pulse width stands for."""
        return _along(self._by_pulse, pulse_us)


def servo_map(profile: ServoProfile) -> ServoMap:
    """Return the map of a servo: the measured one where there is one."""
    if profile.map:
        return MeasuredServoMap(profile.map)
    return LinearServoMap(centre_us=profile.centre_us, us_per_unit=profile.us_per_unit)


def speed_cap_us_s(servo: ServoMap, low: float, high: float, speed: float, segment_s: float) -> int:
    """Return the fastest pulse change that a servo needs, for the controller to keep to.

    That of the map's steepest part at the greatest speed, and a little more: pulses are whole
    microseconds, so a short move may be one longer than its angle.

    Args:
        servo: The map.
        low: Least position.
        high: Greatest position.
        speed: Greatest speed, in units of the position a second.
        segment_s: Shortest time of a move.
    """
    step = (high - low) / _SLOPE_STEPS
    pulses = [servo.pulse_us(low + step * index) for index in range(_SLOPE_STEPS + 1)]
    steepest = max(abs(b - a) for a, b in pairwise(pulses)) / step
    return min(math.ceil(1.02 * steepest * speed + 1.0 / segment_s), GREATEST_SPEED_US_S)


def _along(points: tuple[tuple[float, float], ...], at: float) -> float:
    right = min(max(bisect_right(points, (at, float("inf"))), 1), len(points) - 1)
    (x0, y0), (x1, y1) = points[right - 1], points[right]
    return y0 + (y1 - y0) * (at - x0) / (x1 - x0)
