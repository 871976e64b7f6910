"""How commands end: exit codes, and the errors of this package."""

from __future__ import annotations

from enum import IntEnum


class Exit(IntEnum):
    """Exit codes of every command."""

    DONE = 0
    FAILED = 1
    """The check or the task failed."""
    USAGE = 2
    """The command was called wrongly, or names something that does not exist."""
    ENVIRONMENT = 3
    """A device, the network or the file system failed."""
    INTERRUPTED = 130
    BROKEN_PIPE = 141


class ConsoleError(Exception):
    """A command cannot go on; the text is one sentence for a person.

    Attributes:
        exit: The exit code.
    """

    def __init__(self, message: str, exit: Exit = Exit.USAGE) -> None:
        self.exit = exit
        super().__init__(message)
