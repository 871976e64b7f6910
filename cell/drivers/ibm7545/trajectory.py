"""Where the joints shall be at each moment: cubic segments through via points.

A segment's time is that of its slowest joint at its mean speed, plus a fixed time. At a
via point a joint's speed is zero when its mean slopes before and after differ in sign or
either is zero, else their average; at start and end the joints are at rest (Bloch 1994,
section 5.3). Everything here is in joint units or in pulses alike.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from math import ceil, dist
from typing import TypeAlias

from cell.geometry import JointPositions, Pose
from cell.kinematics.arm import ArmKinematics
from cell.kinematics.line import pose_between
from cell.profile.ibm7545 import Four

PEAK = 1.5
"""Greatest speed of a cubic segment from rest to rest, by its mean speed."""

_Cubic: TypeAlias = tuple[float, float, float, float]


class Trajectory:
    """A motion through via points.

    Args:
        points: At least two, each with a value for each joint.
        durations_s: Time of each segment, one fewer than points.
    """

    def __init__(self, points: Sequence[tuple[float, ...]], durations_s: Sequence[float]) -> None:
        self._ends_s = list(accumulate(durations_s))
        self._starts_s = [0.0, *self._ends_s[:-1]]
        self._end = points[-1]
        speeds = _via_speeds(points, durations_s)
        self._segments = [
            tuple(
                _cubic(p, q, v, w, duration_s)
                for p, q, v, w in zip(
                    points[i], points[i + 1], speeds[i], speeds[i + 1], strict=True
                )
            )
            for i, duration_s in enumerate(durations_s)
        ]

    @property
    def duration_s(self) -> float:
        """Time from start to end."""
        return self._ends_s[-1]

    @property
    def end(self) -> tuple[float, ...]:
        """Where it ends."""
        return self._end

    def at(self, time_s: float) -> tuple[float, ...]:
        """Return the joints at a time; the end's after it."""
        if time_s >= self._ends_s[-1]:
            return self._end
        index = bisect_right(self._ends_s, time_s)
        t = time_s - self._starts_s[index]
        return tuple([a + t * (b + t * (c + t * d)) for a, b, c, d in self._segments[index]])


@dataclass(frozen=True, slots=True)
class Pace:
    """How fast joints and tool may go.

    Attributes:
        joint_speed: Mean speed of each joint at 100 %, in its unit a second.
        percent: Share of it that is asked for.
        linear_mm_s: Greatest speed of the tool point along a line.
        extra_s: Added to the time of each segment.
    """

    joint_speed: Four
    percent: float
    linear_mm_s: float
    extra_s: float

    def segment_s(self, first: Sequence[float], last: Sequence[float]) -> float:
        """Return the time of a segment: the slowest joint's, plus the fixed time."""
        return self._slowest_s(first, last) * 100.0 / self.percent + self.extra_s

    def line_s(self, way_mm: float) -> float:
        """Return the time of a line from rest to rest at its greatest speed."""
        return PEAK * way_mm / self.linear_mm_s + self.extra_s

    def overspeed(self, first: Sequence[float], last: Sequence[float], duration_s: float) -> float:
        """Return by what factor the fastest joint is beyond its peak speed within a line."""
        return self._slowest_s(first, last) / (PEAK * duration_s)

    def _slowest_s(self, first: Sequence[float], last: Sequence[float]) -> float:
        return max(
            abs(b - a) / speed for a, b, speed in zip(first, last, self.joint_speed, strict=True)
        )


@dataclass(frozen=True, slots=True)
class Course:
    """Via points in joint units with the time of each segment between them."""

    points: tuple[JointPositions, ...]
    durations_s: tuple[float, ...]


def joint_course(start: JointPositions, end: JointPositions, pace: Pace) -> Course:
    """Return the course of all joints at once."""
    return Course((start, end), (pace.segment_s(start.values, end.values),))


def line_course(
    kinematics: ArmKinematics,
    start: JointPositions,
    target: Pose,
    posture: int,
    pace: Pace,
    *,
    via_s: float,
) -> Course:
    """Return the course of the tool point along a line, from rest to rest.

    The line is cut where the tool point is at equal times, its way being a cubic of time.

    Raises:
        UnreachablePose: The arm cannot follow the line.
    """
    first = kinematics.forward(start)
    end = kinematics.solve(target, posture, start)
    way_mm = dist((first.x_mm, first.y_mm, first.z_mm), (target.x_mm, target.y_mm, target.z_mm))
    duration_s = max(pace.line_s(way_mm), PEAK * pace.segment_s(start.values, end.values))
    count = max(2, ceil(duration_s / via_s))
    points = [start]
    for index in range(1, count):
        share = index / count
        eased = share * share * (3.0 - 2.0 * share)
        points.append(kinematics.solve(pose_between(first, target, eased), posture, points[-1]))
    points.append(kinematics.solve(target, posture, points[-1]))
    step_s = duration_s / count
    stretch = max(pace.overspeed(p.values, q.values, step_s) for p, q in pairwise(points))
    return Course(tuple(points), (step_s * max(1.0, stretch),) * count)


def _via_speeds(
    points: Sequence[tuple[float, ...]], durations_s: Sequence[float]
) -> list[tuple[float, ...]]:
    slopes = [
        tuple((q - p) / duration_s for p, q in zip(points[i], points[i + 1], strict=True))
        for i, duration_s in enumerate(durations_s)
    ]
    rest = (0.0,) * len(points[0])
    between = [
        tuple(0.5 * (a + b) if a * b > 0.0 else 0.0 for a, b in zip(before, after, strict=True))
        for before, after in pairwise(slopes)
    ]
    return [rest, *between, rest]


def _cubic(p: float, q: float, v: float, w: float, duration_s: float) -> _Cubic:
    """Return the cubic from p with speed v to q with speed w, constant term first."""
    way = q - p
    return (
        p,
        v,
        (3.0 * way / duration_s - 2.0 * v - w) / duration_s,
        ((v + w) - 2.0 * way / duration_s) / (duration_s * duration_s),
    )
