"""What a session needs of a script: what it offers, and its running tasks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from dsl.host import Host

Status = Literal["running", "finished", "failed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewSpec:
    """A view of a task.

    Attributes:
        name: Its name in the script, such as `CAMERA_TOP`.
        mime: Format of its pictures, such as `image/mif`.
        width_px: Width of its pictures.
        height_px: Height of its pictures.
    """

    name: str
    mime: str
    width_px: int
    height_px: int


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskSpec:
    """A goal in an environment, as far as a client is concerned.

    Attributes:
        goal: Name of the goal.
        environment: Name of the environment.
        actions: Names of its actions.
        views: What can be seen.
        is_teaching: Whether actions are suggested.
        accuracy_mm: How well the cell must be known; None where nothing is demanded.
    """

    goal: str
    environment: str
    actions: tuple[str, ...]
    views: tuple[ViewSpec, ...]
    is_teaching: bool
    accuracy_mm: float | None = None


class Outcome(Protocol):
    """What an action led to."""

    @property
    def step(self) -> int:
        """How many actions were carried out since the start."""

    @property
    def reward(self) -> float:
        """What the action earned."""

    @property
    def event(self) -> str | None:
        """What happened, for people, if there is anything to tell."""

    @property
    def status(self) -> Status:
        """Whether the task goes on, is solved, or can no longer be solved."""


class RunningTask(Protocol):
    """A task on a host; every call returns when the cell has done it."""

    def set_up(self) -> None:
        """Show the background, lay the blocks out, go to the start."""

    def act(self, action: str) -> Outcome:
        """Carry out one action."""

    def reset(self) -> None:
        """Go back to the start."""

    def suggest(self) -> str | None:
        """Return the next action of a shortest path to the target, if there is one."""


class Script(Protocol):
    """A checked script that can be served."""

    @property
    def name(self) -> str:
        """File name of the script."""

    @property
    def text(self) -> str:
        """Its text."""

    @property
    def goals(self) -> tuple[str, ...]:
        """Names of its goals, in the script's order."""

    def environments(self, goal: str) -> tuple[str, ...]:
        """Return the names of the environments of a goal, in the script's order."""

    def task(self, goal: str, environment: str) -> TaskSpec:
        """Return what a goal in an environment offers."""

    def start(self, goal: str, environment: str, *, seed: int, host: Host) -> RunningTask:
        """Return a new task, not set up yet."""
