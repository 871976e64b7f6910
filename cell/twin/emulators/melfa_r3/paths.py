"""Planned motions: how far along at a time, and where the joints are that far along.

A path is a course (share of the way to joint angles) and a timing (time to share
of the way). Start and end are kept as given, so that no rounding of time reaches
where the arm stands in the end; what lies between is computed when asked for.
"""

from __future__ import annotations

import math
from typing import Protocol

from cell.twin.bodies import JointTuple


class Course(Protocol):
    """The geometric part of a path."""

    @property
    def start_deg(self) -> JointTuple:
        """Joint angles at share 0."""

    @property
    def end_deg(self) -> JointTuple:
        """Joint angles at share 1."""

    @property
    def length_mm(self) -> float:
        """Length of the tool point's way, 0 where nobody knows it."""

    def at(self, share: float) -> JointTuple:
        """Return the joint angles at a share of the way, 0 to 1."""


class TurningCourse(Course, Protocol):
    """A course of the tool point, which may turn on its way."""

    turn_deg: float

    def check(self) -> None:
        """Look at the way.

        Raises:
            UnreachablePose: A place on the way cannot be reached.
        """


class Timing(Protocol):
    """The temporal part of a path."""

    @property
    def duration_s(self) -> float:
        """How long it takes."""

    @property
    def end_share(self) -> float:
        """Share of the way at which it ends, 1 unless it was stopped."""

    def share(self, elapsed_s: float) -> float:
        """Return the share of the way after a time within the duration."""

    def rate(self, elapsed_s: float) -> float:
        """Return the change of the share for each second."""


class JointCourse:
    """Every joint turns evenly from start to end."""

    __slots__ = ("end_deg", "length_mm", "start_deg")

    def __init__(self, start_deg: JointTuple, end_deg: JointTuple) -> None:
        self.start_deg = start_deg
        self.end_deg = end_deg
        self.length_mm = 0.0

    def at(self, share: float) -> JointTuple:
        """Return the joint angles at a share of the way."""
        a1, a2, a3, a4, a5, a6 = self.start_deg
        b1, b2, b3, b4, b5, b6 = self.end_deg
        return (
            a1 + share * (b1 - a1),
            a2 + share * (b2 - a2),
            a3 + share * (b3 - a3),
            a4 + share * (b4 - a4),
            a5 + share * (b5 - a5),
            a6 + share * (b6 - a6),
        )


class ChainedCourse:
    """One course after the other, at one speed along both."""

    __slots__ = ("end_deg", "length_mm", "start_deg", "turn_deg", "_first", "_second", "_split")

    def __init__(self, first: TurningCourse, second: TurningCourse) -> None:
        self.start_deg = first.start_deg
        self.end_deg = second.end_deg
        self.length_mm = first.length_mm + second.length_mm
        self.turn_deg = first.turn_deg + second.turn_deg
        self._first, self._second = first, second
        self._split = first.length_mm / self.length_mm

    def at(self, share: float) -> JointTuple:
        """Return the joint angles at a share of the way."""
        if share < self._split:
            return self._first.at(share / self._split)
        return self._second.at((share - self._split) / (1.0 - self._split))

    def check(self) -> None:
        """Look at the way.

        Raises:
            UnreachablePose: A place on the way cannot be reached.
        """
        self._first.check()
        self._second.check()


