"""What a cleaning by picture came to, for people and programs."""

from __future__ import annotations

from dataclasses import dataclass

from cell.cleaning.grips import Grip
from cell.cleaning.look import Look
from cell.cleaning.pushes import Push
from cell.cleaning.sight import LyingBlock, StrangeThing


@dataclass(frozen=True, slots=True, kw_only=True)
class SeenOne:
    """Something seen and what is to be done about it.

    Attributes:
        block: The block, None when it is no block one could tell.
        strange: What it is else.
        turn: When its turn is, counted from 1; None when it is not gripped.
        grip: How it is gripped.
        why_not: Why it is not, empty when it is.
    """

    block: LyingBlock | None = None
    strange: StrangeThing | None = None
    turn: int | None = None
    grip: Grip | None = None
    why_not: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class CleaningPlan:
    """What one look told and what would be done next.

    Attributes:
        seen: Everything seen, what is gripped first.
        push: The push that makes room, where nothing can be gripped.
        view: The look itself.
    """

    seen: tuple[SeenOne, ...]
    push: Push | None
    view: Look


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureCleaning:
    """What a cleaning by picture came to.

    Attributes:
        home: Slot numbers of the blocks brought home.
        left: What was seen and left where it is, a sentence each.
        pushes: How often blocks were pushed apart.
        looks: How often the camera looked.
        plan: What the first look told; None where nobody looked.
        last: The last look, which proves what the table is like.
    """

    home: tuple[int, ...]
    left: tuple[str, ...]
    pushes: int = 0
    looks: int = 0
    plan: CleaningPlan | None = None
    last: Look | None = None
