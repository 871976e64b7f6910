"""Makes a recorder for each session and leads the wires' traffic to the one that runs."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path

from calibration.applying import calibrated_profile
from calibration.errors import CalibrationError
from cell.clock import Clock
from cell.errors import ProfileError
from cell.events import EventBus
from cell.links.base import Direction
from cell.profile import parse_profile
from sessions.journal import SessionStart
from sessions.recording import layout
from sessions.recording.file import RecordingFile
from sessions.recording.pictures import PictureStorage
from sessions.recording.recorder import SessionRecorder


class SwitchedTap:
    """A tap that exists before any session does: it shows traffic to the present recorder.

    A cell is built once and its links keep their tap; sessions come and go.
    """

    def __init__(self) -> None:
        self._recorder: SessionRecorder | None = None

    def switch_to(self, recorder: SessionRecorder | None) -> None:
        """Show traffic to another recorder, or to nobody."""
        self._recorder = recorder

    def __call__(self, link: str, direction: Direction, data: bytes) -> None:
        """Hand bytes on to the present recorder, if there is one."""
        recorder = self._recorder
        if recorder is not None:
            recorder.wire(link, direction, data)


class RecorderFactory:
    """Opens `<session id>.mcap` in a folder for each session."""

    def __init__(
        self,
        folder: Path,
        events: EventBus,
        clock: Clock,
        views: PictureStorage = "jpeg",
        *,
        tap: SwitchedTap | None = None,
        wall_clock: Callable[[], datetime] = lambda: datetime.now(UTC),
    ) -> None:
        """Prepare; nothing is written yet.

        Args:
            folder: Where recordings are kept.
            events: The cell's events.
            clock: The cell's clock.
            views: How pictures of views are kept.
            tap: The tap that the cell's links were given; a new one if None.
            wall_clock: Tells the date at which a session starts.
        """
        self._folder = folder
        self._events = events
        self._clock = clock
        self._views = views
        self._wall_clock = wall_clock
        self.tap = SwitchedTap() if tap is None else tap

    def __call__(self, start: SessionStart) -> SessionRecorder:
        """Begin the recording of a session.

        Raises:
            RecordingError: The file cannot be created or written.
        """
        recorder = SessionRecorder(
            RecordingFile(self._folder / f"{start.session_id}.mcap"),
            start,
            events=self._events,
            clock=self._clock,
            views=self._views,
            calibration=_calibration(start),
            started_utc=self._wall_clock(),
        )
        self.tap.switch_to(recorder)
        return recorder


def _calibration(start: SessionStart) -> Mapping[str, str]:
    """Return the calibrated values that the cell knows and what they come from, as JSON."""
    values = {
        f"{layout.IN_FORCE_PREFIX}{record.kind}/{record.subject}": json.dumps(
            {
                "identity": record.identity,
                "grade": record.grade.value,
                "accuracy": record.accuracy.stated,
                "unit": record.accuracy.unit,
                "measured_at": record.measured_at.isoformat(),
            }
        )
        for record in start.calibrations
    }
    try:
        profile = parse_profile(start.profile_text, "the session's profile")
        profile = calibrated_profile(profile, start.calibrations)
    except (ProfileError, CalibrationError):
        return values
    values |= {
        f"plane_map/{name}": json.dumps(camera.plane_map)
        for name, camera in profile.cameras.items()
        if camera.plane_map is not None
    }
    values["lattice"] = profile.lattice.model_dump_json()
    return values
