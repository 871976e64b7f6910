"""What is to be said about a camera's settings, each thing by its name."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from calibration.camera_settings.knobs import Knobs
from calibration.camera_settings.search import Found
from calibration.camera_settings.target import COLUMNS, ROWS, Match, Target
from calibration.verdict import Finding, Grade
from cell.devices.camera_features import CameraFeature, quantity
from cell.vision.picture_measures import Flicker, focus, patches

MOST_ERROR = 3.0
"""Mean difference of the patches in grey levels up to which settings are good."""

_MOST_CLIPPED_SHARE = 0.05
_LEAST_PATCHES = 12
_LEAST_CORRELATION = 0.6
_LEAST_AGREEMENT = 0.5
_LEAST_CONTRAST = 0.06
_MOST_DARK_SHARE = 0.8
_LEAST_LIGHT = 0.1
_LEAST_SHARPNESS_RATIO = 0.93
_MOST_SWING = 0.01
_CHANGED_LEVELS = 15.0
_CHANGED_SHARE = 0.25
_GLOW_LEVEL, _CHANGED_GLOW = 30.0, 45.0
"""A dark screen's own glow shows the more the weaker the lamps are."""

_LEAST_CHANGED_PATCHES = 24
_SHORT_LOG = 0.02


def target_findings(target: Target) -> Iterator[Finding]:
    """Yield what is wrong with a reference, whatever the camera sees now."""
    if target.clipped_share > _MOST_CLIPPED_SHARE:
        is_lost = int(target.is_stable.sum()) < _LEAST_PATCHES
        yield Finding(
            code="clipped-reference",
            grade=Grade.BAD if is_lost else Grade.DEGRADED,
            text=f"{100 * target.clipped_share:.0f} % of {target.source} is clipped, so that its "
            "colours are not known there",
            hint="take a reference on a dark screen, exposed so that nothing but lamps clips",
        )
    elif target.sharpness > 0.0 and int(target.is_stable.sum()) < _LEAST_PATCHES:
        yield Finding(
            code="poor-reference",
            grade=Grade.BAD,
            text=f"{target.source} has {int(target.is_stable.sum())} even patches that are bright "
            f"enough; {_LEAST_PATCHES} are needed",
            hint="take a reference with the lights on that shows table, sheet or blocks",
        )


def auto_finding(features: Iterable[CameraFeature], when: str, grade: Grade) -> Iterator[Finding]:
    """Yield that features are left to the camera."""
    names = [f.name for f in features if f.control == "auto" and f.name != "frame_rate"]
    if names:
        yield Finding(
            code="auto-mode-on",
            grade=grade,
            text=f"{', '.join(names)} of the camera {when} automatic: colours change with "
            "whatever lies in the picture",
            hint="take them back by hand; see that no other program sets the camera",
        )


def scene_findings(
    target: Target, match: Match, pixels: NDArray[np.uint8], *, is_whole_picture: bool
) -> Iterator[Finding]:
    """Yield why a picture may not show what the target shows.

    Args:
        target: What it shall look like.
        match: How it compares.
        pixels: The picture.
        is_whole_picture: Whether the target is one of the whole scene, not of a grey area.
    """
    is_even = contrast(pixels) < _LEAST_CONTRAST
    if is_even and is_whole_picture and match.clipped_share < 0.5:
        yield Finding(
            code="lens-cap",
            grade=Grade.BAD,
            text="the picture is evenly dark or even all over, nothing is to be seen in it",
            hint="take the cap off the lens, clear the view",
        )
        return
    if not is_whole_picture or match.dark_share > _MOST_DARK_SHARE:
        return
    share = match.agreeing / max(match.usable, 1)
    if match.correlation < _LEAST_CORRELATION and share < _LEAST_AGREEMENT:
        yield Finding(
            code="reference-other-scene",
            grade=Grade.BAD,
            text=f"the picture does not show the scene of {target.source}: brightness agrees by "
            f"{match.correlation:.2f} of 1, {100 * share:.0f} % of the patches share one factor",
            hint="take the reference of this camera, with the same picture on the screen; see "
            "that the camera has not been moved",
        )
        return
    changed = largest_change(target, pixels, match)
    if changed >= _LEAST_CHANGED_PATCHES:
        yield Finding(
            code="arm-in-picture",
            grade=Grade.DEGRADED,
            text=f"{100 * changed / (ROWS * COLUMNS):.0f} % of the picture in one piece is not as "
            f"in {target.source}: the arm or a hand is in view",
            hint="let the arm stand aside, keep hands away, and repeat",
        )


