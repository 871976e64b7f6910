"""What there is to see in the twin at one moment."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneBlock:
    """A block as it lies (or hangs between the fingers) in the robot frame.

    Attributes:
        block: Identity of the block, such as `slot 7`.
        kind: Kind in the profile's table of blocks.
        colour: `red`, `green`, `blue`, `yellow` or `natural`.
        x_mm: Robot x of the centre.
        y_mm: Robot y of the centre.
        z_mm: Height of the bottom face.
        yaw_deg: Turn about the vertical; at 0 the block's length lies along
            robot x and its width, across which the fingers close, along robot y.
    """

    block: str
    kind: str
    colour: str
    x_mm: float
    y_mm: float
    z_mm: float
    yaw_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A frozen snapshot of everything a camera can see.

    Attributes:
        revision: Differs whenever anything below differs.
        blocks: Every block.
        joints_deg: The arm's joint angles.
        opening_mm: Opening between the fingers.
        picture: Name of the picture on the screen, None while the screen is dark.
        are_lights_on: Whether the cell's lights are on.
        pixels: What the screen shows, where `cell.pictures` does not have it by its name.
    """

    revision: int
    blocks: tuple[SceneBlock, ...]
    joints_deg: tuple[float, ...]
    opening_mm: float
    picture: str | None
    are_lights_on: bool
    pixels: NDArray[np.uint8] | None = field(default=None, compare=False)
