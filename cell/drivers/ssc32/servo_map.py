"""Between where a servo shall stand and the pulse width that brings it there.

Positions are degrees for joints and millimetres for fingers. Hobby servos are not linear: a
straight line is what one starts with, a measured map is what one ends with.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import Protocol

from cell.errors import ProfileError
from cell.profile.lynx import ServoProfile


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


def _along(points: tuple[tuple[float, float], ...], at: float) -> float:
    right = min(max(bisect_right(points, (at, float("inf"))), 1), len(points) - 1)
    (x0, y0), (x1, y1) = points[right - 1], points[right]
    return y0 + (y1 - y0) * (at - x0) / (x1 - x0)
