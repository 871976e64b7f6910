"""What can go wrong while something is calibrated."""

from __future__ import annotations

from typing import Final


class CalibrationError(Exception):
    """Base class of this package's errors; the text says what, where and what to do."""


class FitFailed(CalibrationError):
    """The samples do not determine what is fitted."""


class AnswerRefused(CalibrationError):
    """An answer is missing or does not fit its question.

    Attributes:
        key: Key of the question.
    """

    def __init__(self, key: str, problem: str) -> None:
        self.key = key
        super().__init__(f"{key}: {problem}")


class ArchiveError(CalibrationError):
    """Kept calibrations cannot be read or written."""


class QualityNotMet(CalibrationError):
    """A calibration is missing or not as good as was demanded."""


class JournalError(CalibrationError):
    """The notes of a run cannot be read, written or gone on with."""


RESULTS: Final = (FitFailed, ArchiveError, QualityNotMet, JournalError)
"""What can go wrong although everything was asked for and answered rightly."""
