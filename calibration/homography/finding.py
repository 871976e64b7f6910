"""Finds the centre of the calibration object's upper face in pictures of a camera above it.

The object hides the lit screen, or changes the picture of the empty table. What it hides is
its upper face and, away from the point below the camera, its side, unless the screen lights
that: the middle of all of it lies up to half the side's width off. The half of the outline
that faces away from that point belongs to the upper face alone. Where a circle through it and
one through the whole outline agree, the side is not seen and the whole outline counts, else
that half, in coordinates in which tilt and lens do not stretch the face.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.errors import CalibrationError
from calibration.verdict import Finding, Grade

Pixels = NDArray[np.uint8]
Points = NDArray[np.float64]
Levels = NDArray[np.float32]

_LEAST_SCREEN_LEVEL = 60.0
_LEAST_CHANGE = 18.0
_LEAST_LIGHT = 25.0
_OBJECT_PERCENT = 99.9
_ROUND = 0.72
_AREAS = (0.55, 1.9)
_ANY_AREA_PX = (600.0, 12_000.0)
_HIDDEN_SHARE = 0.05
_RAYS = 180
_STEP_PX = 0.25
_HALF_ARC_DEG = 80.0
_SHARP_PX = 6.0
_LEAST_RAYS = 80
_SIDE_PX = 0.75


class ObjectNotFound(CalibrationError):
    """The calibration object cannot be measured.

    Attributes:
        finding: Why, and what to do.
        findings: The same with what else is wrong.
    """

    def __init__(self, finding: Finding, *more: Finding) -> None:
        self.finding = finding
        self.findings = (finding, *more)
        super().__init__(str(finding))


@dataclass(frozen=True, slots=True, kw_only=True)
class Expected:
    """What is known of the object's picture beforehand.

    Attributes:
        centre_px: Where it should be; None if nobody knows.
        radius_px: How large its face should be; None if nobody knows.
        below_px: The point of the picture straight below the camera.
        stretch: d (u, v) / d (x, y), up to a factor: how the picture stretches the face.
    """

    centre_px: tuple[float, float] | None = None
    radius_px: float | None = None
    below_px: tuple[float, float] = (639.5, 479.5)
    stretch: tuple[tuple[float, float], tuple[float, float]] = ((1.0, 0.0), (0.0, 1.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """A face that was measured.

    Attributes:
        u_px: Column of its centre.
        v_px: Row of its centre.
        radius_px: Its radius.
        deviation_px: Standard deviation of the centre along each axis, from the outline's
            scatter about the circle.
        edge_px: Width of the outline, from a tenth to nine tenths of its step.
        is_side_hidden: Whether the object's side hid background as well.
    """

    u_px: float
    v_px: float
    radius_px: float
    deviation_px: float
    edge_px: float
    is_side_hidden: bool

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What its picture is to blame for."""
        if self.edge_px <= _SHARP_PX:
            return ()
        return (
            Finding(
                code="blurred",
                grade=Grade.DEGRADED,
                text=f"the picture is blurred: an edge is {self.edge_px:.1f} px wide, "
                f"{_SHARP_PX:g} px at most are usual",
                hint="focus the lens and tighten its ring, and keep the camera still",
            ),
        )


def on_screen(white: Pixels, black: Pixels) -> Levels:
    """Return how much of the screen's light each pixel gets.

    Args:
        white: Picture with the screen white, R G B.
        black: The same with the screen black.

    Raises:
        ObjectNotFound: The screen does not light up, or is hidden to a large part.
    """
    red, green, blue = cv2.split(cv2.subtract(white, black))
    levels = np.asarray(cv2.max(cv2.max(red, green), blue), np.float32)
    screen = float(np.percentile(levels[::4, ::4], 80))
    if screen < _LEAST_SCREEN_LEVEL:
        raise ObjectNotFound(
            _bad(
                "screen-off",
                f"white less black is {screen:.0f} grey levels, a lit screen gives "
                f"{_LEAST_SCREEN_LEVEL:.0f} at least: the screen is off or shows something else",
                "switch the television on and to the computer's input",
            ),
            *dark_room(black),
        )
    hidden = _hidden_share(levels < 0.5 * screen)
    if hidden > _HIDDEN_SHARE:
        raise ObjectNotFound(
            _bad(
                "arm-in-picture",
                f"{100 * hidden:.0f} % of the lit screen are hidden, by the arm or something "
                "else large",
                "bring the arm aside and clear the playground",
            )
        )
    return levels


def dark_room(black: Pixels) -> tuple[Finding, ...]:
    """Return whether the lights are off in a picture with the screen black.

    The object itself is bright under the lamps, also where nothing but the screen is in view.
    """
    brightest = float(np.percentile(black[::4, ::4], _OBJECT_PERCENT))
    if brightest >= _LEAST_LIGHT:
        return ()
    return (
        Finding(
            code="lights-off",
            grade=Grade.DEGRADED,
            text=f"with the screen black nothing in the picture is brighter than "
            f"{brightest:.0f} grey levels: the lights are off",
            hint="switch the lights on, or look for burnt-out lamps",
        ),
    )