class Trapezoid:
    """Speeds up evenly, goes at an even speed, brakes evenly.

    With way s, speed v and acceleration a: if s >= v²/a it takes s/v + v/a, else the
    speed is never reached and it takes 2·sqrt(s/a).

    Args:
        way: Length of the way in any unit, more than 0.
        speed: Largest speed, in that unit a second.
        acceleration: Of speeding up and braking, in that unit a second squared.
    """

    __slots__ = ("duration_s", "end_share", "_ramp_s", "_rate")

    def __init__(self, way: float, speed: float, acceleration: float) -> None:
        if way * acceleration < speed * speed:
            speed = math.sqrt(way * acceleration)
        self._ramp_s = speed / acceleration
        self._rate = speed / way
        self.duration_s = way / speed + self._ramp_s
        self.end_share = 1.0

    def stretched_to(self, duration_s: float) -> Trapezoid:
        """Return the same shape over a longer time."""
        longer = duration_s / self.duration_s
        return Trapezoid(1.0, self._rate / longer, self.braking / (longer * longer))

    @property
    def braking(self) -> float:
        """How fast the rate falls when braking."""
        return self._rate / self._ramp_s

    def share(self, elapsed_s: float) -> float:
        """Return the share of the way after a time."""
        ramp_s, rate = self._ramp_s, self._rate
        left_s = self.duration_s - elapsed_s
        if elapsed_s < ramp_s:
            return 0.5 * rate * elapsed_s * elapsed_s / ramp_s
        if left_s < ramp_s:
            return 1.0 - 0.5 * rate * left_s * left_s / ramp_s
        return rate * (elapsed_s - 0.5 * ramp_s)

    def rate(self, elapsed_s: float) -> float:
        """Return the change of the share for each second."""
        near_end_s = min(elapsed_s, self.duration_s - elapsed_s)
        return self._rate * max(min(near_end_s / self._ramp_s, 1.0), 0.0)


class Braking:
    """Brakes evenly from a rate to rest.

    Args:
        share: Share of the way where braking starts.
        rate: Rate there.
        braking: How fast the rate falls, more than 0.
    """

    __slots__ = ("duration_s", "end_share", "_braking", "_rate", "_start")

    def __init__(self, share: float, rate: float, braking: float) -> None:
        self._start = share
        self._rate = rate
        self._braking = braking
        self.duration_s = rate / braking
        self.end_share = min(share + 0.5 * rate * self.duration_s, 1.0)

    def share(self, elapsed_s: float) -> float:
        """Return the share of the way after a time."""
        way = elapsed_s * (self._rate - 0.5 * self._braking * elapsed_s)
        return min(self._start + way, 1.0)

    def rate(self, elapsed_s: float) -> float:
        """Return the change of the share for each second."""
        return max(self._rate - self._braking * elapsed_s, 0.0)


class PlannedPath:
    """A course on a timing: what the arm's mechanics follow.

    Args:
        course: Where it leads.
        timing: How fast.
        start_s: When it starts.
        braking: How fast its rate falls when it is stopped, in shares a second squared.
    """

    __slots__ = (
        "course",
        "end_deg",
        "end_s",
        "start_deg",
        "start_s",
        "timing",
        "_braking",
        "_memo",
    )

    def __init__(self, course: Course, timing: Timing, start_s: float, braking: float) -> None:
        self.course = course
        self.timing = timing
        self.start_s = start_s
        self.end_s = start_s + timing.duration_s
        self._braking = braking
        self.start_deg = course.start_deg
        self.end_deg = course.end_deg
        self._memo: tuple[float, JointTuple] | None = None

    def at(self, time_s: float) -> JointTuple:
        """Return the joint angles at a time, clamped to start and end."""
        if time_s >= self.end_s:
            return self.end_deg
        if time_s <= self.start_s:
            return self.start_deg
        memo = self._memo
        if memo is None or memo[0] != time_s:
            memo = (time_s, self.course.at(self.timing.share(time_s - self.start_s)))
            self._memo = memo
        return memo[1]

    def speed_mm_s(self, time_s: float) -> float:
        """Return the speed of the tool point, 0 where the course has no length."""
        if not self.start_s <= time_s < self.end_s:
            return 0.0
        return self.course.length_mm * self.timing.rate(time_s - self.start_s)

    def braked(self, time_s: float) -> PlannedPath:
        """Return the path that brakes on this one's course from a time on."""
        elapsed_s = min(max(time_s - self.start_s, 0.0), self.timing.duration_s)
        share = self.timing.share(elapsed_s)
        timing = Braking(share, self.timing.rate(elapsed_s), self._braking)
        path = PlannedPath(self.course, timing, time_s, self._braking)
        path.start_deg = self.at(time_s)
        if timing.end_share <= share:
            path.end_deg = path.start_deg
        elif timing.end_share < 1.0:
            path.end_deg = self.course.at(timing.end_share)
        return path
