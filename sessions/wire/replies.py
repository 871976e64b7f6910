"""Replies as frozen records, one class a shape of answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

State = Literal["STATE_UPDATED", "FINISHED", "FAILED"]
Mode = Literal["STANDARD", "TEACHER", "RECORDED_TEACHER", "RECORDED_TRAJECTORIES"]


@dataclass(frozen=True, slots=True)
class Ready:
    """The cell is free, or it is yours."""


@dataclass(frozen=True, slots=True)
class Busy:
    """Another client has the cell, or it is being cleaned up, or the server sleeps."""


@dataclass(frozen=True, slots=True)
class Ok:
    """Done."""


@dataclass(frozen=True, slots=True)
class Goodbye:
    """The server closes the connection next."""


@dataclass(frozen=True, slots=True)
class ServerInfo:
    """What server this is."""

    type: str
    subtype: str
    protocol: str


@dataclass(frozen=True, slots=True)
class LogFile:
    """One log by its name."""

    name: str
    data: bytes


@dataclass(frozen=True, slots=True)
class LogFiles:
    """All logs."""

    files: tuple[LogFile, ...]


@dataclass(frozen=True, slots=True)
class Goals:
    """Names of the goals."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Environments:
    """Names of the environments in which a goal can be used."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class OfferedView:
    """A view that a task has, and its size in pixels."""

    name: str
    width_px: int
    height_px: int


@dataclass(frozen=True, slots=True)
class TaskOffer:
    """What a task offers; the mode only where the dialect has one."""

    actions: tuple[str, ...]
    views: tuple[OfferedView, ...]
    mode: Mode | None = None


@dataclass(frozen=True, slots=True)
class StateUpdated:
    """The task stands at its start; with a suggested action if there is one."""

    suggestion: str = ""


@dataclass(frozen=True, slots=True)
class ActionDone:
    """An action was carried out.

    Attributes:
        reward: What it earned.
        event: What happened, for people, or empty.
        suggestion: A good next action, or empty.
        state: Whether the task goes on, is solved, or can no longer be solved.
    """

    reward: float
    event: str = ""
    suggestion: str = ""
    state: State = "STATE_UPDATED"


@dataclass(frozen=True, slots=True)
class ViewData:
    """A view and its encoded bytes."""

    name: str
    mime: str
    data: bytes | memoryview


@dataclass(frozen=True, slots=True)
class TrajectoriesCount:
    """How many recorded trajectories there are."""

    count: int


@dataclass(frozen=True, slots=True)
class TrajectoryLength:
    """How many steps a recorded trajectory has."""

    steps: int


@dataclass(frozen=True, slots=True)
class GlobalSeedAlreadySet:
    """The seed of this session was chosen before."""


@dataclass(frozen=True, slots=True)
class NotSupported:
    """The task has no teacher."""


@dataclass(frozen=True, slots=True)
class NoTaskSelected:
    """The command needs a task that is ready, and there is none."""


@dataclass(frozen=True, slots=True)
class UnknownGoal:
    """There is no such goal."""

    goal: str


@dataclass(frozen=True, slots=True)
class UnknownEnvironment:
    """The goal cannot be used in such an environment."""

    environment: str


@dataclass(frozen=True, slots=True)
class UnknownView:
    """The task has no such view."""

    view: str


@dataclass(frozen=True, slots=True)
class UnknownAction:
    """The task has no such action."""

    action: str


@dataclass(frozen=True, slots=True)
class UnknownTrajectory:
    """There is no such recorded trajectory."""

    index: int


@dataclass(frozen=True, slots=True)
class UnknownCommand:
    """The dialect has no such command."""

    command: str


@dataclass(frozen=True, slots=True)
class InvalidArguments:
    """The wrong number or kind of arguments; they come back as they were received."""

    arguments: bytes


@dataclass(frozen=True, slots=True)
class Failure:
    """Anything else went wrong; a short sentence for a person."""

    description: str


Refusal: TypeAlias = (
    GlobalSeedAlreadySet
    | NotSupported
    | NoTaskSelected
    | UnknownGoal
    | UnknownEnvironment
    | UnknownView
    | UnknownAction
    | UnknownTrajectory
    | UnknownCommand
    | InvalidArguments
    | Failure
)
Answer: TypeAlias = (
    Ready
    | Busy
    | Ok
    | Goodbye
    | ServerInfo
    | LogFiles
    | Goals
    | Environments
    | TaskOffer
    | StateUpdated
    | ActionDone
    | ViewData
    | TrajectoriesCount
    | TrajectoryLength
    | Refusal
)

REFUSALS = (
    GlobalSeedAlreadySet,
    NotSupported,
    NoTaskSelected,
    UnknownGoal,
    UnknownEnvironment,
    UnknownView,
    UnknownAction,
    UnknownTrajectory,
    UnknownCommand,
    InvalidArguments,
    Failure,
)
"""The classes of `Refusal`."""
