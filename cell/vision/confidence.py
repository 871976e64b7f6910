"""How sure a face is a block of its kind: a logistic curve of how well it fits its edges.

The coefficients were fitted to layouts of the twin (`benchmarks/recognition_layouts.py`);
the tests compare stated confidence with the share that was right.
"""

from __future__ import annotations

import math

from cell.vision.face_fit import FittedFace

_BASE = -9.0
_PER_SUPPORT = 9.0
_PER_UNIFORM = 9.0
_PER_RESIDUAL_MM = -4.0
_GROUP = 1.5


def confidence_of(face: FittedFace, *, is_group: bool) -> float:
    """Return the probability that a fitted face is that of a block of its kind.

    Args:
        face: The face after its fit.
        is_group: Whether it touches another of its colour, where fewer sides can be seen.
    """
    score = (
        _BASE
        + _PER_SUPPORT * face.support
        + _PER_UNIFORM * face.uniform
        + _PER_RESIDUAL_MM * face.residual_mm
        + (_GROUP if is_group else 0.0)
    )
    return 1.0 / (1.0 + math.exp(-score))
