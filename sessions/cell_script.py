"""A checked `.cell` script, as sessions serve it."""

from __future__ import annotations

from dataclasses import dataclass

from dsl.host import Host
from dsl.interpreter import Task
from dsl.program import Program
from sessions.script import RunningTask, TaskSpec, ViewSpec


@dataclass(frozen=True, slots=True)
class CellScript:
    """A script's name, text and program.

    Attributes:
        name: File name of the script.
        text: Its text, for recordings.
        program: What it means.
    """

    name: str
    text: str
    program: Program

    @property
    def goals(self) -> tuple[str, ...]:
        """Names of its goals, in the script's order."""
        return tuple(self.program.goals)

    def environments(self, goal: str) -> tuple[str, ...]:
        """Return the names of the environments of a goal, in the script's order."""
        return self.program.goals[goal].environments

    def task(self, goal: str, environment: str) -> TaskSpec:
        """Return what a goal in an environment offers."""
        place = self.program.environments[environment]
        limits = [a.limit_mm for a in (place.accuracy, self.program.goals[goal].accuracy) if a]
        views = (
            ViewSpec(name=v.name, mime=v.mime, width_px=v.width_px, height_px=v.height_px)
            for v in place.views
        )
        return TaskSpec(
            goal=goal,
            environment=environment,
            actions=place.actions,
            views=tuple(views),
            is_teaching=place.is_teaching,
            accuracy_mm=min(limits, default=None),
        )

    def start(self, goal: str, environment: str, *, seed: int, host: Host) -> RunningTask:
        """Return a new task, not set up yet.

        Raises:
            InfeasibleLayout: The script has no layout for this seed.
        """
        return Task(self.program, goal, environment, seed, host)
