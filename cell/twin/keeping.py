"""The twin's world as text, and a file that keeps it when the process dies.

Hardware stays where it is when a program is killed; so does the twin. What is
kept: every block, what the fingers hold, the arm's joints at the last change,
the controller's outputs, and whether the gripper knows its zero.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from pathlib import Path

from pydantic import TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from cell.errors import CellError, StateError
from cell.twin.blocks import TwinBlock
from cell.twin.bodies import JointTuple
from cell.twin.hand import Held
from cell.twin.world import World

_FORMAT = 1
_START_CLEAN = "move it away to start with a clean world"


@dataclass(frozen=True, kw_only=True)
class KeptWorld:
    """The fields of a kept world."""

    format: int
    blocks: tuple[TwinBlock, ...]
    joints_deg: JointTuple
    opening_mm: float
    held: Held | None
    outputs: dict[int, bool]
    is_gripper_referenced: bool


_ADAPTER: TypeAdapter[KeptWorld] = TypeAdapter(KeptWorld)


def dump_world(world: World, now_s: float) -> str:
    """Return the world as JSON text."""
    return json.dumps(
        {
            "format": _FORMAT,
            "blocks": [asdict(block) for block in world.blocks.all()],
            "joints_deg": world.joints_deg(now_s),
            "opening_mm": world.opening_mm(now_s),
            "held": None if world.held is None else asdict(world.held),
            "outputs": world.outputs,
            "is_gripper_referenced": world.is_gripper_referenced,
        }
    )


def load_world(world: World, text: str, source: str) -> None:
    """Put a world into the state of a JSON text.

    Raises:
        CellError: The text is not a kept world of this format.
    """
    try:
        kept = _ADAPTER.validate_json(text)
    except ValidationError as error:
        raise CellError(
            f"{source} does not hold a world of the twin; remove it to start with a clean one"
        ) from error
    if kept.format != _FORMAT:
        raise CellError(f"{source} has format {kept.format}; this version reads {_FORMAT}")
    world.restore(
        blocks=kept.blocks,
        joints_deg=kept.joints_deg,
        opening_mm=kept.opening_mm,
        held=kept.held,
        outputs=kept.outputs,
        is_gripper_referenced=kept.is_gripper_referenced,
    )


class WorldFile:
    """Keeps a world in a file, written anew as a whole at each change."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def exists(self) -> bool:
        """Return whether there is a kept world, or something else under its name."""
        return self._path.exists()

    def load_into(self, world: World) -> None:
        """Put the world into the kept state.

        Raises:
            StateError: The file cannot be read.
            CellError: It holds no world.
        """
        try:
            text = self._path.read_text("utf-8")
        except UnicodeDecodeError as error:
            raise StateError(
                f"{self._path} is no text (byte {error.start}); {_START_CLEAN}"
            ) from error
        except OSError as error:
            raise StateError(
                f"the twin's world cannot be read from {self._path} ({error.strerror or error}); "
                f"give it to the user who runs the cell, or {_START_CLEAN}"
            ) from error
        load_world(world, text, str(self._path))

    def save(self, world: World, now_s: float) -> None:
        """Write the world; a reader finds the old text or the new one, never a part.

        Raises:
            StateError: It cannot be written; the old one is still there.
        """
        fresh = self._path.with_suffix(".new")
        try:
            fresh.write_text(dump_world(world, now_s), "utf-8")
            os.replace(fresh, self._path)
        except OSError as error:
            raise StateError(
                f"the twin's world cannot be written to {self._path} ({error.strerror or error}); "
                f"free space on its disk, give {self._path.parent} to the user who runs the cell, "
                "or move away a folder that has its name"
            ) from error
