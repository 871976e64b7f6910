"""A whole cell on the twin: real drivers, emulated devices behind their wires."""

from __future__ import annotations

from pathlib import Path

from cell.clock import Clock
from cell.drivers.melfa_r3.driver import MelfaArm
from cell.drivers.melfa_r3.settings import ArmSettings
from cell.drivers.schunk_smp.driver import SchunkGripper
from cell.drivers.schunk_smp.settings import SchunkSettings
from cell.drivers.sharp_aquos.driver import SharpDisplay
from cell.drivers.sharp_aquos.settings import SharpSettings
from cell.events import EventBus
from cell.kinematics import SixAxisArm
from cell.ledger import Ledger
from cell.links.base import Emulator, Link, Tap
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.lock import CellLock
from cell.motion.guard import Guard
from cell.motion.guarded import GuardedArm
from cell.profile import Profile
from cell.stop import StopToken
from cell.store import StorePlan, place_of_slot
from cell.twin.behind import Behind
from cell.twin.blocks import TwinBlock
from cell.twin.cameras.camera import TwinCamera
from cell.twin.emulators.melfa_r3.controller import MelfaController
from cell.twin.emulators.melfa_r3.settings import ControllerSettings
from cell.twin.emulators.schunk_smp.module import SchunkModule
from cell.twin.emulators.schunk_smp.settings import SchunkModuleSettings
from cell.twin.emulators.sharp_aquos.settings import SharpTelevisionSettings
from cell.twin.emulators.sharp_aquos.television import SharpTelevision
from cell.twin.fingers import TwinFingers
from cell.twin.keeping import WorldFile
from cell.twin.screen import TwinScreen
from cell.twin.wire_faults import FaultyEmulator
from cell.twin.world import World
from cell.twin_cell import TwinCell

_CAMERA_SEED = 1


def assemble_twin(
    profile: Profile,
    plan: StorePlan,
    *,
    seed: int,
    clock: Clock,
    state_folder: Path | None = None,
    tap: Tap | None = None,
    events: EventBus | None = None,
) -> TwinCell:
    """Put a cell together whose drivers talk to emulators in memory.

    Args:
        profile: The cell's profile.
        plan: The store, filled: each slot has its block.
        seed: Seed of the twin's chance until a session sets its own.
        clock: The clock of everything in the cell.
        state_folder: Where world and ledger are kept; None keeps them in memory.
        tap: Shown every byte on every wire.
        events: Where events go; a bus of its own unless given.

    Raises:
        StillHeld: Another process has this cell.
        CellError: What is kept in the folder cannot be used.
    """
    events = events or EventBus(clock)
    stop = StopToken()
    kinematics = SixAxisArm.from_profile(profile.arm)
    lock = CellLock(state_folder) if state_folder is not None else None
    world = World(profile, kinematics, clock, blocks_in_store(profile, plan), seed=seed)
    if state_folder is not None:
        _keep(world, WorldFile(state_folder / "world.json"), clock)

    wires: dict[str, FaultyEmulator] = {}

    def wire(name: str, emulator: Emulator) -> Link:
        wires[name] = FaultyEmulator(emulator, seed=seed)
        link: Link = MemoryLink(name, wires[name], clock)
        return link if tap is None else CapturedLink(link, tap)

    controller = MelfaController(world, kinematics, ControllerSettings.from_profile(profile.arm))
    module = SchunkModule(
        TwinFingers(world),
        SchunkModuleSettings.from_profile(profile.gripper),
        is_referenced=world.is_gripper_referenced,
    )
    world.ask_reference(lambda: module.is_referenced)
    television = SharpTelevision(world, SharpTelevisionSettings.from_profile(profile.display))
    arm = MelfaArm(
        wire("arm", controller), clock, ArmSettings.from_profile(profile.arm), on_warning=_unheard
    )
    gripper = SchunkGripper(
        wire("gripper", module),
        clock,
        SchunkSettings.from_profile(profile.gripper),
        token=stop,
        on_warning=_unheard,
    )
    display = SharpDisplay(
        wire("display", television),
        clock,
        SharpSettings.from_profile(profile.display),
        on_warning=_unheard,
    )
    cameras = _cameras(profile, plan, world, kinematics, clock)
    cell = TwinCell(
        profile,
        arm=GuardedArm(arm, Guard.from_profile(profile), profile.arm, events, stop),
        gripper=gripper,
        display=display,
        screen=TwinScreen(world),
        cameras=cameras,
        ledger=Ledger(None if state_folder is None else state_folder / "ledger.sqlite"),
        plan=plan,
        events=events,
        clock=clock,
        stop=stop,
        release=_nothing if lock is None else lock.release,
    )
    cell.world = world
    cell.behind = Behind(world, controller, module, television, cameras, wires)
    return cell


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


def _cameras(
    profile: Profile, plan: StorePlan, world: World, kinematics: SixAxisArm, clock: Clock
) -> dict[str, TwinCamera]:
    """Return the twin's cameras; their noise is their own, whatever session looks."""
    return {
        name: TwinCamera(
            name,
            profile,
            scene=world.scene,
            arm=kinematics,
            clock=clock,
            seed=_CAMERA_SEED,
            slots=plan.slots,
        )
        for name in profile.cameras
    }


def _keep(world: World, file: WorldFile, clock: Clock) -> None:
    """Begin with the world that was kept, if any, and keep it from now on."""
    if file.exists():
        file.load_into(world)
    world.on_change(lambda: file.save(world, clock.now_s()))


def _unheard(warning: str) -> None:
    """Take a driver's warning that it was never tried on hardware: here is none."""


def _nothing() -> None:
    """Release nothing: a world in memory is locked by nobody."""
