"""Commanded against reached joint angles of an arm of hobby servos.

A joint reaches what its servo makes of the command, less what its gears and links give way to
weight:

    reached = map(commanded) + sag(reached)

The map of a joint is a monotone cubic through knots: slopes by three-point differences, held
to what keeps a piece monotone (Fritsch and Carlson 1980). Sag is a spring at each of the joints
that lean, J2 to J4: the turn is the torque of what hangs beyond it, at the pose that is
reached. With p = q2 + q3 + q4 (how far the hand points down from level) the moment beyond the
elbow is as cos(q2 + q3) + share · cos p, beyond the wrist as cos p. The upper arm's own weight
acts with q2 alone and is part of J2's map.

Given what shall be reached, the command is the map's inverse at reached - sag(reached): no
iteration, so that a command leads to where it should to the rounding of the map's inverse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cell.errors import CellError, ProfileError
from cell.profile.lynx import LynxCorrectionProfile

Array = NDArray[np.float64]
Five = tuple[float, float, float, float, float]

_SLACK_DEG: Final = 1e-9
_STEPS: Final = 60
_STEEPEST: Final = 3.0
"""A monotone cubic's end slopes are at most three times its mean slope (Fritsch, Carlson)."""


class OutsideServoMap(CellError):
    """An angle lies where a joint was not measured.

    Attributes:
        joint: The joint, such as `J3`.
        value: The angle, degrees.
        low: Least measured angle.
        high: Greatest measured angle.
    """

    def __init__(self, joint: str, what: str, value: float, low: float, high: float) -> None:
        self.joint, self.value, self.low, self.high = joint, value, low, high
        super().__init__(
            f"{joint}: the {what} angle {value:.2f} deg lies outside what was measured, "
            f"{low:.2f} to {high:.2f} deg; choose another pose, or measure the servo there"
        )


@dataclass(frozen=True, slots=True)
class ServoMap:
    """Where a servo goes when it is told to.

    Attributes:
        knots_deg: Pairs of commanded and reached angle, both growing.
        joint: Its name, for messages.

    Raises:
        ProfileError: There are fewer than two knots, or they do not grow.
    """

    knots_deg: tuple[tuple[float, float], ...]
    joint: str = "joint"

    def __post_init__(self) -> None:
        """Check that the knots grow."""
        grows = all(
            b[0] > a[0] and b[1] > a[1]
            for a, b in zip(self.knots_deg, self.knots_deg[1:], strict=False)
        )
        if len(self.knots_deg) < 2 or not grows:
            raise ProfileError(
                f"{self.joint}: a servo map needs two pairs of commanded and reached angle or "
                "more, both growing from pair to pair"
            )

    @staticmethod
    def straight(low_deg: float, high_deg: float, joint: str = "joint") -> ServoMap:
        """Return the map of a servo that goes where it is told to."""
        return ServoMap(((low_deg, low_deg), (high_deg, high_deg)), joint)

    @property
    def commanded_range_deg(self) -> tuple[float, float]:
        """Least and greatest commanded angle."""
        return self.knots_deg[0][0], self.knots_deg[-1][0]

    @property
    def reached_range_deg(self) -> tuple[float, float]:
        """Least and greatest reached angle."""
        return self.knots_deg[0][1], self.knots_deg[-1][1]

    def reached(self, commanded_deg: float) -> float:
        """Return where the servo goes.

        Raises:
            OutsideServoMap: It was not measured there.
        """
        low, high = self.commanded_range_deg
        if not low - _SLACK_DEG <= commanded_deg <= high + _SLACK_DEG:
            raise OutsideServoMap(self.joint, "commanded", commanded_deg, low, high)
        return float(self.reached_all(np.array([min(max(commanded_deg, low), high)]))[0])

    def commanded(self, reached_deg: float) -> float:
        """Return what to command so that the servo goes there: the inverse of `reached`.

        Raises:
            OutsideServoMap: It was not measured there.
        """
        low, high = self.reached_range_deg
        if not low - _SLACK_DEG <= reached_deg <= high + _SLACK_DEG:
            raise OutsideServoMap(self.joint, "reached", reached_deg, low, high)
        return float(self.commanded_all(np.array([min(max(reached_deg, low), high)]))[0])

    def reached_all(self, commanded_deg: Array) -> Array:
        """Return reached angles (n,) of commanded ones; beyond the ends, those of the ends."""
        x, y = self._columns()
        piece, part = _pieces(x, commanded_deg)
        return _hermite(x, y, _slopes(x, y), piece, part)

    def commanded_all(self, reached_deg: Array) -> Array:
        """Return commanded angles (n,) of reached ones; beyond the ends, those of the ends.

        Newton's method within each piece, kept between bounds that shrink; the residue is
        rounding.
        """
        x, y = self._columns()
        slopes = _slopes(x, y)
        target = np.clip(reached_deg, y[0], y[-1])
        piece, part = _pieces(y, target)
        low, high = np.zeros_like(part), np.ones_like(part)
        for _ in range(_STEPS):
            miss = _hermite(x, y, slopes, piece, part) - target
            low, high = np.where(miss < 0, part, low), np.where(miss > 0, part, high)
            slope = _hermite_slope(x, y, slopes, piece, part)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = part - miss / slope
            inside = (newton > low) & (newton < high)
            after = np.where(miss == 0, part, np.where(inside, newton, 0.5 * (low + high)))
            if np.abs(after - part).max(initial=0.0) < 1e-15:
                break
            part = after
        answer: Array = x[piece] + part * (x[piece + 1] - x[piece])
        return answer

    def _columns(self) -> tuple[Array, Array]:
        pairs = np.array(self.knots_deg)
        return pairs[:, 0], pairs[:, 1]


