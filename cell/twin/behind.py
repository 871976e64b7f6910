"""What stands behind the wires of a twin: for tests, demonstrations and injected faults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cell.twin.cameras.camera import TwinCamera
from cell.twin.emulators.melfa_r3.controller import MelfaController
from cell.twin.emulators.schunk_smp.module import SchunkModule
from cell.twin.emulators.sharp_aquos.television import SharpTelevision
from cell.twin.wire_faults import FaultyEmulator
from cell.twin.world import World


@dataclass(frozen=True, slots=True)
class Behind:
    """The emulated devices of a twin, their wires, and its truth.

    Attributes:
        world: The twin's truth; only tests may look into it.
        controller: The arm's controller, whose buttons can be pressed.
        module: The gripper's electronics.
        television: The set under the playground.
        cameras: The cameras by name.
        wires: The wire of each serial device by name: `arm`, `gripper`, `display`.
    """

    world: World
    controller: MelfaController
    module: SchunkModule
    television: SharpTelevision
    cameras: Mapping[str, TwinCamera]
    wires: Mapping[str, FaultyEmulator]
