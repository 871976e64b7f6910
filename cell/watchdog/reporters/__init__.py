"""Whom faults are told to: a Bugzilla, a webhook, a file."""

from cell.watchdog.reporters.assembly import reporters_of
from cell.watchdog.reporters.base import Reporter

__all__ = ["Reporter", "reporters_of"]
