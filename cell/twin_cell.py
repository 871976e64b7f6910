"""A whole cell whose hardware is the twin: it can be copied, seeded and repeated."""

from __future__ import annotations

from cell.robot_cell import RobotCell
from cell.twin.behind import Behind
from cell.twin.keeping import dump_world, load_world
from cell.twin.world import World


class TwinCell(RobotCell):
    """A `RobotCell` on the twin.

    Attributes:
        world: The twin's truth; only tests may look into it.
        behind: The emulated devices and their wires, to press buttons and inject faults.
    """

    world: World
    behind: Behind

    def begin_session(self, seed: int) -> None:
        """Seed the twin's chance and count frames anew, so that a session repeats."""
        super().begin_session(seed)
        self.world.reseed(seed)

    def world_json(self) -> str:
        """Return the twin's world as text, for a replay to begin with."""
        return dump_world(self.world, self.clock.now_s())

    def restore_world(self, text: str) -> None:
        """Begin with the world of a recorded session.

        Raises:
            CellError: The text holds no world of the twin.
        """
        load_world(self.world, text, "the recording")