def light_findings(factor: float, basis: str) -> Iterator[Finding]:
    """Yield that there is hardly any light.

    Args:
        factor: Light of the lamps against what `basis` was set for.
        basis: The settings compared with, in words.
    """
    if factor < _LEAST_LIGHT:
        yield Finding(
            code="lights-off",
            grade=Grade.BAD,
            text=f"there is {100 * factor:.1f} % of the light that {basis} was made for; the "
            "lights seem to be off",
            hint="switch the cell's lights on, replace burnt-out lamps",
        )


def search_findings(found: Found, target: Target) -> Iterator[Finding]:
    """Yield whether a search has reached its target, and if not, why."""
    error = found.best.match.error
    if not found.has_effect:
        yield Finding(
            code="settings-without-effect",
            grade=Grade.BAD,
            text="the pictures do not follow shutter, gain and white balance",
            hint="an automatic mode that the camera does not tell may be on: switch its power "
            "off and on, and see that no other program sets it",
        )
    red, green, blue = found.short
    if green > _SHORT_LOG and error > MOST_ERROR:
        yield _short("light-too-weak", f"{math.exp(green):.2f} times as much light", "brighter", 1)
    elif green < -_SHORT_LOG and error > MOST_ERROR:
        yield _short("light-too-strong", f"{math.exp(green):.2f} of the light", "dimmer", -1)
    beyond = [n for n, s in (("red", red - green), ("blue", blue - green)) if abs(s) > _SHORT_LOG]
    if beyond and error > MOST_ERROR:
        factors = {"red": math.exp(red - green), "blue": math.exp(blue - green)}
        asked = ", ".join(f"{name} {factors[name]:.2f} times" for name in beyond)
        yield Finding(
            code="white-balance-range",
            grade=Grade.BAD,
            text=f"the white balance is at its end and would have to go on: {asked}",
            hint="use lamps of one colour that is nearer to white",
        )
    if not math.isfinite(error):
        yield _nothing_to_compare(found, target)
    elif error > MOST_ERROR and abs(green) <= _SHORT_LOG and not beyond:
        yield Finding(
            code="not-reached",
            grade=Grade.BAD,
            text=f"the patches still differ from {target.source} by {error:.1f} grey levels after "
            f"{len(found.tries)} pictures; {MOST_ERROR:g} are allowed",
            hint="see whether the light changes while it is measured, and repeat",
        )


def _nothing_to_compare(found: Found, target: Target) -> Finding:
    """Return why no patch of the picture could be held against its target."""
    best = found.best.match
    if best.clipped_share >= best.dark_share:
        return Finding(
            code="clipped-area",
            grade=Grade.BAD,
            text=f"{100 * best.clipped_share:.0f} % of the patches of {target.source} are clipped "
            "in the picture: how bright they are is not known",
            hint="choose a darker grey area that no lamp is mirrored in, or ask for a lower grey "
            "level",
        )
    return Finding(
        code="dark-area",
        grade=Grade.BAD,
        text=f"{100 * best.dark_share:.0f} % of the patches of {target.source} are black in the "
        "picture: they tell no colour",
        hint="choose a brighter grey area, or switch the lights on",
    )


def knob_findings(knobs: Knobs) -> Iterator[Finding]:
    """Yield what a camera lacks, and what its settings cost."""
    absent = [
        name
        for name, knob in (
            ("shutter", knobs.shutter), ("gain", knobs.gain),
            ("white balance red", knobs.red), ("white balance blue", knobs.blue),
        )
        if knob is None
    ]  # fmt: skip
    if absent:
        yield Finding(
            code="no-such-feature",
            grade=Grade.DEGRADED,
            text=f"the camera or its backend has no {', '.join(absent)} to set",
            hint="set it at the camera itself, or reach the camera through another backend",
        )
    shutter = knobs.shutter
    if shutter is not None and shutter.is_absolute and shutter.value > knobs.frame_ms * 1.001:
        yield Finding(
            code="slow-shutter",
            grade=Grade.OK,
            text=f"the shutter of {shutter.value:.0f} ms is longer than a frame of "
            f"{knobs.frame_ms:.0f} ms: pictures come slower",
            hint="more light would make it shorter",
        )


