"""Posts faults as JSON to an address of the user's."""

from __future__ import annotations

from cell.profile import WebhookProfile
from cell.watchdog.evidence import Attachment
from cell.watchdog.report import Report, ReportUndelivered
from cell.watchdog.reporters.http import JsonClient
from cell.watchdog.stored import report_as_dict


class Webhook:
    """An address that takes a report, attachments included, in one request.

    The field `alias` is the same at every attempt, and so is the header `Idempotency-Key`:
    a receiver that got a report whose answer was lost recognises it by either.
    """

    def __init__(self, profile: WebhookProfile) -> None:
        self._profile = profile

    @property
    def name(self) -> str:
        """Name that tells it from other trackers."""
        return f"webhook {self._profile.url}"

    @property
    def attaches(self) -> bool:
        """Attachments are in the request."""
        return False

    def file(self, report: Report, *, may_be_known: bool) -> str:
        """Post a report.

        Raises:
            ReportUndelivered: The receiver is down or refuses.
        """
        headers = {"Idempotency-Key": report.alias}
        client = JsonClient(self.name, self._profile.timeout_s, headers)
        answer = client.post(self._profile.url, report_as_dict(report))
        if not 200 <= answer.status < 300:
            raise ReportUndelivered(
                f"{self.name} answered HTTP {answer.status}",
                is_final=400 <= answer.status < 500 and answer.status not in (408, 429),
            )
        return report.alias

    def attach(self, reference: str, attachment: Attachment, *, may_be_known: bool) -> None:
        """Nothing is attached later."""
