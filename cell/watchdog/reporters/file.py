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
                # Half a line, left by a crash or a full disk, must not swallow this one.
                file.write(("" if self._ends_whole() else "\n") + json.dumps(fields) + "\n")
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

    def _ends_whole(self) -> bool:
        with self._path.open("rb") as file:
            if file.seek(0, os.SEEK_END) == 0:
                return True
            file.seek(-1, os.SEEK_END)
            return file.read(1) == b"\n"

    def _has(self, alias: str) -> bool:
        if not self._path.exists():
            return False
        with self._path.open(encoding="utf-8", errors="replace") as file:
            return any(_alias_of(line) == alias for line in file)


def _alias_of(line: str) -> str:
    """Return the alias of a whole line; half a line has none."""
    try:
        fields = json.loads(line)
    except ValueError:
        return ""
    return str(fields.get("alias", "")) if isinstance(fields, dict) else ""
