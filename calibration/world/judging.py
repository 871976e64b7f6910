"""Whether a lattice can be worked on: in reach of the arm, in the picture, on the screen."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from calibration.reach import TableReach
from calibration.verdict import Finding, Grade
from calibration.world.fit import mapped
from cell.geometry import LatticeMap
from cell.profile import Profile

Points = NDArray[np.float64]

HEIGHTS_MM = (200.0, 98.0, 55.0)
"""Where the tool works over a lattice point: on its way, over blocks, laying them down."""

_PICTURE = (1280, 960)


def judge_world(
    profile: Profile, lattice: LatticeMap, columns: int, rows: int, camera: str
) -> tuple[Finding, ...]:
    """Return what keeps the corners of a world from being worked on.

    Args:
        profile: The cell's profile.
        lattice: Where the lattice lies.
        columns: Lattice points along its x.
        rows: Lattice points along its y.
        camera: The camera above the table; empty for none.
    """
    cells = np.array([[0, 0], [columns - 1, 0], [columns - 1, rows - 1], [0, rows - 1]], np.float64)
    places = mapped(lattice, cells)
    found = [_reach(profile, cells, places)]
    found.append(_screen(profile, cells, places))
    if camera:
        found.append(_view(profile, cells, places, camera))
    return tuple(finding for finding in found if finding is not None)


def _reach(profile: Profile, cells: Points, places: Points) -> Finding | None:
    reach = TableReach(profile)
    for cell, (x, y) in zip(cells.tolist(), places.tolist(), strict=True):
        why = reach.why_not(x, y, HEIGHTS_MM)
        if why:
            away = math.hypot(x, y)
            return Finding(
                code="out-of-reach",
                grade=Grade.BAD,
                text=f"lattice ({cell[0]:.0f}, {cell[1]:.0f}) lies at robot ({x:.0f}, {y:.0f}) mm, "
                f"{away:.0f} mm from the arm's base: {why}",
                hint="move the origin towards the arm, or make the world smaller",
            )
    return None


def _view(profile: Profile, cells: Points, places: Points, camera: str) -> Finding | None:
    top_mm = profile.block_top_mm
    view = profile.cameras[camera].view(top_mm)
    if view is None:
        return Finding(
            code="view-not-known",
            grade=Grade.DEGRADED,
            text=f"whether camera {camera} sees the world is not known: it is not calibrated",
            hint="calibrate it first",
        )
    half = _half_block(profile)
    for cell, place in zip(cells.tolist(), places, strict=True):
        ring = place + half * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
        try:
            pixels = view.to_picture(ring, top_mm)
        except ValueError:
            pixels = np.full((4, 2), -1.0)
        off = (pixels < -0.5) | (pixels > np.array(_PICTURE) - 0.5)
        if off.any():
            u, v = pixels.mean(axis=0)
            return Finding(
                code="out-of-view",
                grade=Grade.BAD,
                text=f"a block on lattice ({cell[0]:.0f}, {cell[1]:.0f}) is not wholly in the "
                f"picture of camera {camera}: it would be at ({u:.0f}, {v:.0f}) px of "
                f"{_PICTURE[0]} x {_PICTURE[1]}",
                hint="move the origin, or make the world smaller",
            )
    return None


def _screen(profile: Profile, cells: Points, places: Points) -> Finding | None:
    display = profile.display
    if not display.enabled:
        return None
    angle = math.radians(display.angle_deg)
    offset = places - (display.corner_x_mm, display.corner_y_mm)
    right = offset @ (math.cos(angle), math.sin(angle))
    down = offset @ (math.sin(angle), -math.cos(angle))
    half = _half_block(profile)
    wide, high = display.size_mm
    beyond = np.maximum.reduce([half - right, right + half - wide, half - down, down + half - high])
    worst = int(beyond.argmax())
    if beyond[worst] <= 0:
        return None
    return Finding(
        code="off-screen",
        grade=Grade.DEGRADED,
        text=f"a block on lattice ({cells[worst][0]:.0f}, {cells[worst][1]:.0f}) stands "
        f"{beyond[worst]:.0f} mm over the edge of the screen's picture",
        hint="recognition by the screen's light does not see it; move the origin",
    )


def _half_block(profile: Profile) -> float:
    return 0.5 * max(b.width_mm for b in profile.blocks.values())
