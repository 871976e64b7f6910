"""How sure a face is a block of its kind: a logistic curve of how well it fits its edges.

The coefficients are a logistic regression on layouts of the twin made hard by noise, blur and
strips across the blocks (`python -m benchmarks.recognition_confidence`), which also tells how
far stated and true shares are apart on layouts that the fit did not see.
"""

from __future__ import annotations

import math

from cell.vision.face_fit import FittedFace

_BASE = -24.85
_COEFFICIENTS = (9.18, 4.92, 16.20, -1.47, -1.90)
_MOST_SCORE = 30.0


def features_of(face: FittedFace, *, is_group: bool) -> tuple[float, ...]:
    """Return what the confidence depends on: supports, uniformity, residual in mm, grouping."""
    return (
        face.support,
        face.open_support,
        face.uniform,
        face.residual_mm,
        1.0 if is_group else 0.0,
    )


def confidence_of(face: FittedFace, *, is_group: bool) -> float:
    """Return the probability that a fitted face is that of a block of its kind.

    Args:
        face: The face after its fit.
        is_group: Whether it touches another of its colour, where fewer sides can be seen.
    """
    features = features_of(face, is_group=is_group)
    score = _BASE + sum(a * b for a, b in zip(_COEFFICIENTS, features, strict=True))
    return 1.0 / (1.0 + math.exp(-max(-_MOST_SCORE, min(_MOST_SCORE, score))))
