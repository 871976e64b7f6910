"""Lumps: things not recognised, with the blocks that touch them, that may be pushed apart.

Blocks that lie too close to be told apart are seen as one strange thing. What is of the size
of a few blocks may be parted by a short, slow push; anything larger is left alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cell.cleaning.sight import Playground
from cell.contact import Body, Footprint, Point, push_out

_SHORT_MM = 25.0
_LONG_MM = 240.0
_TURN_STEP_DEG = 3
_NEAR_MM = 2.0


def lumps(ground: Playground) -> Iterator[tuple[Footprint, tuple[Body, ...]]]:
    """Yield the least rectangle around each lump, and everything that is no part of it."""
    parts = [_Part(thing.corners, thing.edge) for thing in ground.strange]
    parts += [_Part(_grown(block.body).polygon(), (_grown(block.body),)) for block in ground.blocks]
    strange = set(range(len(ground.strange)))
    while strange:
        lump = _lump_of(min(strange), parts)
        strange -= lump
        box = least_rectangle([corner for index in lump for corner in parts[index].corners])
        short, long = sorted((box.length_mm, box.width_mm))
        if short < _SHORT_MM or long > _LONG_MM:
            continue
        yield (
            box,
            tuple(
                piece
                for index, part in enumerate(parts)
                if index not in lump
                for piece in part.pieces
            ),
        )


@dataclass(frozen=True, slots=True)
class _Part:
    corners: tuple[Point, ...]
    pieces: tuple[Body, ...]


def _lump_of(first: int, parts: Sequence[_Part]) -> set[int]:
    """Return the parts that touch one, directly or through others."""
    lump, waiting = {first}, [first]
    while waiting:
        part = parts[waiting.pop()]
        for index, other in enumerate(parts):
            if index not in lump and _touch(part, other):
                lump.add(index)
                waiting.append(index)
    return lump


def least_rectangle(corners: Sequence[Point]) -> Footprint:
    """Return the smallest rectangle around points, to a few degrees."""
    points = np.array(corners)
    found = (_rectangle(points, turn) for turn in range(0, 180, _TURN_STEP_DEG))
    return min(found, key=lambda box: box.length_mm * box.width_mm)


def _rectangle(points: NDArray[np.float64], turn_deg: float) -> Footprint:
    cos, sin = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    turned = points @ np.array([[cos, -sin], [sin, cos]])
    low, high = turned.min(axis=0).tolist(), turned.max(axis=0).tolist()
    u, v = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])
    return Footprint(
        x_mm=cos * u - sin * v,
        y_mm=sin * u + cos * v,
        yaw_deg=turn_deg,
        length_mm=high[0] - low[0],
        width_mm=high[1] - low[1],
    )


def _touch(one: _Part, other: _Part) -> bool:
    return any(
        push_out(piece.polygon(), theirs.polygon()) is not None
        for piece in one.pieces
        for theirs in other.pieces
    )


def _grown(body: Footprint) -> Footprint:
    return replace(body, length_mm=body.length_mm + _NEAR_MM, width_mm=body.width_mm + _NEAR_MM)
