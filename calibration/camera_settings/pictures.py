"""Pictures for people: how it was and how it is, each with its histogram."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from calibration.errors import CalibrationError
from calibration.record import Measurement
from cell.vision.picture_measures import side_by_side

Pixels = NDArray[np.uint8]


def before_and_after(measurement: Measurement, read: Callable[[str], Pixels]) -> Pixels:
    """Return the kept pictures of a camera's settings beside each other.

    Args:
        measurement: Of the kind `camera-settings`.
        read: Returns the kept picture (height, width, 3) of a digest.

    Raises:
        CalibrationError: No picture was kept with it.
    """
    kept = [(s.label, s.picture) for s in measurement.samples if s.picture]
    if not kept:
        raise CalibrationError(
            f"no picture is kept with {measurement.kind} of {measurement.subject}"
        )
    return side_by_side([(label, read(digest)) for label, digest in kept])
