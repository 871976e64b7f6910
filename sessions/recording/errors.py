"""What can go wrong with a recording."""

from __future__ import annotations

from sessions.errors import SessionsError


class RecordingError(SessionsError):
    """A recording cannot be written, found or read; the text names the file."""


class RecordingNotFound(RecordingError):
    """There is no recording of that name, or several are meant."""
