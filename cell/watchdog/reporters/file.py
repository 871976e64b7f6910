"""Writes faults into a file, one JSON object a line."""

from __future__ import annotations

import json
import os
from pathlib import Path

from cell.watchdog.evidence import Attachment
from cell.watchdog.report import Report, ReportUndelivered
from cell.watchdog.stored import report_as_dict


class ReportFile:
    """A file that grows by a line for each fault; attachments lie in a folder beside it."""

    def __init__(self, path: Path) -> None:
        self._path = path

    @property
    def name(self) -> str:
        """Name that tells it from other trackers."""
        return f"file {self._path}"

    @property
    def attaches(self) -> bool:
        """Attachments are files of their own."""
        return True

    def file(self, report: Report, *, may_be_known: bool) -> str:
        """Append a report, unless an earlier attempt did.

        Raises:
            ReportUndelivered: The file cannot be written.
        """
        try:
            if may_be_known and self._has(report.alias):
                return report.alias
            fields = {**report_as_dict(report), "attachments": [a.name for a in report.attachments]}
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(fields) + "\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise ReportUndelivered(f"{self.name} cannot be written: {error.strerror}") from error
        return report.alias

    def attach(self, reference: str, attachment: Attachment, *, may_be_known: bool) -> None:
        """Write an attachment into the report's folder.

        Raises:
            ReportUndelivered: It cannot be written.
        """
        folder = self._path.parent / f"{self._path.stem}-files" / reference
        try:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / attachment.name.replace("/", "-")).write_bytes(attachment.data)
        except OSError as error:
            raise ReportUndelivered(f"{folder} cannot be written: {error.strerror}") from error

    def _has(self, alias: str) -> bool:
        if not self._path.exists():
            return False
        wanted = json.dumps(alias)
        with self._path.open(encoding="utf-8", errors="replace") as file:
            return any(f'"alias": {wanted}' in line for line in file)
