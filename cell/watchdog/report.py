"""A report: one cause, told to whoever keeps track of faults."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass

from cell.errors import CellError, DeviceError
from cell.watchdog.evidence import Attachment

_FIGURES = re.compile(r"[-+]?\d+(?:\.\d+)?")


class ReportUndelivered(CellError):
    """A report did not reach its tracker.

    Attributes:
        is_final: Whether trying again cannot help until somebody changes the settings.
    """

    def __init__(self, problem: str, *, is_final: bool = False) -> None:
        self.is_final = is_final
        super().__init__(problem)


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What is told of one fault.

    Attributes:
        number: Number of the fault in this cell's history.
        alias: A name that is the same at every attempt, at most 40 characters, so that a
            tracker which got it already can be recognised.
        cell: Name of the cell.
        component: What failed.
        summary: One line.
        description: What happened, when, with which versions.
        attachments: Wire capture and pictures.
    """

    number: int
    alias: str
    cell: str
    component: str
    summary: str
    description: str
    attachments: tuple[Attachment, ...]


def cause_of(component: str, error: CellError) -> str:
    """Return what makes two failures the same fault: component, kind and words without figures.

    Positions and times differ from one failure to the next though the cause is the same; a
    device's own error number does not.
    """
    if isinstance(error, DeviceError):
        code = "" if error.code is None else str(error.code)
        words = f"{error.device}:{code}:{error.problem}"
    else:
        words = str(error)
    plain = _FIGURES.sub("#", words) if not _has_code(error) else _code_only(error)
    return f"{component}/{type(error).__name__}/{plain}"


def alias_of(cell: str, started: str, number: int) -> str:
    """Return the alias of a fault: cell, history and number, within 40 characters."""
    digest = hashlib.sha256(f"{cell}/{started}/{number}".encode()).hexdigest()[:12]
    stem = re.sub(r"[^a-z0-9]+", "-", cell.lower()).strip("-")[:16]
    return f"robocell-{stem}-{digest}"


def _has_code(error: CellError) -> bool:
    return isinstance(error, DeviceError) and error.code is not None


def _code_only(error: CellError) -> str:
    return f"{error.device}:{error.code}" if isinstance(error, DeviceError) else ""
