"""Keeps how far a bring-up came, so that it goes on where it was interrupted."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from datetime import datetime, timedelta
from pathlib import Path

from pydantic import TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from cell.bringup.play import BringUpReport, Outcome, StepResult
from cell.errors import CellError

GOOD_FOR = timedelta(hours=12)
"""What a person told in the morning holds for the day."""


@dataclass(frozen=True, kw_only=True)
class _KeptStep:
    step: str
    outcome: Outcome
    reason: str = ""


@dataclass(frozen=True, kw_only=True)
class _Kept:
    written: datetime
    steps: tuple[_KeptStep, ...]


_ADAPTER: TypeAdapter[_Kept] = TypeAdapter(_Kept)


class ProgressFile:
    """The file of one cell's bring-up."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def load(self, now: datetime) -> Mapping[str, StepResult]:
        """Return what was told and skipped within the last hours; nothing if that is old.

        A file that cannot be read counts as none: everything is then asked anew.
        """
        try:
            kept = _ADAPTER.validate_json(self._path.read_bytes())
            is_fresh = timedelta(0) <= now - kept.written <= GOOD_FOR
        except (OSError, ValidationError, TypeError):
            return {}
        if not is_fresh:
            return {}
        return {
            one.step: StepResult(step=one.step, outcome=one.outcome, reason=one.reason)
            for one in kept.steps
        }

    def save(self, report: BringUpReport, now: datetime) -> None:
        """Write how far a bring-up came; the file is the old one or the new one, never a part.

        Raises:
            CellError: It cannot be written.
        """
        steps = [
            {"step": one.step, "outcome": one.outcome, "reason": one.reason}
            for one in report.results
        ]
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            fresh = self._path.with_suffix(".new")
            fresh.write_text(json.dumps({"written": now.isoformat(), "steps": steps}), "utf-8")
            os.replace(fresh, self._path)
        except OSError as error:
            raise CellError(
                f"how far the bring-up came cannot be kept in {self._path}: {error}"
            ) from error

    def clear(self) -> None:
        """Forget an earlier run."""
        self._path.unlink(missing_ok=True)