def against_empty(picture: Pixels, empty: Pixels) -> Levels:
    """Return levels that are low where a picture differs from the one of the empty table.

    Raises:
        ObjectNotFound: Both are dark, hardly differ, or differ nearly everywhere.
    """
    if float(np.percentile(empty[::4, ::4], 99)) < _LEAST_LIGHT:
        raise ObjectNotFound(
            _bad("lights-off", "the picture is dark throughout", "switch the lights on")
        )
    change = cv2.absdiff(cv2.GaussianBlur(picture, (3, 3), 0), cv2.GaussianBlur(empty, (3, 3), 0))
    levels = change.max(axis=2).astype(np.float32)
    strong = levels > _LEAST_CHANGE
    hidden = float(strong.mean())
    if hidden > _HIDDEN_SHARE:
        raise ObjectNotFound(
            _bad(
                "arm-in-picture",
                f"{100 * hidden:.0f} % of the picture differ from the one of the empty table: "
                "the arm or a person is in it, the light was switched, or the camera was moved",
                "bring the arm aside, keep light and camera as they are and begin again",
            )
        )
    step = float(np.percentile(levels[strong], 60)) if strong.any() else _LEAST_CHANGE
    return np.asarray(np.maximum(step - levels, 0.0), np.float32)


def find_object(levels: Levels, expected: Expected) -> Seen:
    """Return the centre of the round dark spot.

    Args:
        levels: High where the background is seen, low where it is hidden; (960, 1280).
        expected: What is known beforehand.

    Raises:
        ObjectNotFound: There is none, or more than one that it could be.
    """
    top = float(np.percentile(levels[::4, ::4], 80))
    dark = (levels < 0.5 * top).astype(np.uint8)
    spots = _spots(dark, expected)
    if not spots:
        raise ObjectNotFound(_unseen(dark, expected))
    if len(spots) > 1:
        where = "; ".join(f"({u:.0f}, {v:.0f}) px" for u, v, _ in spots[:4])
        raise ObjectNotFound(
            _bad(
                "several-objects",
                f"{len(spots)} things could be the object, at {where}",
                "clear the playground of everything else",
            )
        )
    return _measured(levels, spots[0], expected)


