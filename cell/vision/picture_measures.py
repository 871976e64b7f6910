"""Measures of a picture for whoever sets a camera: histogram, patches, focus, flicker.

They judge nothing: what is too bright or too blurred is decided by who asks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

CLIPPED_LEVEL = 252
"""From here on a channel counts as clipped: noise keeps it from being always 255."""

_EDGE_PERCENTILE = 99.0
_FINE_SIGMA_PX = 0.8
_EDGE_MARGIN_PX = 5
_CHI_SQUARE_MEDIAN = 0.4549
"""Median of a squared normal number of variance 1."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Histogram:
    """How often each grey level occurs.

    Attributes:
        counts: Pixels by channel R G B and level, (3, 256).
    """

    counts: NDArray[np.int64]

    @property
    def clipped_share(self) -> tuple[float, float, float]:
        """Share of pixels at the upper end, by channel."""
        return self._shares(self.counts[:, CLIPPED_LEVEL:])

    @property
    def black_share(self) -> tuple[float, float, float]:
        """Share of pixels at level 0, by channel."""
        return self._shares(self.counts[:, :1])

    @property
    def means(self) -> tuple[float, float, float]:
        """Mean level, by channel."""
        red, green, blue = (self.counts @ np.arange(256)) / self.counts.sum(axis=1)
        return float(red), float(green), float(blue)

    def percentile(self, share: float) -> tuple[int, int, int]:
        """Return the level that a share of the pixels does not exceed, by channel."""
        reached = np.cumsum(self.counts, axis=1) >= share * self.counts.sum(axis=1)[:, None]
        red, green, blue = np.argmax(reached, axis=1)
        return int(red), int(green), int(blue)

    def _shares(self, part: NDArray[np.int64]) -> tuple[float, float, float]:
        red, green, blue = part.sum(axis=1) / self.counts.sum(axis=1)
        return float(red), float(green), float(blue)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Patches:
    """A picture in patches of one size.

    Attributes:
        means: Mean levels, (rows, columns, 3).
        deviations: Standard deviation of green inside each patch, (rows, columns): noise and
            whatever structure it shows.
        clipped: Share of pixels with a channel at the upper end, (rows, columns).
    """

    means: NDArray[np.float64]
    deviations: NDArray[np.float64]
    clipped: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Flicker:
    """How the light of a series of pictures swings.

    Attributes:
        swing_share: Half the distance from the darkest to the brightest, of the mean.
        noise_share: What of it the noise of the means accounts for.
        pictures: How many there were.
    """

    swing_share: float
    noise_share: float
    pictures: int


def histogram(pixels: Pixels) -> Histogram:
    """Return the histogram of a picture (h, w, 3)."""
    counts = [cv2.calcHist([pixels], [c], None, [256], [0, 256]).ravel() for c in range(3)]
    return Histogram(counts=np.rint(np.stack(counts)).astype(np.int64))


def patches(pixels: Pixels, columns: int = 32, rows: int = 24) -> Patches:
    """Return a picture (h, w, 3) cut into patches.

    Raises:
        ValueError: The picture's sides are no multiples of `columns` and `rows`.
    """
    height, width = pixels.shape[:2]
    if height % rows or width % columns:
        raise ValueError(f"{width} x {height} px cannot be cut into {columns} x {rows} patches")
    size = (columns, rows)
    planes = [np.asarray(plane, np.float32) for plane in cv2.split(pixels)]
    below = (CLIPPED_LEVEL - 1.0,) * 3
    inside = np.asarray(cv2.inRange(pixels, (0.0,) * 3, below), np.float32)

    def mean(plane: NDArray[np.float32]) -> NDArray[np.float64]:
        return np.asarray(cv2.resize(plane, size, interpolation=cv2.INTER_AREA), np.float64)

    means = np.stack([mean(plane) for plane in planes], axis=-1)
    variance = mean(planes[1] * planes[1]) - np.square(means[..., 1])
    return Patches(
        means=means,
        deviations=np.sqrt(np.maximum(variance, 0.0)),
        clipped=1.0 - mean(inside) / 255.0,
    )


