"""The four versions of MAS in the wild, as a table."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from sessions.errors import LocalProtocolError


class Teacher(Enum):
    """How a client comes to suggested actions."""

    NONE = "none"
    ON_REQUEST = "after TEACHING ON"
    BY_MODE = "whenever the mode is not STANDARD"


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """One version of the protocol.

    Attributes:
        version: What `INFO` answers after `PROTOCOL`.
        verbs: The commands it has.
        teacher: How a client comes to suggested actions.
        teacher_word: First word of the line that suggests an action, or empty.
        quotes_events: Whether event text is a quoted word, or else bare.
        has_mode: Whether `INITIALIZE_TASK` answers a third line, `MODE`.
        has_failed: Whether an action may answer `FAILED`.
        setup_answers_state: Whether `END_TASK_SETUP` answers `STATE_UPDATED`, or else `OK`.
    """

    version: str
    verbs: frozenset[str]
    teacher: Teacher
    teacher_word: str
    quotes_events: bool
    has_mode: bool
    has_failed: bool
    setup_answers_state: bool


_CORE = frozenset(
    {
        "STATUS",
        "INFO",
        "DONE",
        "LIST_GOALS",
        "LIST_ENVIRONMENTS",
        "INITIALIZE_TASK",
        "BEGIN_TASK_SETUP",
        "END_TASK_SETUP",
        "RESET_TASK",
        "GET_VIEW",
        "ACTION",
    }
)
_SERVICE = frozenset({"SLEEP", "LOGS", "USE_GLOBAL_SEED", "RESET"})
_TEACHING = frozenset({"TEACHING"})
_TRAJECTORIES = frozenset({"GET_TRAJECTORIES_COUNT", "GET_TRAJECTORY_LENGTH"})

DIALECTS = {
    dialect.version: dialect
    for dialect in (
        Dialect(
            version="1.2",
            verbs=_CORE,
            teacher=Teacher.NONE,
            teacher_word="",
            quotes_events=False,
            has_mode=False,
            has_failed=False,
            setup_answers_state=False,
        ),
        Dialect(
            version="1.3",
            verbs=_CORE | _SERVICE | _TEACHING,
            teacher=Teacher.ON_REQUEST,
            teacher_word="TEACHER_ACTION",
            quotes_events=True,
            has_mode=False,
            has_failed=True,
            setup_answers_state=False,
        ),
        Dialect(
            version="1.4",
            verbs=_CORE | _SERVICE | _TRAJECTORIES,
            teacher=Teacher.BY_MODE,
            teacher_word="SUGGESTED_ACTION",
            quotes_events=True,
            has_mode=True,
            has_failed=True,
            setup_answers_state=True,
        ),
        Dialect(
            version="1.5",
            verbs=_CORE | _SERVICE | _TEACHING,
            teacher=Teacher.ON_REQUEST,
            teacher_word="TEACHER_ACTION",
            quotes_events=True,
            has_mode=False,
            has_failed=False,
            setup_answers_state=False,
        ),
    )
}
"""Every dialect by its version."""


def dialect_named(version: str) -> Dialect:
    """Return the dialect of a version.

    Raises:
        LocalProtocolError: There is no such version.
    """
    try:
        return DIALECTS[version]
    except KeyError:
        known = ", ".join(DIALECTS)
        raise LocalProtocolError(
            f"there is no MAS dialect {version!r}; there are {known}"
        ) from None
