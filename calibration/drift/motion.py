"""What moved, from where dots were seen and where they are seen now.

A small motion of a camera (three shifts, three turns) moves the dots in its picture; a small
motion of the screen (two shifts, a turn) moves them in every camera's. Dots that a block
half hides stand out and lose their weight (Huber).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.least_squares import differences
from cell.geometry import CameraView, Transform

Points = NDArray[np.float64]

_HUBER = 1.5
_LEAST_NOISE_PX = 0.03
_ROUNDS = 12
_SHIFT_MM = 30.0
_TURN_DEG = 2.0
"""No camera moves farther than about this unnoticed; keeps apart what a camera that looks
straight down cannot: a shift aside and a tilt."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """By how much a camera's picture of the table is off.

    Attributes:
        camera: Its name.
        dots: How many dots it was seen by.
        noise_px: How much the dots scatter about the motion.
        rms_mm: Root mean square over the playground, at the block tops.
        max_mm: At the worst place of the playground.
        deviation_mm: Standard deviation of `rms_mm` if nothing moved.
        screen_mm: The same motion as one of the screen: shift along robot x and y at the
            playground's middle (mm), turn (deg).
        screen_deviation: Standard deviations of these three.
        screen_misfit_px: How much the dots scatter about that motion of the screen.
        allowance_mm: What the place before may itself be off.
    """

    camera: str
    dots: int
    noise_px: float
    rms_mm: float
    max_mm: float
    deviation_mm: float
    screen_mm: tuple[float, float, float]
    screen_deviation: tuple[float, float, float]
    screen_misfit_px: float
    allowance_mm: float = 0.0


def find_motion(
    camera: str,
    view: CameraView,
    before_px: Points,
    now_px: Points,
    *,
    glass_mm: float,
    top_mm: float,
    playground_mm: Points,
    allowance_mm: float = 0.0,
    least_noise_px: float = _LEAST_NOISE_PX,
) -> Motion:
    """Return the motion that explains how dots moved in a camera's picture.

    Args:
        camera: The camera's name.
        view: Where it stood when the dots were seen before.
        before_px: Where they were seen before, (n, 2), n ≥ 4.
        now_px: Where they are seen now, (n, 2).
        glass_mm: Height of the glass in the robot frame.
        top_mm: Height at which the playground matters: the block tops.
        playground_mm: Robot x, y of places that matter, (m, 2).
        allowance_mm: What the place before may itself be off.
        least_noise_px: Dots are not believed to be found better than that.
    """
    dots_mm = view.to_robot(before_px, glass_mm)
    solid = np.column_stack([dots_mm, np.full(len(dots_mm), glass_mm)])
    slopes = differences(lambda change: moved(view, change).project(solid).ravel(), np.zeros(6))
    prior = 1.0 / np.array([_SHIFT_MM] * 3 + [math.radians(_TURN_DEG)] * 3)
    off = (now_px - before_px).ravel()
    change, covariance, noise_px = _robust(slopes, off, prior, least_noise_px)
    seen_px = view.to_picture(playground_mm, top_mm)
    apparent = differences(
        lambda change: moved(view, -change).to_robot(seen_px, top_mm).ravel(), np.zeros(6)
    )
    shift_mm = (apparent @ change).reshape(-1, 2)
    spread = float(np.trace(apparent @ covariance @ apparent.T)) / len(playground_mm)
    middle = playground_mm.mean(axis=0)
    screen_slopes = _screen_slopes(view, solid, middle)
    screen_prior = 1.0 / np.array([_SHIFT_MM, _SHIFT_MM, math.radians(_TURN_DEG)])
    rigid, rigid_covariance, misfit_px = _robust(screen_slopes, off, screen_prior, least_noise_px)
    x, y, turn = (float(k) for k in rigid)
    dx, dy, dturn = (float(k) for k in np.sqrt(np.diag(rigid_covariance)))
    length = np.hypot(shift_mm[:, 0], shift_mm[:, 1])
    return Motion(
        camera=camera,
        dots=len(before_px),
        noise_px=noise_px,
        rms_mm=float(np.sqrt(np.mean(length**2))),
        max_mm=float(length.max()),
        deviation_mm=math.sqrt(spread),
        screen_mm=(x, y, math.degrees(turn)),
        screen_deviation=(dx, dy, math.degrees(dturn)),
        screen_misfit_px=misfit_px,
        allowance_mm=allowance_mm,
    )


def moved(view: CameraView, change: Points) -> CameraView:
    """Return a camera moved by shifts (mm) and turns (rad) in its own frame, (6,)."""
    x, y, z, a, b, c = (float(k) for k in change)
    matrix = np.array([[1.0, -c, b, x], [c, 1.0, -a, y], [-b, a, 1.0, z], [0.0, 0.0, 0.0, 1.0]])
    left, _, right = np.linalg.svd(matrix[:3, :3])
    matrix[:3, :3] = left @ right
    return CameraView(view.lens, view.robot_from_camera @ Transform(matrix))


def agree(first: Motion, second: Motion, slack_mm: float) -> bool:
    """Tell whether two cameras saw the same motion of the screen."""
    for k, slack in ((0, slack_mm), (1, slack_mm), (2, math.degrees(slack_mm / 300.0))):
        spread = math.hypot(first.screen_deviation[k], second.screen_deviation[k])
        if abs(first.screen_mm[k] - second.screen_mm[k]) > slack + 3.0 * spread:
            return False
    return True


def are_all_one(motions: Sequence[Motion], slack_mm: float) -> bool:
    """Tell whether all cameras saw one motion of the screen."""
    return all(agree(motions[0], other, slack_mm) for other in motions[1:])


def _screen_slopes(view: CameraView, solid: Points, middle: Points) -> Points:
    def seen(change: Points) -> Points:
        x, y, turn = (float(k) for k in change)
        around = solid[:, :2] - middle
        turned = around + turn * np.column_stack([-around[:, 1], around[:, 0]])
        places = np.column_stack([turned + middle + (x, y), solid[:, 2]])
        return view.project(places).ravel()

    return differences(seen, np.zeros(3))


def _robust(
    slopes: Points, off: Points, prior: Points, least_noise_px: float
) -> tuple[Points, Points, float]:
    """Return the change that explains offsets, its covariance, and the offsets' scatter."""
    weight: Points = np.ones(off.size)
    change: Points = np.zeros(slopes.shape[1])
    normal: Points = np.eye(slopes.shape[1])
    noise = least_noise_px
    for _ in range(_ROUNDS):
        normal = (slopes * weight[:, None]).T @ slopes / noise**2 + np.diag(prior**2)
        right = slopes.T @ (weight * off) / noise**2
        change = np.asarray(np.linalg.solve(normal, right), np.float64)
        left = np.abs(off - slopes @ change)
        noise = max(1.4826 * float(np.median(left)), least_noise_px)
        share = np.minimum(1.0, _HUBER * noise / np.maximum(left, 1e-9))
        weight = np.asarray(share**2, np.float64)
    return change, np.asarray(np.linalg.inv(normal), np.float64), noise
