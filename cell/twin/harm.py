"""What would harm blocks, fingers or glass in life, counted in the twin; tests look at it.

Blocks of wood stand slow pushes by a low finger. They do not stand a finger that comes down on
them, a hit at speed, or being pressed together. The limits:

- *landed*: fingers, or a block in them, come down on a block with more than
  `LANDING_MM` of overlap seen from above; less slides off the bevelled fingertip.
- *rammed*: a block is pushed by a tool faster than `PUSH_LIMIT_MM_S`. A cube of side a that
  slides against a stop tips over from v² = 8/3 (√2 - 1) g a, 600 mm/s at 33 mm (angular
  momentum about its lower edge, moment of inertia 2/3 m a²); the limit is a sixth of that.
- *pinched*: closing fingers press several blocks against each other.
- *jammed*: pushed blocks had no room to move and would be pressed into each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

LANDING_MM: Final = 0.5
PUSH_LIMIT_MM_S: Final = 100.0

HarmKind = Literal["landed", "rammed", "pinched", "jammed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Harm:
    """One such event.

    Attributes:
        kind: What happened.
        block: Identity of the block.
        time_s: When.
        figure: Overlap in mm (landed, jammed) or speed in mm/s (rammed); width in mm (pinched).
    """

    kind: HarmKind
    block: str
    time_s: float
    figure: float
