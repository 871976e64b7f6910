"""Recordings of sessions: one MCAP file each, written as it happens, readable after a crash."""

from sessions.recording.errors import RecordingError, RecordingNotFound
from sessions.recording.factory import RecorderFactory, SwitchedTap
from sessions.recording.library import (
    RecordingSummary,
    find_recording,
    list_recordings,
    sessions_folder,
)
from sessions.recording.names import new_session_id
from sessions.recording.pictures import PictureStorage
from sessions.recording.reader import (
    RecordedBytes,
    RecordedEvent,
    RecordedStep,
    RecordedView,
    SessionRecording,
    ViewReference,
)
from sessions.recording.recorder import SessionRecorder

__all__ = [
    "PictureStorage",
    "RecordedBytes",
    "RecordedEvent",
    "RecordedStep",
    "RecordedView",
    "RecorderFactory",
    "RecordingError",
    "RecordingNotFound",
    "RecordingSummary",
    "SessionRecorder",
    "SessionRecording",
    "SwitchedTap",
    "ViewReference",
    "find_recording",
    "list_recordings",
    "new_session_id",
    "sessions_folder",
]