def flicker_findings(seen: Flicker, knobs: Knobs) -> Iterator[Finding]:
    """Yield that the light swings from picture to picture."""
    if seen.swing_share <= max(_MOST_SWING, 3.0 * seen.noise_share):
        return
    swing_ms = 500.0 / knobs.mains_hz
    yield Finding(
        code="flicker",
        grade=Grade.DEGRADED,
        text=f"the light swings by {100 * seen.swing_share:.1f} % over {seen.pictures} pictures",
        hint=f"set the shutter to a multiple of {swing_ms:.2f} ms (lamps at {knobs.mains_hz:g} Hz "
        "mains), or use lamps that do not flicker",
    )


def focus_findings(sharpness: float, reference: float) -> Iterator[Finding]:
    """Yield that the picture is less sharp than the reference."""
    if reference > 0.0 and sharpness < _LEAST_SHARPNESS_RATIO * reference:
        yield Finding(
            code="out-of-focus",
            grade=Grade.DEGRADED,
            text=f"the picture is {100 * sharpness / reference:.0f} % as sharp as the reference",
            hint="turn the focus ring back, clean the lens",
        )


def range_findings(knobs: Knobs, wanted: Sequence[tuple[str, float, str]]) -> Iterator[Finding]:
    """Yield which typed values the camera cannot take.

    Args:
        knobs: The camera's.
        wanted: Feature, value and unit.
    """
    by_name = {knob.name: knob for knob in knobs}
    for name, value, unit in wanted:
        knob = next((k for n, k in by_name.items() if n == name), None)
        if knob is not None and not knob.low <= value <= knob.high:
            nearest = min(max(value, knob.low), knob.high)
            yield Finding(
                code="out-of-range",
                grade=Grade.BAD,
                text=f"{name} {quantity(value, unit)} is outside {knob.low:g} to {knob.high:g}",
                hint=f"the nearest that the camera takes is {quantity(nearest, unit)}",
            )


def contrast(pixels: NDArray[np.uint8]) -> float:
    """Return how much patches differ in brightness, of their mean; 0 for an even picture."""
    green = patches(pixels, COLUMNS, ROWS).means[..., 1]
    return float(green.std() / max(float(green.mean()), 4.0))


def sharpness_of(pixels: NDArray[np.uint8]) -> float:
    """Return how sharp a picture is."""
    return focus(pixels)


def largest_change(target: Target, pixels: NDArray[np.uint8], match: Match) -> int:
    """Return how many patches in one piece do not look as in the target in the same light."""
    factor = np.exp(np.array(match.log_ratios))
    seen = patches(pixels, COLUMNS, ROWS)
    now = np.minimum(seen.means * factor, 255.0)
    # What the lamps do not light, such as the screen's own glow, does not change with them.
    low, high = np.minimum(seen.means, now), np.maximum(seen.means, now)
    difference = np.maximum(low - target.means, target.means - high).max(axis=2)
    brightest = target.means.max(axis=2)
    limit = np.maximum(_CHANGED_LEVELS, _CHANGED_SHARE * brightest)
    limit[brightest < _GLOW_LEVEL] = _CHANGED_GLOW
    changed = (difference > limit) & (target.clipped < 0.5) & (seen.clipped < 0.5)
    return _largest_piece(changed)


def _largest_piece(mask: NDArray[np.bool_]) -> int:
    left = {(int(r), int(c)) for r, c in np.argwhere(mask)}
    largest = 0
    while left:
        edge, size = [left.pop()], 0
        while edge:
            row, column = edge.pop()
            size += 1
            for near in (
                (row - 1, column),
                (row + 1, column),
                (row, column - 1),
                (row, column + 1),
            ):
                if near in left:
                    left.remove(near)
                    edge.append(near)
        largest = max(largest, size)
    return largest


def _short(code: str, amount: str, lamps: str, sign: int) -> Finding:
    end = "longest shutter and greatest" if sign > 0 else "shortest shutter and least"
    return Finding(
        code=code,
        grade=Grade.BAD,
        text=f"with {end} gain the picture would need {amount}",
        hint=f"use {lamps} lamps, or {'open' if sign > 0 else 'close'} the lens's aperture",
    )