def focus(pixels: Pixels) -> float:
    """Return how sharp the strongest edges of a picture are; it falls with blur.

    The energy of structures of about a pixel over that of structures twice as coarse, at
    the hundredth of the picture with the most structure, the noise taken off as the median
    of the picture tells it. It hardly depends on the light's level; pictures of other scenes
    differ by a few per cent.
    """
    plane = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY).astype(np.float32)
    first, second, third = (
        cv2.GaussianBlur(plane, (0, 0), _FINE_SIGMA_PX * factor) for factor in (1, 2, 4)
    )
    fine = np.square(np.asarray(first) - np.asarray(second))
    coarse = np.square(np.asarray(second) - np.asarray(third))
    margin = np.s_[_EDGE_MARGIN_PX:-_EDGE_MARGIN_PX, _EDGE_MARGIN_PX:-_EDGE_MARGIN_PX]
    fine, coarse = fine[margin], coarse[margin]
    at = coarse >= np.percentile(coarse, _EDGE_PERCENTILE)
    fine_energy, coarse_energy = (
        max(float(plane[at].mean()) - float(np.median(plane)) / _CHI_SQUARE_MEDIAN, 0.0)
        for plane in (fine, coarse)
    )
    return math.sqrt(fine_energy / max(coarse_energy, 1e-3))


def flicker(pictures: Sequence[Pixels]) -> Flicker:
    """Return how the light of pictures of one scene swings, taken one after the other.

    Raises:
        ValueError: There are fewer than three.
    """
    if len(pictures) < 3:
        raise ValueError(f"flicker needs at least 3 pictures, not {len(pictures)}")
    grids = [patches(picture) for picture in pictures]
    level = np.stack([grid.means[..., 1] for grid in grids])
    clipped = np.stack([grid.clipped for grid in grids]).max(axis=0)
    usable = (clipped < 0.001) & (level.min(axis=0) > 8.0)
    if not usable.any():
        return Flicker(swing_share=0.0, noise_share=math.inf, pictures=len(pictures))
    share = level[:, usable] / level[:, usable].mean(axis=0)
    means = np.median(share, axis=1)
    rest = share - means[:, None]
    noise = float(rest.std() / math.sqrt(usable.sum()))
    return Flicker(
        swing_share=float(np.ptp(means)) / 2.0, noise_share=2.0 * noise, pictures=len(pictures)
    )


_INK = ((214, 48, 49), (39, 140, 70), (38, 92, 200))
_PAPER, _LINE, _TEXT = 250, (205, 208, 212), (50, 54, 60)


def draw_histogram(pixels: Pixels, title: str = "") -> Pixels:
    """Return a picture (300, 580, 3) of a picture's histogram, for people.

    Heights are the roots of the counts, so that small things are seen beside large ones.
    """
    counts = histogram(pixels)
    canvas = np.full((300, 580, 3), _PAPER, np.uint8)
    left, top, tall = 34, 34, 220
    for level in range(0, 257, 64):
        x = left + 2 * level
        cv2.line(canvas, (x, top), (x, top + tall), _LINE, 1)
        _write(canvas, str(min(level, 255)), (x - 10, top + tall + 18))
    inner = np.sqrt(counts.counts / max(int(counts.counts[:, 1:CLIPPED_LEVEL].max()), 1))
    for channel, ink in enumerate(_INK):
        heights = np.minimum(inner[channel], 1.0) * (tall - 2)
        line = np.stack([left + 2 * np.arange(256), top + tall - heights], axis=1)
        cv2.polylines(canvas, [np.rint(line).astype(np.int32)], False, ink, 1, cv2.LINE_AA)
    clipped = " / ".join(f"{100 * share:.1f}" for share in counts.clipped_share)
    means = " / ".join(f"{mean:.0f}" for mean in counts.means)
    _write(canvas, f"{title}  mean {means}  clipped {clipped} %".strip(), (left, 22))
    return canvas


def side_by_side(parts: Sequence[tuple[str, Pixels]], width_px: int = 640) -> Pixels:
    """Return pictures beside each other, each under its title with its histogram below.

    Raises:
        ValueError: There are none.
    """
    if not parts:
        raise ValueError("no pictures to put beside each other")
    columns = []
    for title, pixels in parts:
        tall = round(pixels.shape[0] * width_px / pixels.shape[1])
        small = cv2.resize(pixels, (width_px, tall), interpolation=cv2.INTER_AREA)
        chart = draw_histogram(pixels, title)
        frame = np.full((chart.shape[0], width_px, 3), _PAPER, np.uint8)
        at = max((width_px - chart.shape[1]) // 2, 0)
        frame[:, at : at + chart.shape[1]] = chart[:, : width_px - at]
        columns.append(np.vstack([np.asarray(small, np.uint8), frame]))
    tallest = max(column.shape[0] for column in columns)
    padded = [
        np.pad(c, ((0, tallest - c.shape[0]), (0, 0), (0, 0)), constant_values=_PAPER)
        for c in columns
    ]
    return np.hstack(padded)


def _write(canvas: Pixels, text: str, place: tuple[int, int]) -> None:
    cv2.putText(canvas, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.4, _TEXT, 1, cv2.LINE_AA)
