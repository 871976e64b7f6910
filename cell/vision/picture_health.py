"""Is a picture fit to be looked at: dark, blown out, out of focus, moved, of another camera?

Pictures are judged against references taken when all was well. A reference is made of at
least two pictures between which everything changed that may change (screen black and white);
what stayed the same in them, the *still* part, is what later pictures are compared in. A
camera on the arm has a reference for one pose only: judge it there, or without a reference.

The measures:

- brightness: the 95th percentile of grey in the still part, and the share that is clipped;
- sharpness: at the reference's finest edges, how strong structures are beside those twice
  as coarse (differences of Gaussians at 640 columns), which lighting does not change;
- fit and shift: masked correlation of gradients with the reference over shifts of up to 64
  of 1280 columns. Plain phase correlation has no mask, and loses the shift as soon as the
  screen or the arm fills the picture; here only the still part counts.

Frames that repeat are found by `cell.vision.frame_watch`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.errors import VisionError

Pixels = NDArray[np.uint8]
Grey8 = NDArray[np.uint8]
Grey = NDArray[np.float32]

PictureFault = Literal["dark", "overexposed", "out of focus", "moved", "swapped"]

WORK_WIDTH_PX = 640
"""Width at which pictures are measured: every mode of the cameras has at least as many."""

FULL_WIDTH_PX = 1280
"""Width that shifts are told at."""

_FIT_WIDTH_PX = 320
_FIT_REACH_PX = 16
_GRADIENT_CAP = 60.0
_STILL_LEVELS = 12.0
_STILL_MARGIN_PX = 5
_LEAST_STILL_SHARE = 0.02
_EDGE_MARGIN_PX = 7
_EDGE_PERCENTILE = 99.0
_FINE_SIGMA_PX = 0.8
_CLIPPED_LEVEL = 250


@dataclass(frozen=True, slots=True, kw_only=True)
class HealthLimits:
    """Where a measure becomes a finding; `docs/reference/cameras.md` says why there.

    Attributes:
        least_bright_level: 95th percentile of grey below which a picture is dark.
        most_clipped_share: Share of clipped pixels of the still part above which it is
            overexposed.
        most_clipped_share_anywhere: The same of the whole picture, for want of a reference.
        least_sharpness_ratio: Sharpness over the reference's, below which it is blurred.
        most_shift_px: Shift at 1280 columns above which the camera has moved.
        least_shift_gain: By how much the shift must fit better than none to be believed.
        least_fit: Correlation from which a picture is taken to show a reference's scene.
        fit_margin: By how much another camera's reference must fit better.
    """

    least_bright_level: float = 30.0
    most_clipped_share: float = 0.05
    most_clipped_share_anywhere: float = 0.9
    least_sharpness_ratio: float = 0.8
    most_shift_px: float = 3.0
    least_shift_gain: float = 0.03
    least_fit: float = 0.3
    fit_margin: float = 0.15


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PictureReference:
    """What a healthy picture of a camera looks like.

    Attributes:
        camera: Name of the camera in the profile.
        still: Where nothing changes, at 640 columns, (rows, columns), bool.
        edges: The finest edges in it, likewise.
        sharpness: Sharpness of the pictures it was made of.
        gradient: Gradient magnitude at 320 columns.
        weight: The still part at 320 columns, 0 or 1.
    """

    camera: str
    still: NDArray[np.bool_]
    edges: NDArray[np.bool_]
    sharpness: float
    gradient: Grey
    weight: Grey


@dataclass(frozen=True, slots=True, kw_only=True)
class Shift:
    """How far a picture's content lies from where it was.

    Attributes:
        dx_px: To the right, at 1280 columns.
        dy_px: Down, at 1280 columns.
        fit: Correlation with the reference there: 1 the same scene, 0 anything else.
        fit_unmoved: Correlation without a shift.
    """

    dx_px: float
    dy_px: float
    fit: float
    fit_unmoved: float

    @property
    def distance_px(self) -> float:
        """Length of the shift."""
        return float(np.hypot(self.dx_px, self.dy_px))


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureFinding:
    """One thing wrong with a picture.

    Attributes:
        fault: What.
        camera: Name of the camera.
        measured: The measure.
        limit: What it should not cross.
        unit: Unit of both.
        text: A sentence for a technician.
        other: The camera whose scene it shows, for `swapped`; else empty.
    """

    fault: PictureFault
    camera: str
    measured: float
    limit: float
    unit: str
    text: str
    other: str = ""


def make_reference(camera: str, pictures: Sequence[Pixels]) -> PictureReference:
    """Return a reference made of healthy pictures of one size (height, width, 3).

    Raises:
        VisionError: There are none, their sizes differ, or nothing in them stays the same.
    """
    if not pictures or any(p.shape != pictures[0].shape for p in pictures):
        raise VisionError(f"a reference of camera {camera} needs pictures of one size")
    greys = [_grey(picture) for picture in pictures]
    stack = np.stack([cv2.GaussianBlur(grey, (0, 0), 1.5) for grey in greys])
    changes = (np.ptp(stack, axis=0) > _STILL_LEVELS).astype(np.uint8)
    still = _grown(changes, _STILL_MARGIN_PX) == 0
    if still.mean() < _LEAST_STILL_SHARE:
        raise VisionError(
            f"the pictures of camera {camera} have nothing in common; "
            "take them from one place, one after the other"
        )
    fine, _ = _structures(greys[0])
    inside = _grown(changes, _STILL_MARGIN_PX + _EDGE_MARGIN_PX) == 0
    edges = inside & (fine >= np.percentile(fine[inside], _EDGE_PERCENTILE))
    edges = _grown(edges.astype(np.uint8), 1) > 0
    return PictureReference(
        camera=camera,
        still=still,
        edges=edges,
        sharpness=min(_sharpness(grey, edges) for grey in greys),
        gradient=_gradient(greys[0]),
        weight=np.floor(_shrink(still.astype(np.float32))),
    )


def judge_picture(
    camera: str,
    pixels: Pixels,
    references: Mapping[str, PictureReference] | None = None,
    limits: HealthLimits | None = None,
) -> tuple[PictureFinding, ...]:
    """Return what is wrong with a picture (height, width, 3); nothing if it is healthy.

    A picture without light, or of another place, hides what comes after
    it, so only the first such finding is told. One that has moved may show the bright screen
    where all was still, so it is not called overexposed. It may be blurred and moved.

    Args:
        camera: The camera that it should be of.
        pixels: R G B.
        references: Of as many cameras as there are, by name.
        limits: The thresholds.
    """
    limits = limits or HealthLimits()
    references = references or {}
    grey = _grey(pixels)
    own = references.get(camera)
    still = None if own is None or own.still.shape != grey.shape else own.still
    dark, overexposed = _judge_light(camera, grey, still, limits)
    if dark:
        return dark
    gradient = _gradient(grey)
    shifts = {name: _shift(gradient, reference) for name, reference in references.items()}
    swapped = _judge_place(camera, {name: shift.fit for name, shift in shifts.items()}, limits)
    if swapped:
        return swapped
    if own is None or still is None:
        return overexposed
    moved = _judge_shift(camera, shifts[camera], limits)
    if overexposed and not moved:
        return overexposed
    return _judge_focus(camera, grey, own, shifts[camera], limits) + moved


def sharpness_at(pixels: Pixels, reference: PictureReference) -> float:
    """Return the sharpness of a picture at a reference's edges; it falls with blur."""
    return _sharpness(_grey(pixels), reference.edges)