def _spots(dark: Pixels, expected: Expected) -> list[tuple[float, float, float]]:
    """Return centre and radius of what could be the object."""
    contours, _ = cv2.findContours(dark, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    least, most = _ANY_AREA_PX
    if expected.radius_px is not None:
        face = math.pi * expected.radius_px**2
        least, most = _AREAS[0] * face, _AREAS[1] * face
    found = []
    for contour in contours:
        area = cv2.contourArea(contour)
        if not least <= area <= most:
            continue
        _, _, wide, tall = cv2.boundingRect(contour)
        roundness = 4.0 * math.pi * area / max(cv2.arcLength(contour, True), 1.0) ** 2
        moments = cv2.moments(contour)
        u, v = moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
        inside = dark[min(int(v + 0.5), dark.shape[0] - 1), min(int(u + 0.5), dark.shape[1] - 1)]
        if roundness >= _ROUND and max(wide, tall) < 1.6 * min(wide, tall) and inside:
            found.append((u, v, math.sqrt(area / math.pi)))
    if expected.centre_px is not None and len(found) > 1:
        u0, v0 = expected.centre_px
        found.sort(key=lambda spot: math.hypot(spot[0] - u0, spot[1] - v0))
        near = math.hypot(found[0][0] - u0, found[0][1] - v0)
        if near < 0.5 * math.hypot(found[1][0] - u0, found[1][1] - v0):
            return found[:1]
    return found


def _measured(levels: Levels, spot: tuple[float, float, float], expected: Expected) -> Seen:
    u, v, radius = spot
    centre, deviation, edge_px, is_side_hidden = np.array([u, v]), 0.0, 0.0, False
    stretch = np.array(expected.stretch)
    stretch /= math.sqrt(abs(float(np.linalg.det(stretch))))
    flat = np.linalg.inv(stretch)
    for _ in range(3):
        angles, points, edge_px = _outline(levels, centre, radius)
        if len(points) < _LEAST_RAYS:
            raise ObjectNotFound(_cut_off(centre))
        below = np.array(expected.below_px)
        away = math.atan2(*(centre - below)[::-1])
        turn = np.abs((angles - away + math.pi) % (2.0 * math.pi) - math.pi)
        outer = turn <= math.radians(_HALF_ARC_DEG)
        face = (points - centre) @ flat.T
        shift, found, deviation = _circle(face)
        is_far = math.hypot(*(centre - below)) > radius
        if is_far and int(outer.sum()) >= _LEAST_RAYS // 2:
            half = _circle(face[outer])
            is_side_hidden = math.hypot(*(half[0] - shift)) > _SIDE_PX
            if is_side_hidden:
                shift, found, deviation = half
        centre, radius = centre + stretch @ shift, found
    return Seen(
        u_px=float(centre[0]),
        v_px=float(centre[1]),
        radius_px=radius,
        deviation_px=deviation,
        edge_px=edge_px,
        is_side_hidden=is_side_hidden,
    )


def _cut_off(centre: Points) -> Finding:
    return _bad(
        "object-cut-off",
        f"the outline of the object at ({centre[0]:.0f}, {centre[1]:.0f}) px is hidden or cut off",
        "place it where all of it is seen",
    )


def _outline(levels: Levels, centre: Points, radius: float) -> tuple[Points, Points, float]:
    """Return angles and points where rays from a centre pass half the step, and its width."""
    angles = np.linspace(0.0, 2.0 * math.pi, _RAYS, endpoint=False)
    reach = np.arange(0.45 * radius, 1.65 * radius, _STEP_PX)
    u = centre[0] + np.cos(angles)[:, None] * reach
    v = centre[1] + np.sin(angles)[:, None] * reach
    rays = cv2.remap(
        levels, u.astype(np.float32), v.astype(np.float32), cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT, borderValue=0.0,
    )  # fmt: skip
    rays = np.asarray(cv2.GaussianBlur(rays, (5, 1), 0), np.float64)
    low = np.median(rays[:, : len(reach) // 4], axis=1)
    high = np.percentile(rays, 90, axis=1)
    step = high - low
    share = (rays - low[:, None]) / np.maximum(step, 1e-9)[:, None]
    half, tenth, most = (_first_above(share, level) for level in (0.5, 0.1, 0.9))
    good = (step > 0.4 * np.median(step)) & (half > 0)
    at = 0.45 * radius + half[good] * _STEP_PX
    width = float(np.median((most - tenth)[good])) * _STEP_PX if good.any() else 0.0
    points = centre + at[:, None] * np.stack([np.cos(angles[good]), np.sin(angles[good])], axis=1)
    return angles[good], points, width


def _first_above(share: Points, level: float) -> Points:
    """Return the (fractional) index where rows first reach a level; 0 where they begin there."""
    above = share >= level
    index = above.argmax(axis=1)
    row = np.arange(len(share))
    before = np.maximum(index - 1, 0)
    rise = share[row, index] - share[row, before]
    back = np.divide(share[row, index] - level, rise, out=np.zeros(len(share)), where=rise > 0)
    return np.asarray(np.where(above.any(axis=1) & (index > 0), index - back, 0.0))


def _circle(points: Points) -> tuple[Points, float, float]:
    """Return centre, radius and the centre's deviation of the circle through points.

    Gauss-Newton on the distances, from the algebraic fit; points further out than three
    times the usual distance are left out.
    """
    middle = points.mean(axis=0)
    q = points - middle
    rows = np.concatenate([2.0 * q, np.ones((len(q), 1))], axis=1)
    solution, *_ = np.linalg.lstsq(rows, (q**2).sum(axis=1), rcond=None)
    centre = solution[:2]
    radius = math.sqrt(max(float(solution[2] + centre @ centre), 1e-9))
    covariance = np.eye(3)
    for _ in range(6):
        offset = q - centre
        distance = np.hypot(*offset.T)
        miss = distance - radius
        usual = 1.4826 * float(np.median(np.abs(miss))) + 1e-6
        keep = np.abs(miss) <= 3.0 * usual
        slope = np.concatenate([-offset / distance[:, None], -np.ones((len(q), 1))], axis=1)[keep]
        inverse = np.linalg.inv(slope.T @ slope)
        step = -inverse @ slope.T @ miss[keep]
        centre, radius = centre + step[:2], radius + float(step[2])
        freedom = max(int(keep.sum()) - 3, 1)
        covariance = inverse * float((miss[keep] ** 2).sum()) / freedom
        if float(np.abs(step).max()) < 1e-6:
            break
    return centre + middle, radius, math.sqrt(0.5 * float(covariance[0, 0] + covariance[1, 1]))


def _hidden_share(dark: NDArray[np.bool_]) -> float:
    """Return which share of the lit area's hull is dark."""
    lit = (~dark).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(lit, connectivity=4)
    if count < 2:
        return 1.0
    largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    contours, _ = cv2.findContours(
        (labels == largest).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    hull = np.zeros(dark.shape, np.uint8)
    cv2.fillConvexPoly(hull, cv2.convexHull(max(contours, key=cv2.contourArea)), 1)
    inside = hull.astype(bool)
    return float((dark & inside).sum() / max(int(inside.sum()), 1))


def _unseen(dark: Pixels, expected: Expected) -> Finding:
    where = ""
    if expected.centre_px is not None:
        where = f" near ({expected.centre_px[0]:.0f}, {expected.centre_px[1]:.0f}) px"
    return _bad(
        "object-not-seen",
        f"nothing round of the object's size is seen{where}; {100 * float(dark.mean()):.1f} % of "
        "the picture are dark",
        "see that it stands on the table, away from other things and wholly in the picture",
    )


def _bad(code: str, text: str, hint: str) -> Finding:
    return Finding(code=code, grade=Grade.BAD, text=text, hint=hint)
