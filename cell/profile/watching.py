"""What watches over the cell between sessions, and whom it tells."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cell.profile.table import Positive, Table, Text

Url = Annotated[str, Field(pattern=r"^https?://[^/\s]+")]


class WatchdogProfile(Table):
    """The test of every component when no session runs (reference 5.2)."""

    enabled: bool = True
    """Whether the components are tested at all."""
    every_s: Positive = 7200.0
    """Time from one round of tests to the next."""
    keep: Annotated[int, Field(ge=1)] = 1000
    """How many test rounds the history keeps."""


class BugzillaProfile(Table):
    """A Bugzilla tracker that failures are filed to (REST)."""

    url: Url
    """Base address, such as `https://bugs.example.org`; `/rest` is added."""
    product: Text
    """Product that the bugs are filed under."""
    component: Text
    """Component of the product."""
    version: str = "unspecified"
    """Version that bugs are filed against."""
    priority: str = "P1"
    """Priority of the bugs, a name that the Bugzilla knows."""
    severity: str = "normal"
    """Severity of the bugs, a name that the Bugzilla knows."""
    """Version of the product."""
    key_variable: str = "ROBOCELL_BUGZILLA_KEY"
    """Environment variable that holds the API key; a profile never does."""
    timeout_s: Positive = 10.0
    """How long a request may take."""


class WebhookProfile(Table):
    """An address that failures are posted to as JSON."""

    url: Url
    """The address."""
    timeout_s: Positive = 10.0
    """How long a request may take."""


class ReportsProfile(Table):
    """Where failures are reported to; any of them, or none."""

    bugzilla: BugzillaProfile | None = None
    """A Bugzilla tracker."""
    webhook: WebhookProfile | None = None
    """An address of your own."""
    file: str = ""
    """Path of a file that gets one JSON object a line."""
