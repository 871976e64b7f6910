"""From the profile's `[reports]` to the trackers."""

from __future__ import annotations

from pathlib import Path

from cell.profile import ReportsProfile
from cell.watchdog.reporters.base import Reporter
from cell.watchdog.reporters.bugzilla import Bugzilla
from cell.watchdog.reporters.file import ReportFile
from cell.watchdog.reporters.webhook import Webhook


def reporters_of(profile: ReportsProfile) -> tuple[Reporter, ...]:
    """Return the trackers that a profile names; there may be none."""
    reporters: list[Reporter] = []
    if profile.bugzilla is not None:
        reporters.append(Bugzilla(profile.bugzilla))
    if profile.webhook is not None:
        reporters.append(Webhook(profile.webhook))
    if profile.file:
        reporters.append(ReportFile(Path(profile.file).expanduser()))
    return tuple(reporters)
