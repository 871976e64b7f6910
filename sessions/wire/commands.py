"""Commands: from a client's line to a frozen record, and back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

from sessions.errors import RemoteProtocolError
from sessions.wire.dialects import Dialect
from sessions.wire.numbers import parse_count
from sessions.wire.replies import InvalidArguments, UnknownCommand
from sessions.wire.words import quote, split_words


@dataclass(frozen=True, slots=True)
class Status:
    """Is the cell free?"""


@dataclass(frozen=True, slots=True)
class Info:
    """What server is this, and which dialect does it speak?"""


@dataclass(frozen=True, slots=True)
class Done:
    """Say goodbye and close."""


@dataclass(frozen=True, slots=True)
class Sleep:
    """Turn new connections away from now on."""


@dataclass(frozen=True, slots=True)
class Logs:
    """Send the session's log."""


@dataclass(frozen=True, slots=True)
class UseGlobalSeed:
    """Draw everything random in this session from `seed`."""

    seed: int


@dataclass(frozen=True, slots=True)
class ListGoals:
    """Name the goals."""


@dataclass(frozen=True, slots=True)
class ListEnvironments:
    """Name the environments in which `goal` can be used."""

    goal: str


@dataclass(frozen=True, slots=True)
class InitializeTask:
    """Take the cell for `goal` in `environment`."""

    goal: str
    environment: str


@dataclass(frozen=True, slots=True)
class BeginTaskSetup:
    """Settings of the task follow."""


@dataclass(frozen=True, slots=True)
class EndTaskSetup:
    """No more settings: bring the devices up and lay the blocks out."""


@dataclass(frozen=True, slots=True)
class Teaching:
    """Suggest actions from now on, or do not."""

    is_on: bool


@dataclass(frozen=True, slots=True)
class ResetTask:
    """Go back to the task's start."""


@dataclass(frozen=True, slots=True)
class GetView:
    """Send one view."""

    view: str


@dataclass(frozen=True, slots=True)
class Action:
    """Carry out one action."""

    action: str


@dataclass(frozen=True, slots=True)
class Reset:
    """Give the cell back and start a new session."""


@dataclass(frozen=True, slots=True)
class GetTrajectoriesCount:
    """How many recorded trajectories are there?"""


@dataclass(frozen=True, slots=True)
class GetTrajectoryLength:
    """How long is recorded trajectory `index`?"""

    index: int


@dataclass(frozen=True, slots=True)
class Setting:
    """A line between `BEGIN_TASK_SETUP` and `END_TASK_SETUP` that is no command."""

    name: str
    values: tuple[str, ...]


Command: TypeAlias = (
    Status
    | Info
    | Done
    | Sleep
    | Logs
    | UseGlobalSeed
    | ListGoals
    | ListEnvironments
    | InitializeTask
    | BeginTaskSetup
    | EndTaskSetup
    | Teaching
    | ResetTask
    | GetView
    | Action
    | Reset
    | GetTrajectoriesCount
    | GetTrajectoryLength
    | Setting
)


def _teaching(word: str) -> Teaching:
    if word not in ("ON", "OFF"):
        raise RemoteProtocolError(f"TEACHING takes ON or OFF, not {word!r}")
    return Teaching(word == "ON")


_BARE: dict[str, Command] = {
    "STATUS": Status(),
    "INFO": Info(),
    "DONE": Done(),
    "SLEEP": Sleep(),
    "LOGS": Logs(),
    "LIST_GOALS": ListGoals(),
    "BEGIN_TASK_SETUP": BeginTaskSetup(),
    "END_TASK_SETUP": EndTaskSetup(),
    "RESET_TASK": ResetTask(),
    "RESET": Reset(),
    "GET_TRAJECTORIES_COUNT": GetTrajectoriesCount(),
}
_WITH_ONE_WORD: dict[str, Callable[[str], Command]] = {
    "USE_GLOBAL_SEED": lambda word: UseGlobalSeed(parse_count(word)),
    "LIST_ENVIRONMENTS": ListEnvironments,
    "TEACHING": _teaching,
    "GET_VIEW": GetView,
    "ACTION": Action,
    "GET_TRAJECTORY_LENGTH": lambda word: GetTrajectoryLength(parse_count(word)),
}
_VERBS = {type(command): verb for verb, command in _BARE.items()}


@lru_cache(maxsize=512)
def parse_command(
    line: bytes, dialect: Dialect, *, is_in_setup: bool = False
) -> Command | UnknownCommand | InvalidArguments:
    """Read one line of a client.

    Args:
        line: The line without its ending.
        dialect: The dialect that is spoken.
        is_in_setup: Whether the line stands between `BEGIN_TASK_SETUP` and
            `END_TASK_SETUP`, where a line that is no command is a setting.

    Returns:
        The command, or the reply that refuses the line. Whether the command
        exists is judged before its arguments are.
    """
    try:
        text = line.decode("utf-8")
    except UnicodeDecodeError:
        return InvalidArguments(line.partition(b" ")[2])
    verb, _, rest = text.partition(" ")
    is_known = verb in dialect.verbs
    if not is_known and not (verb and is_in_setup):
        return UnknownCommand(verb)
    try:
        words = split_words(text)
        return _command(verb, words[1:]) if is_known else Setting(words[0], words[1:])
    except RemoteProtocolError:
        return InvalidArguments(rest.encode("utf-8"))


def _command(verb: str, arguments: tuple[str, ...]) -> Command:
    bare = _BARE.get(verb)
    if bare is not None:
        if arguments:
            raise RemoteProtocolError(f"{verb} takes no arguments")
        return bare
    if verb == "INITIALIZE_TASK":
        if len(arguments) != 2:
            raise RemoteProtocolError("INITIALIZE_TASK takes a goal and an environment")
        return InitializeTask(*arguments)
    if len(arguments) != 1:
        raise RemoteProtocolError(f"{verb} takes one argument")
    return _WITH_ONE_WORD[verb](arguments[0])


def format_command(command: Command) -> bytes:
    """Return a command's line, without its LF.

    Raises:
        LocalProtocolError: An argument cannot be said in the protocol.
    """
    return " ".join((_verb(command), *map(quote, _arguments(command)))).encode("utf-8")


def _verb(command: Command) -> str:
    match command:
        case UseGlobalSeed():
            return "USE_GLOBAL_SEED"
        case ListEnvironments():
            return "LIST_ENVIRONMENTS"
        case InitializeTask():
            return "INITIALIZE_TASK"
        case Teaching():
            return "TEACHING"
        case GetView():
            return "GET_VIEW"
        case Action():
            return "ACTION"
        case GetTrajectoryLength():
            return "GET_TRAJECTORY_LENGTH"
        case Setting(name=name):
            return quote(name)
        case _:
            return _VERBS[type(command)]


def _arguments(command: Command) -> tuple[str, ...]:
    match command:
        case UseGlobalSeed(seed=number) | GetTrajectoryLength(index=number):
            return (str(number),)
        case ListEnvironments(goal=word) | GetView(view=word) | Action(action=word):
            return (word,)
        case InitializeTask(goal=goal, environment=environment):
            return goal, environment
        case Teaching(is_on=is_on):
            return ("ON" if is_on else "OFF",)
        case Setting(values=values):
            return values
        case _:
            return ()
