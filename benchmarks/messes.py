"""Random messes: blocks as a careless person leaves them on the playground.

Single ones at any turn, and groups that touch: rows, stacks of bridges side by side, squares
of four, L shapes, heaps pushed together at odd angles. Nothing overlaps.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

from cell.contact import Footprint, push_out
from cell.profile import BlockProfile, Profile
from cell.store import StorePlan, StoreSlot, TablePlace

X_MM = (300.0, 690.0)
Y_MM = (-345.0, 285.0)
_TRIES = 400


def store() -> StorePlan:
    """Return the store of the reference."""
    rows = (
        (1, "cube", "natural", 55, 50), (2, "cube", "natural", 165, 50),
        (3, "cube", "natural", 275, 50), (4, "cube", "natural", 385, 50),
        (5, "cube", "blue", 495, 50), (6, "cube", "blue", 55, 150),
        (7, "cube", "red", 165, 150), (8, "cube", "red", 275, 150),
        (9, "cube", "green", 385, 150), (10, "cube", "green", 495, 150),
        (11, "cube", "yellow", 55, 250), (12, "cube", "yellow", 165, 250),
        (13, "bridge", "red", 275, 250), (14, "bridge", "green", 495, 250),
        (15, "cylinder", "blue", 55, 350), (16, "cylinder", "green", 165, 350),
        (17, "cylinder", "yellow", 275, 350), (18, "cylinder", "red", 495, 350),
    )  # fmt: skip
    return StorePlan(
        tuple(
            StoreSlot(number=number, kind=kind, colour=colour, x_mm=x, y_mm=y)
            for number, kind, colour, x, y in rows
        )
    )


def mess(seed: int, profile: Profile, plan: StorePlan, most: int = 12) -> dict[int, TablePlace]:
    """Return where the blocks of some slots were left, by slot number.

    Args:
        seed: Decides everything.
        profile: Sizes of the blocks.
        plan: The blocks that there are.
        most: Most blocks; at least one is out.
    """
    chance = random.Random(seed)
    waiting = chance.sample(list(plan.slots), chance.randint(1, most))
    lying: list[Footprint] = []
    places: dict[int, TablePlace] = {}
    while waiting:
        group = [waiting.pop() for _ in range(min(len(waiting), chance.choice((1, 1, 2, 3, 4, 5))))]
        for slot, body in zip(group, _group(chance, group, profile, lying), strict=True):
            lying.append(body)
            places[slot.number] = TablePlace(x_mm=body.x_mm, y_mm=body.y_mm, yaw_deg=body.yaw_deg)
    return places


def _group(
    chance: random.Random, slots: Sequence[StoreSlot], profile: Profile, lying: Sequence[Footprint]
) -> list[Footprint]:
    shape = chance.choice((_row, _stack, _square, _heap, _heap))
    for _ in range(_TRIES):
        x_mm, y_mm, yaw_deg = chance.uniform(*X_MM), chance.uniform(*Y_MM), chance.uniform(-90, 90)
        bodies = shape(chance, [profile.blocks[slot.kind] for slot in slots])
        bodies = [_placed(body, x_mm, y_mm, yaw_deg) for body in bodies]
        if all(_is_inside(body) for body in bodies) and not _overlap(bodies, lying):
            return bodies
    raise ValueError("there is no room left for the mess")


def _row(chance: random.Random, kinds: Sequence[BlockProfile]) -> list[Footprint]:
    """Blocks end to end, or with small gaps."""
    gap_mm = chance.choice((0.05, 0.05, 3.0))
    bodies, x_mm = [], 0.0
    for kind in kinds:
        bodies.append(_body(kind, x_mm + 0.5 * kind.length_mm, 0.0, 0.0))
        x_mm += kind.length_mm + gap_mm
    return bodies


def _stack(chance: random.Random, kinds: Sequence[BlockProfile]) -> list[Footprint]:
    """Blocks side by side, some shifted along each other."""
    shift_mm = chance.choice((0.0, 0.0, 12.0))
    bodies, y_mm = [], 0.0
    for index, kind in enumerate(kinds):
        bodies.append(_body(kind, index * shift_mm, y_mm + 0.5 * kind.width_mm, 0.0))
        y_mm += kind.width_mm + 0.05
    return bodies


def _square(chance: random.Random, kinds: Sequence[BlockProfile]) -> list[Footprint]:
    """Two columns side by side; three blocks make an L."""
    bodies: list[Footprint] = []
    ends = [0.0, 0.0]
    for index, kind in enumerate(kinds):
        column = index % 2
        bodies.append(
            _body(kind, ends[column] + 0.5 * kind.length_mm, column * (kind.width_mm + 0.05), 0.0)
        )
        ends[column] += kind.length_mm + 0.05
    return bodies


def _heap(chance: random.Random, kinds: Sequence[BlockProfile]) -> list[Footprint]:
    """Blocks at odd angles, each slid against the others until they touch."""
    bodies = [_body(kinds[0], 0.0, 0.0, chance.uniform(-90, 90))]
    for kind in kinds[1:]:
        direction, yaw_deg = chance.uniform(0, 2 * math.pi), chance.uniform(-90, 90)
        near, far = 0.0, 400.0
        for _ in range(40):
            middle = 0.5 * (near + far)
            body = _body(kind, middle * math.cos(direction), middle * math.sin(direction), yaw_deg)
            near, far = (middle, far) if _overlap([body], bodies) else (near, middle)
        far += 0.05
        bodies.append(_body(kind, far * math.cos(direction), far * math.sin(direction), yaw_deg))
    return bodies


def _body(kind: BlockProfile, x_mm: float, y_mm: float, yaw_deg: float) -> Footprint:
    return Footprint(
        x_mm=x_mm, y_mm=y_mm, yaw_deg=yaw_deg, length_mm=kind.length_mm, width_mm=kind.width_mm,
        is_round=kind.shape == "cylinder",
    )  # fmt: skip


def _placed(body: Footprint, x_mm: float, y_mm: float, yaw_deg: float) -> Footprint:
    cos, sin = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
    return Footprint(
        x_mm=x_mm + cos * body.x_mm - sin * body.y_mm,
        y_mm=y_mm + sin * body.x_mm + cos * body.y_mm,
        yaw_deg=(body.yaw_deg + yaw_deg + 90.0) % 180.0 - 90.0,
        length_mm=body.length_mm,
        width_mm=body.width_mm,
        is_round=body.is_round,
    )


def _is_inside(body: Footprint) -> bool:
    in_area = all(
        X_MM[0] - 10 <= x <= X_MM[1] + 10 and Y_MM[0] - 10 <= y <= Y_MM[1] + 10
        for x, y in body.polygon()
    )
    # The arm cannot bring its fingers down close to its own base.
    return in_area and not (body.x_mm < 390.0 and abs(body.y_mm) < 190.0)


def _overlap(some: Sequence[Footprint], others: Sequence[Footprint]) -> bool:
    return any(push_out(a.polygon(), b.polygon()) is not None for a in some for b in others)
