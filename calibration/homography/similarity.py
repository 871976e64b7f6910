"""The coarse truth about a camera that looks down: its map is nearly a similarity, mirrored.

Seen from above with rows counted downwards, the table comes out mirrored; tilt, perspective
and lens change that by some per cent. Four numbers are enough for it, so that among four
pairs there is evidence left over to say which is wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Similarity:
    """x + iy = factor · w + shift with w = u - iv, or w = u + iv if it is not mirrored.

    Attributes:
        factor: Scale in mm a pixel, and turn.
        shift: In mm.
        is_mirrored: Whether rows run the other way round, as seen from above.
    """

    factor: complex
    shift: complex
    is_mirrored: bool

    @property
    def scale(self) -> float:
        """Target units in a source unit, mm a pixel between picture and robot."""
        return abs(self.factor)

    @property
    def turn_deg(self) -> float:
        """Turn from source to target."""
        return float(np.degrees(np.angle(self.factor)))

    def __call__(self, source: Points) -> Points:
        """Return points (n, 2) taken through it."""
        moved = self.factor * _complex(source, self.is_mirrored) + self.shift
        return np.stack([moved.real, moved.imag], axis=-1)


def similarity(source: Points, target: Points, *, is_mirrored: bool) -> Similarity:
    """Return the similarity with least squared distances, from n ≥ 2 pairs."""
    w = _complex(source, is_mirrored)
    z = target[:, 0] + 1j * target[:, 1]
    w_middle, z_middle = w.mean(), z.mean()
    spread = float((np.abs(w - w_middle) ** 2).sum())
    across = ((w - w_middle).conj() * (z - z_middle)).sum()
    factor = complex(across / spread) if spread > 0 else 0j
    return Similarity(factor, complex(z_middle - factor * w_middle), is_mirrored)


def misfit(source: Points, target: Points, *, is_mirrored: bool) -> Points:
    """Return each pair's distance from the best similarity, shape (n,)."""
    return distances(similarity(source, target, is_mirrored=is_mirrored)(source), target)


def distances(first: Points, second: Points) -> Points:
    """Return the distances (n,) of points (n, 2)."""
    return np.asarray(np.hypot(*(first - second).T))


def _complex(points: Points, is_mirrored: bool) -> NDArray[np.complex128]:
    sign = -1j if is_mirrored else 1j
    return np.asarray(points[:, 0] + sign * points[:, 1])
