"""The errors of `dsl`: one tree.

Mistakes in a script are diagnostics, not exceptions; these are for programs that
use a script.

DslError
├── UnknownName       the program, the environment or the library has no such thing
├── InfeasibleLayout  this seed has no layout that keeps every requirement
└── TaskEnded         the task is over until it is reset
"""

from __future__ import annotations

from collections.abc import Iterable


class DslError(Exception):
    """Base of every error raised by `dsl`; its text is fit for a user."""


class UnknownName(DslError):
    """There is nothing of that name.

    Attributes:
        sort: What was looked for, such as `goal`.
        name: The name asked for.
        known: The names there are.
    """

    def __init__(self, sort: str, name: str, known: Iterable[str]) -> None:
        self.sort = sort
        self.name = name
        self.known = tuple(known)
        super().__init__(f"there is no {sort} {name!r}; there are: {', '.join(self.known) or '-'}")


class InfeasibleLayout(DslError):
    """No layout of a task keeps every requirement, or none was found within the budget.

    Attributes:
        goal: Name of the goal.
        environment: Name of the environment.
        seed: The seed that was asked for.
        blame: What makes it impossible, such as `with gap >= 6 at most 1 block fits
            into 4 x 4, 2 are asked for`.
    """

    def __init__(self, goal: str, environment: str, seed: int, blame: str) -> None:
        self.goal = goal
        self.environment = environment
        self.seed = seed
        self.blame = blame
        super().__init__(f"goal {goal} in {environment} has no layout for seed {seed}: {blame}")


class TaskEnded(DslError):
    """An action was asked for after the task had finished or failed."""

    def __init__(self, status: str) -> None:
        self.status = status
        super().__init__(f"the task has {status}; reset it before the next action")
