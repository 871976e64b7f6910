"""What watches over the cell between sessions, and whom it tells."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cell.profile.table import Positive, Table


class WatchdogProfile(Table):
    """The test of every component when no session runs (reference 5.2)."""

    enabled: bool = True
    every_s: Positive = 7200.0
    keep: Annotated[int, Field(ge=1)] = 1000
    """How many test rounds the history keeps."""


class BugzillaProfile(Table):
    """A Bugzilla tracker that failures are filed to (REST)."""

    url: str
    """Base address, such as `https://bugs.example.org`; `/rest` is added."""
    product: str
    component: str
    version: str = "unspecified"
    key_variable: str = "ROBOCELL_BUGZILLA_KEY"
    """Environment variable that holds the API key; a profile never does."""
    timeout_s: Positive = 10.0


class WebhookProfile(Table):
    """An address that failures are posted to as JSON."""

    url: str
    timeout_s: Positive = 10.0


class ReportsProfile(Table):
    """Where failures are reported to; any of them, or none."""

    bugzilla: BugzillaProfile | None = None
    webhook: WebhookProfile | None = None
    file: str = ""
    """Path of a file that gets one JSON object a line."""
