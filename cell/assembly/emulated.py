"""The emulated devices of a cell, each behind a wire that can fail, all in one world."""

from __future__ import annotations

from dataclasses import dataclass

from cell.kinematics import SixAxisArm
from cell.profile import Profile
from cell.store import StorePlan, place_of_slot
from cell.twin.blocks import TwinBlock
from cell.twin.emulators.melfa_r3.controller import MelfaController
from cell.twin.emulators.melfa_r3.settings import ControllerSettings
from cell.twin.emulators.schunk_smp.module import SchunkModule
from cell.twin.emulators.schunk_smp.settings import SchunkModuleSettings
from cell.twin.emulators.sharp_aquos.settings import SharpTelevisionSettings
from cell.twin.emulators.sharp_aquos.television import SharpTelevision
from cell.twin.fingers import TwinFingers
from cell.twin.wire_faults import FaultyEmulator
from cell.twin.world import World


@dataclass(frozen=True, slots=True, kw_only=True)
class EmulatedDevices:
    """The emulators of a cell's serial devices.

    Attributes:
        controller: The arm's controller.
        module: The gripper's electronics.
        television: The set under the playground.
        wires: The wire of each by name: `arm`, `gripper`, `display`.
    """

    controller: MelfaController
    module: SchunkModule
    television: SharpTelevision
    wires: dict[str, FaultyEmulator]


def emulate_devices(
    profile: Profile, world: World, kinematics: SixAxisArm, *, seed: int
) -> EmulatedDevices:
    """Return the emulated devices of a cell, acting on a world.

    Args:
        profile: The cell's profile.
        world: What the devices act on.
        kinematics: The arm's kinematics.
        seed: Seed of what is random when a wire fails.
    """
    controller = MelfaController(
        world,
        kinematics,
        ControllerSettings.from_profile(profile.arm),
        outputs_on=[bit for bit, is_on in world.outputs.items() if is_on],
    )
    module = SchunkModule(
        TwinFingers(world),
        SchunkModuleSettings.from_profile(profile.gripper),
        is_referenced=world.is_gripper_referenced,
    )
    world.ask_reference(lambda: module.is_referenced)
    television = SharpTelevision(world, SharpTelevisionSettings.from_profile(profile.display))
    return EmulatedDevices(
        controller=controller,
        module=module,
        television=television,
        wires={
            "arm": FaultyEmulator(controller, seed=seed),
            "gripper": FaultyEmulator(module, seed=seed),
            "display": FaultyEmulator(television, seed=seed),
        },
    )


def blocks_in_store(profile: Profile, plan: StorePlan) -> list[TwinBlock]:
    """Return the twin's blocks, each exactly in its slot."""
    blocks = []
    for slot in plan.slots:
        place = place_of_slot(slot, profile.store)
        blocks.append(
            TwinBlock(
                block=slot.block,
                kind=slot.kind,
                colour=slot.colour,
                x_mm=place.x_mm,
                y_mm=place.y_mm,
                z_mm=profile.heights.surface_mm,
                yaw_deg=place.yaw_deg,
            )
        )
    return blocks
