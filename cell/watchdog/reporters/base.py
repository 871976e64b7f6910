"""What the outbox needs of a tracker."""

from __future__ import annotations

from typing import Protocol

from cell.watchdog.evidence import Attachment
from cell.watchdog.report import Report


class Reporter(Protocol):
    """Somewhere that keeps track of faults.

    Both verbs raise `ReportUndelivered` when the tracker is down or refuses.
    """

    @property
    def name(self) -> str:
        """Name that tells it from the others, the same after a restart."""

    @property
    def attaches(self) -> bool:
        """Whether attachments go one by one after the report, by `attach`."""

    def file(self, report: Report, *, may_be_known: bool) -> str:
        """Hand in a report and return what the tracker calls it.

        Args:
            report: What happened.
            may_be_known: Whether an earlier attempt may have arrived though its answer did not.
        """

    def attach(self, reference: str, attachment: Attachment, *, may_be_known: bool) -> None:
        """Add a file to a report that was handed in, unless an earlier attempt did."""