def shift_from(pixels: Pixels, reference: PictureReference) -> Shift:
    """Return how far a picture's content has moved since the reference."""
    return _shift(_gradient(_grey(pixels)), reference)


def _judge_light(
    camera: str, grey: Grey8, still: NDArray[np.bool_] | None, limits: HealthLimits
) -> tuple[tuple[PictureFinding, ...], tuple[PictureFinding, ...]]:
    """Return whether a picture is dark, and whether it is overexposed."""
    mask = None if still is None else still.astype(np.uint8)
    counts = cv2.calcHist([grey], [0], mask, [256], [0, 256]).ravel()
    shares = np.cumsum(counts) / counts.sum()
    bright = float(np.searchsorted(shares, 0.95))
    if bright < limits.least_bright_level:
        text = (
            f"the picture is dark: 95 % of it is below level {bright:.0f} of 255; "
            "take the cap off, switch the lights on, compare shutter and gain with the profile"
        )
        return (_finding("dark", camera, bright, limits.least_bright_level, "levels", text),), ()
    clipped = float(1.0 - shares[_CLIPPED_LEVEL - 1])
    limit = limits.most_clipped_share if still is not None else limits.most_clipped_share_anywhere
    if clipped <= limit:
        return (), ()
    text = (
        f"the picture is overexposed: {100 * clipped:.0f} % of it is clipped; "
        "compare shutter, gain and the automatic modes with the profile"
    )
    return (), (_finding("overexposed", camera, clipped, limit, "share", text),)


def _judge_place(
    camera: str, fits: Mapping[str, float], limits: HealthLimits
) -> tuple[PictureFinding, ...]:
    others = {name: fit for name, fit in fits.items() if name != camera}
    if not others or camera not in fits:
        return ()
    best = max(others, key=lambda name: others[name])
    is_other = others[best] >= limits.least_fit and (
        others[best] >= fits[camera] + limits.fit_margin
    )
    if not is_other:
        return ()
    text = (
        f"the picture shows what camera {best} should show (fit {others[best]:.2f}, "
        f"its own {fits[camera]:.2f}); two cameras have changed places"
    )
    limit = fits[camera] + limits.fit_margin
    finding = _finding("swapped", camera, others[best], limit, "fit", text, other=best)
    return (finding,)


