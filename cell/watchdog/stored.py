"""A report as bytes, for the time it waits on disk."""

from __future__ import annotations

import base64
import json

from cell.errors import CellError
from cell.watchdog.evidence import Attachment
from cell.watchdog.report import Report


class UnreadableReport(CellError):
    """A report that waits on disk cannot be read."""


def write_report(report: Report) -> bytes:
    """Return a report as JSON; attachments are in base64."""
    return json.dumps(report_as_dict(report)).encode()


def report_as_dict(report: Report) -> dict[str, object]:
    """Return a report's fields as JSON knows them."""
    return {
        "number": report.number,
        "alias": report.alias,
        "cell": report.cell,
        "component": report.component,
        "summary": report.summary,
        "description": report.description,
        "attachments": [
            {"name": a.name, "mime": a.mime, "data": base64.b64encode(a.data).decode()}
            for a in report.attachments
        ],
    }


def read_report(stored: bytes) -> Report:
    """Read a report back.

    Raises:
        UnreadableReport: The bytes are none.
    """
    try:
        fields = json.loads(stored)
        return Report(
            number=fields["number"],
            alias=fields["alias"],
            cell=fields["cell"],
            component=fields["component"],
            summary=fields["summary"],
            description=fields["description"],
            attachments=tuple(
                Attachment(a["name"], a["mime"], base64.b64decode(a["data"]))
                for a in fields["attachments"]
            ),
        )
    except (ValueError, KeyError, TypeError) as error:
        raise UnreadableReport(
            f"the report that waits on disk cannot be read ({error!r})"
        ) from error
