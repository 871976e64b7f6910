"""What inverse kinematics answers: solutions, and why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from cell.geometry import JointPositions
from cell.kinematics.flags import posture_name


class LimitViolation(NamedTuple):
    """A joint angle outside its limits; a named tuple, because many are made.

    Attributes:
        joint: Name of the joint, such as `J5`.
        value_deg: The angle a solution needs.
        limit_deg: The limit it passes.
    """

    joint: str
    value_deg: float
    limit_deg: float

    @property
    def excess_deg(self) -> float:
        """How far the angle lies beyond the limit."""
        return abs(self.value_deg - self.limit_deg)

    def __str__(self) -> str:
        return f"{self.joint} at {self.value_deg:.2f} deg, limit {self.limit_deg:.2f} deg"


class IkSolution(NamedTuple):
    """One way to stand at a pose; a named tuple, because eight are made for each pose.

    Attributes:
        joints: The joint angles.
        posture: The controller's flag FL1.
        turns: The controller's flag FL2.
        violations: The joint limits it would violate; empty when the arm can stand so.
    """

    joints: JointPositions
    posture: int
    turns: int
    violations: tuple[LimitViolation, ...]

    @property
    def is_allowed(self) -> bool:
        """Whether every joint is within its limits."""
        return not self.violations

    @property
    def worst_deg(self) -> float:
        """The largest excess over a joint limit, 0 when there is none."""
        return max((violation.excess_deg for violation in self.violations), default=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReachProblem:
    """Why a pose cannot be reached.

    Attributes:
        what: What fails: a joint such as `J5`, or `reach`, from shoulder to wrist.
        value: The value the pose asks for.
        limit: The value it may have at most (or at least).
        unit: `deg` or `mm`.
        text: One sentence for people.
        posture: The posture that was examined, None for the best of all.
    """

    what: str
    value: float
    limit: float
    unit: str
    text: str
    posture: int | None = None

    def __str__(self) -> str:
        form = "" if self.posture is None else f" with posture {posture_name(self.posture)}"
        return f"{self.text}{form}"
