"""A running task: what an action means and what it earns.

A task knows the lattice and the rules. What really happens is the host's business;
a task tells the host where to go and believes that it went there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dsl.errors import TaskEnded, UnknownName
from dsl.host import Host, Placement
from dsl.layout.arrange import arrange
from dsl.program import Program, Rule
from dsl.teacher import first_step

Status = Literal["running", "finished", "failed"]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What one action brought.

    Attributes:
        step: Number of the step since the start or the last reset, from 1.
        reward: What it earns.
        event: What the client is told, or None.
        status: Whether the task goes on.
        has_moved: Whether the gripper moved.
    """

    step: int
    reward: float
    event: str | None
    status: Status
    has_moved: bool


class Task:
    """One goal in one environment, laid out by a seed.

    Args:
        program: The checked script.
        goal_name: The goal.
        environment_name: The environment; one of the goal's.
        seed: Where every random draw comes from.
        host: The cell it takes place in.

    Raises:
        UnknownName: The program has no such goal, or the goal no such environment.
        InfeasibleLayout: The seed has no layout.
    """

    def __init__(
        self, program: Program, goal_name: str, environment_name: str, seed: int, host: Host
    ) -> None:
        goal = program.goals.get(goal_name)
        if goal is None:
            raise UnknownName("goal", goal_name, program.goals)
        if environment_name not in goal.environments:
            raise UnknownName(f"environment of {goal_name}", environment_name, goal.environments)
        self.goal = goal
        self.environment = program.environments[environment_name]
        self.seed = seed
        self._host = host
        self._layout = arrange(program.store, self.environment, goal, seed)
        self._moves = {
            name: (program.actions[name].dx, program.actions[name].dy)
            for name in self.environment.actions
        }
        self._move_list = tuple(self._moves.values())
        self._rules = tuple(
            (_points_of(rule, self._layout.placements), rule) for rule in goal.rules
        )
        self._position = self._layout.start
        self._steps = 0
        self._status: Status = "running"

    @property
    def placements(self) -> tuple[Placement, ...]:
        """The blocks that lie out, in the order they are laid out."""
        return self._layout.placements

    @property
    def start(self) -> tuple[int, int]:
        """Lattice point where the gripper begins."""
        return self._layout.start

    @property
    def target(self) -> tuple[int, int]:
        """Lattice point of the target."""
        return self._layout.target

    @property
    def position(self) -> tuple[int, int]:
        """Lattice point that the gripper is above."""
        return self._position

    @property
    def steps(self) -> int:
        """Number of steps since the start or the last reset."""
        return self._steps

    @property
    def status(self) -> Status:
        """Whether the task goes on."""
        return self._status

    def set_up(self) -> None:
        """Show the background, lay the blocks out, bring the gripper to the start."""
        self._host.show(self.environment.background)
        self._host.lay_out(self._layout.placements)
        self.reset()

    def reset(self) -> None:
        """Begin anew with the same layout, the gripper back at the start."""
        self._host.move_to(*self._layout.start, self.environment.travel_mm)
        self._position = self._layout.start
        self._steps = 0
        self._status = "running"

    def act(self, action: str) -> Outcome:
        """Do an action and say what it earns; the gripper stands still at a wall.

        An error of the host leaves the task as it was before the action.

        Raises:
            UnknownName: The environment has no such action.
            TaskEnded: The task has finished or failed.
        """
        move = self._moves.get(action)
        if move is None:
            raise UnknownName("action", action, self._moves)
        if self._status != "running":
            raise TaskEnded(self._status)
        x, y = self._position[0] + move[0], self._position[1] + move[1]
        width, height = self.environment.world
        has_moved = 0 <= x < width and 0 <= y < height
        if has_moved:
            self._host.move_to(x, y, self.environment.travel_mm)
            self._position = (x, y)
        self._steps += 1
        rule = self._applying(has_moved)
        self._status = rule.status
        return Outcome(self._steps, rule.reward, rule.event, rule.status, has_moved)

    def suggest(self) -> str | None:
        """Return the next action of a shortest way to the target.

        Returns:
            None at the target, and where no way leads to it.
        """
        index = first_step(
            self.environment.world, self._move_list, self._layout.target, self._position
        )
        return None if index is None else self.environment.actions[index]

    def _applying(self, has_moved: bool) -> Rule:
        """Return the first rule whose condition holds; the last one always does."""
        for points, rule in self._rules:
            match rule.condition.sort:
                case "wall":
                    holds = not has_moved
                case "target":
                    holds = self._position == self._layout.target
                case "steps":
                    holds = self._steps >= rule.condition.steps
                case "otherwise":
                    holds = True
                case _:
                    holds = self._position in points
            if holds:
                return rule
        return self._rules[-1][1]


def _points_of(rule: Rule, placements: tuple[Placement, ...]) -> frozenset[tuple[int, int]]:
    """Return the points of the blocks that a rule's condition speaks of."""
    selector = rule.condition.selector
    return frozenset(
        (p.x, p.y)
        for p in placements
        if rule.condition.sort == "block"
        or (selector is not None and selector.matches(p.kind, p.colour))
    )
