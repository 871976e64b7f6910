"""A picture of a record's samples for people: where each was found, and how far the fit is off.

Residuals in px are drawn on the picture that most samples come from, longer than they are by
a stated factor; red ones were not fitted on.
"""

from __future__ import annotations

from collections import Counter
from typing import Final

import cv2
import numpy as np

from calibration.archive import Archive
from calibration.errors import ArchiveError, CalibrationError
from calibration.pictures import Pixels, decode_png
from calibration.record import CalibrationRecord, Sample

_SIZE_PX: Final = (1280, 960)
_LONGEST_PX: Final = 60.0
_FACTORS: Final = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
_GREEN, _RED, _WHITE, _DARK = (64, 220, 64), (240, 64, 64), (255, 255, 255), (24, 24, 24)
_FONT: Final = cv2.FONT_HERSHEY_SIMPLEX


def overview_of(record: CalibrationRecord, archive: Archive) -> Pixels:
    """Return a picture (height, width, 3), R G B, of a record's samples.

    Args:
        record: The record.
        archive: Where its pictures are.

    Raises:
        CalibrationError: None of its samples has a place in a picture.
    """
    found = [sample for sample in record.samples if len(sample.measured) == 2]
    if not found:
        raise CalibrationError(
            f"the samples of {record.identity[:8]} have no places in a picture; "
            "`cell calibration show` lists them"
        )
    canvas = _background(found, archive)
    factor = _factor(found)
    for sample in found:
        _draw(canvas, sample, factor)
    text = f"{record.kind} of {record.subject}, {record.identity[:8]}: residuals x {factor}"
    cv2.rectangle(canvas, (0, 0), (12 * len(text) + 16, 30), _DARK, -1)
    cv2.putText(canvas, text, (8, 21), _FONT, 0.6, _WHITE, 1, cv2.LINE_AA)
    return canvas


def _background(samples: list[Sample], archive: Archive) -> Pixels:
    """Return the picture that most samples were found in, darkened; grey without one."""
    counted = Counter(sample.picture for sample in samples if sample.picture)
    for digest, _ in counted.most_common():
        try:
            pixels = decode_png(archive.picture(digest), digest)
        except ArchiveError:
            continue
        return np.asarray(pixels // 2, np.uint8)
    return np.full((_SIZE_PX[1], _SIZE_PX[0], 3), _DARK, np.uint8)


def _factor(samples: list[Sample]) -> int:
    lengths = [float(np.hypot(*s.residual)) for s in samples if len(s.residual) == 2]
    longest = max(lengths, default=0.0)
    fitting = [one for one in _FACTORS if one * longest <= _LONGEST_PX]
    return fitting[-1] if fitting else 1


def _draw(canvas: Pixels, sample: Sample, factor: int) -> None:
    colour = _GREEN if sample.is_used else _RED
    u, v = sample.measured
    at = (round(u), round(v))
    cv2.circle(canvas, at, 5, colour, 1, cv2.LINE_AA)
    if len(sample.residual) == 2:
        tip = (round(u + factor * sample.residual[0]), round(v + factor * sample.residual[1]))
        cv2.line(canvas, at, tip, _WHITE, 1, cv2.LINE_AA)
    cv2.putText(canvas, sample.label, (at[0] + 8, at[1] - 6), _FONT, 0.4, colour, 1, cv2.LINE_AA)
