"""Replies: from a record to the bytes that leave in one write."""

from __future__ import annotations

from collections.abc import Iterable

from sessions.wire.dialects import Dialect, Teacher
from sessions.wire.numbers import format_reward
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
    LogFiles,
    NoTaskSelected,
    NotSupported,
    Ok,
    Ready,
    ServerInfo,
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
from sessions.wire.words import bare_text, quote_text

FAILED_EVENT = "Task failed"
"""Event text of a failure that has none, where a dialect has no `FAILED`."""

_BARE: dict[type[Answer], str] = {
    Ready: "READY",
    Busy: "BUSY",
    Ok: "OK",
    Goodbye: "GOODBYE",
    GlobalSeedAlreadySet: "GLOBAL_SEED_ALREADY_SET",
    NotSupported: "NOT_SUPPORTED",
    NoTaskSelected: "NO_TASK_SELECTED",
}


def write_answer(answer: Answer, dialect: Dialect) -> tuple[bytes, bytes | memoryview]:
    """Return an answer's lines, each ended by LF, and the binary data that follows them.

    Raises:
        LocalProtocolError: A number in it cannot be said in the protocol.
    """
    if isinstance(answer, ActionDone):
        return _action_done(answer, dialect), b""
    if isinstance(answer, ViewData):
        line = f"VIEW {quote_text(answer.name)} {answer.mime} {len(answer.data)}\n"
        return line.encode("utf-8"), answer.data
    return _other(answer, dialect), b""


def _action_done(answer: ActionDone, dialect: Dialect) -> bytes:
    event, state = answer.event, answer.state
    if state == "FAILED" and not dialect.has_failed:
        event, state = event or FAILED_EVENT, "STATE_UPDATED"
    text = f"REWARD {format_reward(answer.reward)}\n"
    if event:
        text += f"EVENT {quote_text(event) if dialect.quotes_events else bare_text(event)}\n"
    if answer.suggestion and dialect.teacher_word:
        text += f"{dialect.teacher_word} {quote_text(answer.suggestion)}\n"
    return f"{text}{state}\n".encode()


def _other(answer: Answer, dialect: Dialect) -> bytes:
    match answer:
        case InvalidArguments(arguments=arguments):
            return (
                b"INVALID_ARGUMENTS " + arguments + b"\n" if arguments else b"INVALID_ARGUMENTS\n"
            )
        case LogFiles(files=files):
            logs = (b"%s%s" % (_line("LOG_FILE", f.name, str(len(f.data))), f.data) for f in files)
            return b"".join((*logs, b"END_LOGS\n"))
        case ServerInfo():
            lines = (
                ("TYPE", answer.type),
                ("SUBTYPE", answer.subtype),
                ("PROTOCOL", answer.protocol),
            )
            return b"".join(_line(*words) for words in lines)
        case Goals(names=names):
            return _list("GOAL", names, "END_LIST_GOALS")
        case Environments(names=names):
            return _list("ENVIRONMENT", names, "END_LIST_ENVIRONMENTS")
        case TaskOffer():
            return _task_offer(answer, dialect)
        case StateUpdated(suggestion=suggestion):
            has_hint = suggestion and dialect.teacher is Teacher.BY_MODE
            hint = _line(dialect.teacher_word, suggestion) if has_hint else b""
            return hint + b"STATE_UPDATED\n"
        case _:
            return _line(*_words(answer))


def _words(answer: Answer) -> tuple[str, ...]:
    match answer:
        case TrajectoriesCount(count=count):
            return "NB_TRAJECTORIES", str(count)
        case TrajectoryLength(steps=steps):
            return "TRAJECTORY_LENGTH", str(steps)
        case UnknownGoal(goal=name):
            return "UNKNOWN_GOAL", name
        case UnknownEnvironment(environment=name):
            return "UNKNOWN_ENVIRONMENT", name
        case UnknownView(view=name):
            return "UNKNOWN_VIEW", name
        case UnknownAction(action=name):
            return "UNKNOWN_ACTION", name
        case UnknownTrajectory(index=index):
            return "UNKNOWN_TRAJECTORY", str(index)
        case UnknownCommand(command=name):
            return "UNKNOWN_COMMAND", name
        case Failure(description=description):
            return "ERROR", description
        case _:
            return (_BARE[type(answer)],)


def _task_offer(answer: TaskOffer, dialect: Dialect) -> bytes:
    views = (f"{view.name}:{view.width_px}x{view.height_px}" for view in answer.views)
    text = _line("AVAILABLE_ACTIONS", *answer.actions) + _line("AVAILABLE_VIEWS", *views)
    if dialect.has_mode:
        text += _line("MODE", answer.mode or "STANDARD")
    return text


def _list(word: str, names: Iterable[str], end: str) -> bytes:
    return b"".join(_line(word, name) for name in names) + _line(end)


def _line(*words: str) -> bytes:
    return (" ".join(map(quote_text, words)) + "\n").encode("utf-8")
