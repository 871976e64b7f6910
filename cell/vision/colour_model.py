"""What colours the blocks have, however bright the lamps are, and how sure one can be.

Twice the lamps double all three channels, so colours are compared by the logarithms of
channel ratios, (ln R/G, ln B/G), which do not change with the light's level; the third
coordinate, ln G less the logarithm of the light, does, and counts only as far as the light
is known. Each colour is a normal distribution in that space.

The default is built from the reference's table (Dubec 2011, table 5.3), whose ranges are
taken as two standard deviations to either side; `calibration` measures a better one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.vision.tables import COLOURS, ColourRange, Range

Rgb = tuple[float, float, float]
Matrix3 = tuple[Rgb, Rgb, Rgb]

_RANGE_SIGMAS = 4.0
_LEAST_LEVEL = 0.5
_CLIPPED_LEVEL = 250.0
_QUANTISATION_VARIANCE = 1.0 / 12.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourSample:
    """The colour of a face in a picture.

    Attributes:
        mean_rgb: Means of the channels, grey levels.
        deviation_rgb: Standard deviations of the channels over the face.
        pixels: How many pixels were looked at.
        clipped_share: Share of pixels with a channel at the end of its range.
    """

    mean_rgb: Rgb
    deviation_rgb: Rgb
    pixels: int
    clipped_share: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourClass:
    """One colour.

    Attributes:
        colour: Its name.
        mean: Of (ln R/G, ln B/G, ln G - ln light).
        covariance: Of the same, (3, 3).
    """

    colour: str
    mean: Rgb
    covariance: Matrix3


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourGuess:
    """What colour a sample has.

    Attributes:
        colour: The likeliest; None when it is too far from every colour, or between two.
        probability: That the likeliest is right, among the colours known.
        nearest: The likeliest, whether or not it was accepted; empty without classes.
        distance: Mahalanobis distance to it.
        margin: Half the difference of -2 ln likelihood to the next colour: how many
            standard deviations' worth of evidence speak for the nearest.
        reason: Why `colour` is None, or an empty string.
    """

    colour: str | None
    probability: float
    nearest: str
    distance: float
    margin: float
    reason: str = ""


@dataclass(frozen=True, kw_only=True)
class ColourModel:
    """The colours of the blocks.

    Attributes:
        classes: The colours.
        most_distance: Samples farther than this many standard deviations have no colour.
        least_probability: Samples whose colour is less sure than this have none.
        light_spread: Standard deviation of ln light, when the light is not known: 0.18
            is that of lamps anywhere from 30 % dimmer to 30 % brighter.
        origin: Where the figures come from, for people.
    """

    classes: tuple[ColourClass, ...]
    most_distance: float = 3.5
    least_probability: float = 0.95
    light_spread: float = 0.18
    origin: str = field(default="", compare=False)

    @property
    def colours(self) -> tuple[str, ...]:
        """Names of the colours."""
        return tuple(one.colour for one in self.classes)

    def classify(self, rgb: Rgb, *, light: float | None = None, noise: float = 0.0) -> ColourGuess:
        """Return the colour of channel means.

        Args:
            rgb: Grey levels of a matt face that looks up.
            light: Level of the lamps, 1 for that of the model; None when it is not known.
            noise: Standard deviation of the means beyond what the classes hold, grey levels.
        """
        return self.classify_all(np.array([rgb]), light=light, noise=noise)[0]

    def classify_all(
        self, rgb: NDArray[np.floating], *, light: float | None = None, noise: float = 0.0
    ) -> list[ColourGuess]:
        """Return the colours of channel means (n, 3); see `classify`."""
        distances, costs = self.costs(rgb, light=light, noise=noise)
        order = np.argsort(costs, axis=1)
        ordered = np.take_along_axis(costs, order, axis=1)
        weights = np.exp(-0.5 * (ordered - ordered[:, :1]))
        nearest = np.take_along_axis(distances, order[:, :1], axis=1)[:, 0]
        margins = (
            0.5 * (ordered[:, 1] - ordered[:, 0])
            if ordered.shape[1] > 1
            else np.full(len(ordered), math.inf)
        )
        columns = (
            order[:, :2].tolist(),
            (1.0 / weights.sum(axis=1)).tolist(),
            nearest.tolist(),
            margins.tolist(),
        )
        return [self._guess(*row) for row in zip(*columns, strict=True)]

    def _guess(
        self, order: Sequence[int], probability: float, distance: float, margin: float
    ) -> ColourGuess:
        nearest = self.classes[order[0]].colour
        reason = ""
        if distance > self.most_distance:
            reason = f"no known colour: nearest is {nearest}, {distance:.1f} deviations away"
        elif probability < self.least_probability:
            reason = f"colour between {nearest} and {self.classes[order[1]].colour}"
        return ColourGuess(
            colour=None if reason else nearest,
            probability=probability,
            nearest=nearest,
            distance=distance,
            margin=margin,
            reason=reason,
        )

    def costs(
        self, rgb: NDArray[np.floating], *, light: float | None = None, noise: float = 0.0
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return Mahalanobis distances and -2 ln likelihoods, (n, classes), of channels (n, 3)."""
        features = normalised(np.asarray(rgb, np.float64))
        features[:, 2] -= 0.0 if light is None else math.log(light)
        spread = self.light_spread**2 if light is None else 0.0
        levels = np.maximum(np.asarray(rgb, np.float64), _LEAST_LEVEL)
        means = np.array([one.mean for one in self.classes])
        own = np.array([one.covariance for one in self.classes])
        own[:, 2, 2] += spread
        joint = own[None] + _noise_covariance(levels, noise)[:, None]
        offset = features[:, None] - means
        solved = np.linalg.solve(joint, offset[..., None])[..., 0]
        squared = (offset * solved).sum(axis=-1)
        return np.sqrt(squared), squared + np.linalg.slogdet(joint)[1]

    def light_of(self, rgb: Rgb, colour: str) -> float:
        """Return the level of the lamps that a face of this colour tells, 1 for the model's.

        Raises:
            KeyError: The model has no such colour.
        """
        return float(self.lights_of(np.array([rgb]), [colour])[0])

    def lights_of(self, rgb: NDArray[np.floating], colours: Sequence[str]) -> NDArray[np.float64]:
        """Return the levels of the lamps, (n,), that faces (n, 3) of known colours tell.

        Raises:
            KeyError: The model has no such colour.
        """
        by_name = {one.colour: one.mean[2] for one in self.classes}
        own = np.array([by_name[colour] for colour in colours])
        return np.asarray(np.exp(normalised(np.asarray(rgb, np.float64))[:, 2] - own))

    def margin(self, first: str, second: str) -> float:
        """Return how far two colours lie apart: Bhattacharyya distance of their chroma.

        exp(-margin) / 2 bounds the share that is taken for the other; 2 and more is safe.

        Raises:
            KeyError: The model has no such colour.
        """
        by_name = {one.colour: one for one in self.classes}
        a, b = by_name[first], by_name[second]
        cov_a, cov_b = np.array(a.covariance)[:2, :2], np.array(b.covariance)[:2, :2]
        middle = (cov_a + cov_b) / 2.0
        apart = np.array(a.mean[:2]) - np.array(b.mean[:2])
        shape = np.linalg.slogdet(middle)[1] - 0.5 * (
            np.linalg.slogdet(cov_a)[1] + np.linalg.slogdet(cov_b)[1]
        )
        return float(apart @ np.linalg.solve(middle, apart) / 8.0 + 0.5 * shape)

    @cached_property
    def label_table(self) -> NDArray[np.uint8]:
        """Class by colour of a pixel: index `label_index` of R G B, number + 1, 0 for none."""
        side = 1 << _LABEL_BITS
        middle = (np.arange(side) + 0.5) * (256 / side) - 0.5
        rgb = np.stack(np.meshgrid(middle, middle, middle, indexing="ij"), axis=-1).reshape(-1, 3)
        distances, costs = self.costs(rgb, noise=256 / side / math.sqrt(12.0) + 1.0)
        best = np.argmin(costs, axis=1)
        is_near = distances[np.arange(len(rgb)), best] <= self.most_distance
        # Where every channel is at its end, the colour is lost.
        is_near &= rgb.min(axis=1) < _CLIPPED_LEVEL - 256 / side
        table = np.where(is_near, best + 1, 0).astype(np.uint8)
        table.setflags(write=False)
        return table