@dataclass(frozen=True, slots=True, kw_only=True)
class SagModel:
    """How far the leaning joints give way; all zero for an arm that does not.

    Attributes:
        shoulder_deg: Turn of J2, downwards, with forearm level and no weight in the hand.
        elbow_deg: Turn of J3 at the same.
        wrist_deg: Turn of J4 with the hand level.
        hand_share: Moment of the hand and what it holds about the wrist over the moment of
            forearm and hand about the elbow, both level, hand pointing on.
    """

    shoulder_deg: float = 0.0
    elbow_deg: float = 0.0
    wrist_deg: float = 0.0
    hand_share: float = 0.0

    def turn_all(self, reached_deg: Array) -> Array:
        """Return the turns (n, 5) in degrees of joints (n, 5) that are reached."""
        forearm = np.cos(np.radians(reached_deg[:, 1] + reached_deg[:, 2]))
        hand = np.cos(np.radians(reached_deg[:, 1:4].sum(axis=1)))
        beyond = forearm + self.hand_share * hand
        zero = np.zeros_like(hand)
        return np.stack(
            [
                zero,
                self.shoulder_deg * beyond,
                self.elbow_deg * beyond,
                self.wrist_deg * hand,
                zero,
            ],
            axis=1,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmCorrection:
    """What to command so that the arm reaches what it should.

    Attributes:
        maps: Of J1 to J5.
        sag: Of the leaning joints.
    """

    maps: tuple[ServoMap, ServoMap, ServoMap, ServoMap, ServoMap]
    sag: SagModel = SagModel()

    @staticmethod
    def from_profile(profile: LynxCorrectionProfile) -> ArmCorrection:
        """Return the correction that a profile describes."""
        a, b, c, d, e = (
            ServoMap(knots, f"J{number}") for number, knots in enumerate(profile.maps_deg, 1)
        )
        sag = profile.sag
        return ArmCorrection(
            maps=(a, b, c, d, e),
            sag=SagModel(
                shoulder_deg=sag.shoulder_deg,
                elbow_deg=sag.elbow_deg,
                wrist_deg=sag.wrist_deg,
                hand_share=sag.hand_share,
            ),
        )

    def reached(self, commanded_deg: Sequence[float]) -> Five:
        """Return where the arm stands after a command.

        Raises:
            OutsideServoMap: A joint was not measured there.
        """
        at_rest = [m.reached(angle) for m, angle in zip(self.maps, commanded_deg, strict=True)]
        return _five(self._settled(np.array([at_rest]))[0])

    def command_for(self, wanted_deg: Sequence[float]) -> Five:
        """Return what to command so that the arm reaches joint angles.

        Raises:
            OutsideServoMap: A joint was not measured there.
        """
        turn = self.sag.turn_all(np.array([wanted_deg], np.float64))[0]
        return _five(
            [
                m.commanded(angle - float(by))
                for m, angle, by in zip(self.maps, wanted_deg, turn, strict=True)
            ]
        )

    def reached_all(self, commanded_deg: Array) -> Array:
        """Return reached joints (n, 5) of commanded ones; beyond the ends, those of the ends."""
        at_rest = np.stack(
            [m.reached_all(commanded_deg[:, i]) for i, m in enumerate(self.maps)], axis=1
        )
        return self._settled(at_rest)

    def _settled(self, at_rest: Array) -> Array:
        """Return where joints (n, 5) come to rest under weight: each turn lessens the next."""
        reached = at_rest
        for _ in range(_STEPS):
            after = at_rest + self.sag.turn_all(reached)
            if np.abs(after - reached).max(initial=0.0) < 1e-12:
                break
            reached = after
        return reached


def slope_matrix(knots: Array) -> Array:
    """Return the matrix (k, k) that takes values at knots to three-point slopes, unlimited."""
    count = knots.size
    matrix = np.zeros((count, count))
    if count == 2:
        matrix[:, 0], matrix[:, 1] = -1.0, 1.0
        return np.array(matrix / (knots[1] - knots[0]))
    width = np.diff(knots)
    for i in range(1, count - 1):
        a, b = width[i - 1], width[i]
        matrix[i, i - 1] = -b / (a * (a + b))
        matrix[i, i] = (b - a) / (a * b)
        matrix[i, i + 1] = a / (b * (a + b))
    for end, near, far, sign in ((0, 1, 2, 1.0), (count - 1, count - 2, count - 3, -1.0)):
        a, b = abs(knots[near] - knots[end]), abs(knots[far] - knots[near])
        matrix[end, end] = -sign * (2 * a + b) / (a * (a + b))
        matrix[end, near] = sign * (a + b) / (a * b)
        matrix[end, far] = -sign * a / (b * (a + b))
    return matrix


def basis(knots: Array, at: Array) -> Array:
    """Return the matrix (n, k) from values at knots to the cubic at angles (n,), unlimited.

    It is the map's own cubic wherever no slope has to be held back.
    """
    piece, part = _pieces(knots, at)
    width = knots[piece + 1] - knots[piece]
    slopes = slope_matrix(knots)
    h00, h10, h01, h11 = _weights(part)
    matrix = (h10 * width)[:, None] * slopes[piece] + (h11 * width)[:, None] * slopes[piece + 1]
    rows = np.arange(at.size)
    matrix[rows, piece] += h00
    matrix[rows, piece + 1] += h01
    return matrix


def _slopes(x: Array, y: Array) -> Array:
    """Return monotone slopes at the knots."""
    slopes: Array = slope_matrix(x) @ y
    mean = np.diff(y) / np.diff(x)
    limit = np.full(x.size, np.inf)
    limit[:-1] = np.minimum(limit[:-1], _STEEPEST * mean)
    limit[1:] = np.minimum(limit[1:], _STEEPEST * mean)
    held: Array = np.clip(slopes, 0.0, limit)
    return held


def _pieces(knots: Array, at: Array) -> tuple[NDArray[np.intp], Array]:
    """Return the piece of each angle and how far along it lies, 0 to 1."""
    piece: NDArray[np.intp] = np.clip(
        np.searchsorted(knots, at, side="right") - 1, 0, knots.size - 2
    )
    part = (at - knots[piece]) / (knots[piece + 1] - knots[piece])
    return piece, np.clip(part, 0.0, 1.0)


def _weights(t: Array) -> tuple[Array, Array, Array, Array]:
    square, cube = t * t, t * t * t
    return (
        2 * cube - 3 * square + 1,
        cube - 2 * square + t,
        -2 * cube + 3 * square,
        cube - square,
    )


def _hermite(x: Array, y: Array, slopes: Array, piece: NDArray[np.intp], t: Array) -> Array:
    h00, h10, h01, h11 = _weights(t)
    width = x[piece + 1] - x[piece]
    value: Array = (
        h00 * y[piece]
        + h01 * y[piece + 1]
        + width * (h10 * slopes[piece] + h11 * slopes[piece + 1])
    )
    return value


def _hermite_slope(x: Array, y: Array, slopes: Array, piece: NDArray[np.intp], t: Array) -> Array:
    """Return the slope along the part of the piece (degrees for all of it)."""
    width = x[piece + 1] - x[piece]
    value: Array = 6 * t * (1 - t) * (y[piece + 1] - y[piece]) + width * (
        (3 * t * t - 4 * t + 1) * slopes[piece] + (3 * t * t - 2 * t) * slopes[piece + 1]
    )
    return value


def _five(values: Sequence[float] | Array) -> Five:
    a, b, c, d, e = (float(value) for value in values)
    return a, b, c, d, e
