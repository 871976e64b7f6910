"""Pictures of a lit and a dark screen with shapes on it, drawn by exact coverage."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

RED = (187.0, 60.0, 47.0)
GREEN = (88.0, 135.0, 60.0)
LIT = 235.0
UNLIT = 20.0
SHAPE = (960, 1280)


def rectangle(
    u_px: float, v_px: float, half_long: float, half_short: float, turn_deg: float = 0.0
) -> NDArray[np.float64]:
    """Return how much of each pixel a turned rectangle covers, edges one pixel wide."""
    v, u = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]].astype(np.float64)
    turn = math.radians(turn_deg)
    along = (u - u_px) * math.cos(turn) + (v - v_px) * math.sin(turn)
    across = -(u - u_px) * math.sin(turn) + (v - v_px) * math.cos(turn)
    inner = np.minimum(half_long - np.abs(along), half_short - np.abs(across))
    return np.asarray(np.clip(inner + 0.5, 0.0, 1.0))


def disc(u_px: float, v_px: float, radius: float) -> NDArray[np.float64]:
    """Return how much of each pixel a disc covers."""
    v, u = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]].astype(np.float64)
    return np.asarray(np.clip(radius - np.hypot(u - u_px, v - v_px) + 0.5, 0.0, 1.0))


def pictures(
    *things: tuple[NDArray[np.float64], tuple[float, float, float]],
    lit: float = LIT,
    lamps: float = 1.0,
) -> tuple[Pixels, Pixels]:
    """Return the pictures on a white and on a black screen of covered, painted shapes."""
    made = []
    for level in (lit, UNLIT * lamps):
        picture = np.full((*SHAPE, 3), level)
        for cover, colour in things:
            picture += cover[..., None] * (np.array(colour) * lamps - picture)
        made.append(np.rint(picture).astype(np.uint8))
    return made[0], made[1]