def _judge_focus(
    camera: str, grey: Grey8, own: PictureReference, shift: Shift, limits: HealthLimits
) -> tuple[PictureFinding, ...]:
    scale = WORK_WIDTH_PX / FULL_WIDTH_PX
    moved = (round(shift.dy_px * scale), round(shift.dx_px * scale))
    ratio = _sharpness(grey, np.roll(own.edges, moved, axis=(0, 1))) / own.sharpness
    if ratio >= limits.least_sharpness_ratio:
        return ()
    text = (
        f"the picture is out of focus: {100 * ratio:.0f} % as sharp as the reference; "
        "turn the focus ring back and clean the lens"
    )
    limit = limits.least_sharpness_ratio
    return (_finding("out of focus", camera, ratio, limit, "of the reference", text),)


def _judge_shift(camera: str, shift: Shift, limits: HealthLimits) -> tuple[PictureFinding, ...]:
    is_moved = (
        shift.distance_px > limits.most_shift_px
        and shift.fit >= limits.least_fit
        and shift.fit - shift.fit_unmoved >= limits.least_shift_gain
    )
    if not is_moved:
        return ()
    text = (
        f"the camera has moved: the picture lies ({shift.dx_px:+.1f}, {shift.dy_px:+.1f}) px "
        "from the reference; put the camera back or calibrate it anew"
    )
    return (_finding("moved", camera, shift.distance_px, limits.most_shift_px, "px", text),)


def _finding(
    fault: PictureFault,
    camera: str,
    measured: float,
    limit: float,
    unit: str,
    text: str,
    other: str = "",
) -> PictureFinding:
    return PictureFinding(
        fault=fault,
        camera=camera,
        measured=measured,
        limit=limit,
        unit=unit,
        text=text,
        other=other,
    )


def _grey(pixels: Pixels) -> Grey8:
    height, width = pixels.shape[:2]
    if width != WORK_WIDTH_PX:
        size = (WORK_WIDTH_PX, round(height * WORK_WIDTH_PX / width))
        pixels = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), np.uint8)


def _grown(mask: NDArray[np.uint8], margin_px: int) -> NDArray[np.uint8]:
    side = 2 * margin_px + 1
    return np.asarray(cv2.dilate(mask, np.ones((side, side), np.uint8)), np.uint8)


def _gradient(grey: Grey8) -> Grey:
    """Return the gradient's magnitude at 320 columns, capped so that no single edge rules."""
    soft = cv2.GaussianBlur(_shrink(grey.astype(np.float32)), (0, 0), 0.8)
    across = cv2.Sobel(soft, cv2.CV_32F, 1, 0, scale=0.25)
    down = cv2.Sobel(soft, cv2.CV_32F, 0, 1, scale=0.25)
    return np.asarray(np.minimum(cv2.magnitude(across, down), _GRADIENT_CAP), np.float32)


def _structures(grey: Grey8) -> tuple[Grey, Grey]:
    """Return the strength of fine structures and of those twice as coarse."""
    plane = grey.astype(np.float32)
    first, second, third = (
        cv2.GaussianBlur(plane, (0, 0), _FINE_SIGMA_PX * factor) for factor in (1, 2, 4)
    )
    fine, coarse = cv2.absdiff(first, second), cv2.absdiff(second, third)
    return np.asarray(fine, np.float32), np.asarray(coarse, np.float32)


def _sharpness(grey: Grey8, edges: NDArray[np.bool_]) -> float:
    fine, coarse = (float(np.square(plane[edges]).sum()) for plane in _structures(grey))
    return math.sqrt(fine / max(coarse, 1.0))


def _shrink(plane: Grey) -> Grey:
    rows, columns = plane.shape
    size = (_FIT_WIDTH_PX, round(rows * _FIT_WIDTH_PX / columns))
    return np.asarray(cv2.resize(plane, size, interpolation=cv2.INTER_AREA), np.float32)


def _shift(gradient: Grey, reference: PictureReference) -> Shift:
    """Return where a reference's still part fits best, to a fraction of a pixel."""
    if gradient.shape != reference.gradient.shape:
        return Shift(dx_px=0.0, dy_px=0.0, fit=0.0, fit_unmoved=0.0)
    reach = _FIT_REACH_PX
    padded = cv2.copyMakeBorder(gradient, reach, reach, reach, reach, cv2.BORDER_REFLECT)
    raw = cv2.matchTemplate(padded, reference.gradient, cv2.TM_CCOEFF_NORMED, mask=reference.weight)
    fits: Grey = np.nan_to_num(raw.astype(np.float32), nan=0.0, posinf=0.0, neginf=0.0)
    row, column = divmod(int(fits.argmax()), fits.shape[1])
    scale = FULL_WIDTH_PX / _FIT_WIDTH_PX
    return Shift(
        dx_px=(column + _vertex(fits[row], column) - reach) * scale,
        dy_px=(row + _vertex(fits[:, column], row) - reach) * scale,
        fit=float(fits[row, column]),
        fit_unmoved=float(fits[reach, reach]),
    )


def _vertex(line: NDArray[np.float32], place: int) -> float:
    """Return how far from its greatest sample the parabola through three samples peaks."""
    if not 0 < place < len(line) - 1:
        return 0.0
    before, at, after = (float(k) for k in line[place - 1 : place + 2])
    bend = before - 2.0 * at + after
    return 0.0 if bend >= 0.0 else 0.5 * (before - after) / bend
