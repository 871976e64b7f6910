"""Replies: from a server's bytes to records, for clients.

Theory of operation. A reply says by its first word how it goes on, so a reader
needs the dialect and nothing of the command. `read_answer` is a generator: it
yields what it needs next (`LINE`, or a number of bytes), is sent that, and
returns the record.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Literal, TypeAlias

from sessions.errors import RemoteProtocolError
from sessions.wire.dialects import Dialect, Teacher
from sessions.wire.numbers import parse_count, parse_reward
from sessions.wire.replies import (
    ActionDone,
    Answer,
    Busy,
    Environments,
    Failure,
    GlobalSeedAlreadySet,
    Goals,
    Goodbye,
    InvalidArguments,
    LogFile,
    LogFiles,
    Mode,
    NoTaskSelected,
    NotSupported,
    OfferedView,
    Ok,
    Ready,
    ServerInfo,
    State,
    StateUpdated,
    TaskOffer,
    TrajectoriesCount,
    TrajectoryLength,
    UnknownAction,
    UnknownCommand,
    UnknownEnvironment,
    UnknownGoal,
    UnknownTrajectory,
    UnknownView,
    ViewData,
)
from sessions.wire.words import split_words

LINE: Literal[0] = 0
"""What `read_answer` yields when it needs a line; anything above is a number of bytes."""

MAX_DATA_BYTES = 2**30
"""The most binary data that a reply may announce."""

Reading: TypeAlias = Generator[int, "bytes | bytearray", Answer]

_BARE: dict[str, Answer] = {
    "READY": Ready(),
    "BUSY": Busy(),
    "OK": Ok(),
    "GOODBYE": Goodbye(),
    "GLOBAL_SEED_ALREADY_SET": GlobalSeedAlreadySet(),
    "NOT_SUPPORTED": NotSupported(),
    "NO_TASK_SELECTED": NoTaskSelected(),
    "STATE_UPDATED": StateUpdated(),
    "END_LIST_GOALS": Goals(()),
    "END_LIST_ENVIRONMENTS": Environments(()),
    "END_LOGS": LogFiles(()),
}
_ONE_WORD: dict[str, Callable[[str], Answer]] = {
    "UNKNOWN_GOAL": UnknownGoal,
    "UNKNOWN_ENVIRONMENT": UnknownEnvironment,
    "UNKNOWN_VIEW": UnknownView,
    "UNKNOWN_ACTION": UnknownAction,
    "UNKNOWN_COMMAND": UnknownCommand,
    "UNKNOWN_TRAJECTORY": lambda word: UnknownTrajectory(parse_count(word)),
    "NB_TRAJECTORIES": lambda word: TrajectoriesCount(parse_count(word)),
    "TRAJECTORY_LENGTH": lambda word: TrajectoryLength(parse_count(word)),
}
_STATES: dict[str, State] = {
    "STATE_UPDATED": "STATE_UPDATED",
    "FINISHED": "FINISHED",
    "FAILED": "FAILED",
}
_MODES: dict[str, Mode] = {
    "STANDARD": "STANDARD",
    "TEACHER": "TEACHER",
    "RECORDED_TEACHER": "RECORDED_TEACHER",
    "RECORDED_TRAJECTORIES": "RECORDED_TRAJECTORIES",
}


def read_answer(dialect: Dialect) -> Reading:
    """Read one reply.

    Yields:
        `LINE` for a line (to be sent without its ending), or a number of bytes.

    Returns:
        The reply's record.

    Raises:
        RemoteProtocolError: The server sent what the protocol does not allow.
    """
    line = bytes((yield LINE))
    word, _, rest = line.partition(b" ")
    match word:
        case b"REWARD":
            return (yield from _action_done(_text(rest), dialect))
        case b"VIEW":
            return (yield from _view(_text(rest)))
        case b"INVALID_ARGUMENTS":
            return InvalidArguments(rest)
        case b"TYPE":
            return (yield from _info(_text(rest)))
        case b"GOAL":
            return Goals((yield from _names(line, "GOAL", "END_LIST_GOALS")))
        case b"ENVIRONMENT":
            return Environments((yield from _names(line, "ENVIRONMENT", "END_LIST_ENVIRONMENTS")))
        case b"LOG_FILE":
            return (yield from _logs(line))
        case b"AVAILABLE_ACTIONS":
            return (yield from _task_offer(_text(rest), dialect))
        case b"SUGGESTED_ACTION" if dialect.teacher is Teacher.BY_MODE:
            suggestion = _one_word(_text(rest))
            if (yield LINE) != b"STATE_UPDATED":
                raise RemoteProtocolError("STATE_UPDATED must follow SUGGESTED_ACTION")
            return StateUpdated(suggestion)
        case b"ERROR":
            return Failure(" ".join(split_words(_text(rest))))
        case _:
            return _single_line(_text(line))


def _single_line(line: str) -> Answer:
    bare = _BARE.get(line)
    if bare is not None:
        return bare
    word, _, rest = line.partition(" ")
    if word not in _ONE_WORD:
        raise RemoteProtocolError(f"no reply begins with {line[:80]!r}")
    return _ONE_WORD[word](_one_word(rest))


def _action_done(rest: str, dialect: Dialect) -> Reading:
    reward = parse_reward(rest)
    event = suggestion = ""
    word, rest = yield from _word_and_rest()
    if word == "EVENT":
        event = _one_word(rest) if dialect.quotes_events else rest
        word, rest = yield from _word_and_rest()
    if word == dialect.teacher_word:
        suggestion = _one_word(rest)
        word, rest = yield from _word_and_rest()
    state = _STATES.get(word)
    if state is None or rest or (state == "FAILED" and not dialect.has_failed):
        raise RemoteProtocolError(f"an action's reply cannot go on with {word[:80]!r}")
    return ActionDone(reward, event, suggestion, state)


def _view(rest: str) -> Reading:
    words = split_words(rest)
    if len(words) != 3:
        raise RemoteProtocolError(f"VIEW must be followed by name, type and size, not {rest!r}")
    name, mime, size = words
    data = yield from _data(size)
    return ViewData(name, mime, memoryview(data))


def _info(type_words: str) -> Reading:
    values = [_one_word(type_words)]
    for wanted in ("SUBTYPE", "PROTOCOL"):
        word, rest = yield from _word_and_rest()
        if word != wanted:
            raise RemoteProtocolError(f"{wanted} must follow, not {word!r}")
        values.append(_one_word(rest))
    return ServerInfo(*values)


def _names(
    first: bytes, entry: str, end: str
) -> Generator[int, bytes | bytearray, tuple[str, ...]]:
    names: list[str] = []
    line = _text(first)
    while line != end:
        word, _, rest = line.partition(" ")
        if word != entry:
            raise RemoteProtocolError(f"{entry} or {end} must follow, not {word!r}")
        names.append(_one_word(rest))
        line = _text((yield LINE))
    return tuple(names)


def _logs(first: bytes) -> Reading:
    files: list[LogFile] = []
    line = _text(first)
    while line != "END_LOGS":
        words = split_words(line)
        if len(words) != 3 or words[0] != "LOG_FILE":
            raise RemoteProtocolError(f"LOG_FILE or END_LOGS must follow, not {line[:80]!r}")
        data = yield from _data(words[2])
        files.append(LogFile(words[1], bytes(data)))
        line = _text((yield LINE))
    return LogFiles(tuple(files))


def _task_offer(actions: str, dialect: Dialect) -> Reading:
    word, rest = yield from _word_and_rest()
    if word != "AVAILABLE_VIEWS":
        raise RemoteProtocolError(f"AVAILABLE_VIEWS must follow, not {word!r}")
    views = tuple(_offered_view(view) for view in split_words(rest))
    mode: Mode | None = None
    if dialect.has_mode:
        word, rest = yield from _word_and_rest()
        mode = _MODES.get(rest)
        if word != "MODE" or mode is None:
            raise RemoteProtocolError(f"MODE must follow, not {word!r} {rest!r}")
    return TaskOffer(split_words(actions), views, mode)


def _offered_view(text: str) -> OfferedView:
    name, _, size = text.rpartition(":")
    width, x, height = size.partition("x")
    if not name or not x:
        raise RemoteProtocolError(f"a view must read NAME:WIDTHxHEIGHT, not {text!r}")
    return OfferedView(name, parse_count(width), parse_count(height))


def _data(size: str) -> Generator[int, bytes | bytearray, bytes | bytearray]:
    count = parse_count(size, MAX_DATA_BYTES)
    return (yield count) if count else b""


def _word_and_rest() -> Generator[int, bytes | bytearray, tuple[str, str]]:
    word, _, rest = _text((yield LINE)).partition(" ")
    return word, rest


def _one_word(text: str) -> str:
    words = split_words(text)
    if len(words) != 1:
        raise RemoteProtocolError(f"one word is wanted, not {text[:80]!r}")
    return words[0]


def _text(line: bytes | bytearray) -> str:
    try:
        return line.decode("utf-8")
    except UnicodeDecodeError as error:
        raise RemoteProtocolError(f"a line is not UTF-8: {bytes(line[:80])!r}") from error