_LABEL_BITS = 5


def label_index(picture: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Return the index of each pixel into `ColourModel.label_table`, shape (h, w)."""
    red, green, blue = (channel.astype(np.uint16) for channel in cv2.split(picture >> 3))
    red <<= 2 * _LABEL_BITS
    green <<= _LABEL_BITS
    red |= green
    red |= blue
    return red


def normalised(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (ln R/G, ln B/G, ln G), (n, 3), of channels (n, 3) in grey levels."""
    logs = np.log(np.maximum(rgb, _LEAST_LEVEL))
    return np.stack([logs[:, 0] - logs[:, 1], logs[:, 2] - logs[:, 1], logs[:, 1]], axis=1)


def measure_colour(picture: NDArray[np.uint8], mask: NDArray[np.uint8]) -> ColourSample:
    """Return the colour of the pixels under a mask.

    Args:
        picture: R G B, (h, w, 3), uint8.
        mask: Above 0 where to look, (h, w), uint8; leave out the face's edge.

    Raises:
        ValueError: The mask has no pixel.
    """
    pixels = picture[mask > 0]
    if len(pixels) == 0:
        raise ValueError("no pixel to measure a colour in")
    means, deviations = pixels.mean(axis=0), pixels.std(axis=0)
    return ColourSample(
        mean_rgb=(float(means[0]), float(means[1]), float(means[2])),
        deviation_rgb=(float(deviations[0]), float(deviations[1]), float(deviations[2])),
        pixels=len(pixels),
        clipped_share=float((pixels >= _CLIPPED_LEVEL).any(axis=1).mean()),
    )


def measure_face(
    picture: NDArray[np.uint8], outline_px: NDArray[np.float64], *, edge_px: float = 4.0
) -> ColourSample:
    """Return the colour inside an outline (n, 2), its edge left out.

    Raises:
        ValueError: Nothing of it is in the picture.
    """
    middle = outline_px.mean(axis=0)
    reach = np.linalg.norm(outline_px - middle, axis=1, keepdims=True)
    shrunk = middle + (outline_px - middle) * np.maximum(1.0 - edge_px / reach, 0.1)
    mask = np.zeros(picture.shape[:2], np.uint8)
    cv2.fillPoly(mask, [np.rint(shrunk * 16).astype(np.int32)], 255, cv2.LINE_8, 4)
    return measure_colour(picture, mask)


@lru_cache(maxsize=1)
def reference_colours() -> ColourModel:
    """Return the model of the reference's table of colours."""
    return model_of_ranges(COLOURS)


def model_of_ranges(ranges: Sequence[ColourRange]) -> ColourModel:
    """Return the model of ranges of channels, each range two deviations to either side."""
    return ColourModel(
        classes=tuple(_class_of_range(one) for one in ranges),
        origin="Dubec 2011, table 5.3",
    )


def _class_of_range(one: ColourRange) -> ColourClass:
    def middle(span: Range) -> float:
        return math.log((span.low + span.high) / 2.0)

    def variance(span: Range) -> float:
        return (math.log(span.high / span.low) / _RANGE_SIGMAS) ** 2

    red, green, blue = middle(one.red), middle(one.green), middle(one.blue)
    of_red, of_green, of_blue = variance(one.red), variance(one.green), variance(one.blue)
    return ColourClass(
        colour=one.colour,
        mean=(red - green, blue - green, green),
        covariance=(
            (of_red + of_green, of_green, -of_green),
            (of_green, of_blue + of_green, -of_green),
            (-of_green, -of_green, of_green),
        ),
    )


def _noise_covariance(levels: NDArray[np.float64], noise: float) -> NDArray[np.float64]:
    """Return what noise of the channels does to the normalised colour, (n, 3, 3)."""
    share = (noise * noise + _QUANTISATION_VARIANCE) / np.square(levels)
    red, green, blue = share.T
    rows = np.empty((len(levels), 3, 3))
    rows[:, 0] = np.stack([red + green, green, -green], axis=1)
    rows[:, 1] = np.stack([green, blue + green, -green], axis=1)
    rows[:, 2] = np.stack([-green, -green, green], axis=1)
    return rows
