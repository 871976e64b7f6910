"""A whole cell on the twin: real drivers, emulated devices behind their wires."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from cell.assembly.drivers import make_drivers
from cell.assembly.emulated import blocks_in_store, emulate_devices
from cell.assembly.wires import TwinWires, WireLoom
from cell.clock import Clock
from cell.events import EventBus
from cell.kinematics import SixAxisArm
from cell.ledger import Ledger
from cell.links.base import Tap
from cell.lock import CellLock
from cell.motion.guard import Guard
from cell.motion.guarded import GuardedArm
from cell.profile import Profile
from cell.reporting import FaultReporter
from cell.stop import StopToken
from cell.store import StorePlan, with_calibration_object
from cell.twin.behind import Behind
from cell.twin.cameras.camera import TwinCamera
from cell.twin.keeping import WorldFile
from cell.twin.screen import TwinScreen
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
    wires: TwinWires = "memory",
    truth: Profile | None = None,
) -> TwinCell:
    """Put a cell together whose drivers talk to emulators.

    Args:
        profile: The cell's profile.
        plan: The store, filled: each slot has its block.
        seed: Seed of the twin's chance until a session sets its own.
        clock: The clock of everything in the cell.
        state_folder: Where world and ledger are kept; None keeps them in memory.
        tap: Shown every byte on every wire.
        events: Where events go; a bus of its own unless given.
        wires: Whether drivers and emulators are joined in memory or over pseudo-terminals
            that pyserial opens with the profile's parameters. Replies are the same.
        truth: How the cell really is, where the profile, which is all that the program knows,
            does not tell the truth: places of cameras, screen and store, lenses, light.

    Raises:
        StillHeld: Another process has this cell.
        CellError: What is kept in the folder cannot be used, or there are no
            pseudo-terminals.
    """
    events = events or EventBus(clock)
    stop = StopToken()
    kinematics = SixAxisArm.from_profile(profile.arm)
    real = truth or profile
    plan = with_calibration_object(plan, profile.store)
    kept = ExitStack()
    with ExitStack() as taken:
        if state_folder is not None:
            taken.callback(CellLock(state_folder).release)
        world = World(real, kinematics, clock, blocks_in_store(real, plan), seed=seed)
        if state_folder is not None:
            _keep(world, WorldFile(state_folder / "world.json"), clock)
        devices = emulate_devices(real, world, kinematics, seed=seed)
        if wires == "pty":
            loom = WireLoom.over_pty(profile, devices.wires, clock, tap, stop)
        else:
            loom = WireLoom.in_memory(devices.wires, clock, tap)
        taken.callback(loom.close)
        ledger = Ledger(None if state_folder is None else state_folder / "ledger.sqlite")
        taken.callback(ledger.close)
        drivers = make_drivers(
            profile,
            loom.links,
            clock,
            stop,
            on_warning=_unheard,
            on_repeat=FaultReporter(events).repeated,
        )
        cameras = _cameras(real, plan, world, kinematics, clock)
        for name, camera in cameras.items():
            if profile.cameras[name].settings != real.cameras[name].settings:
                camera.configure(profile.cameras[name].settings)
        cell = TwinCell(
            profile,
            arm=GuardedArm(drivers.arm, Guard.from_profile(profile), profile.arm, events, stop),
            gripper=drivers.gripper,
            display=drivers.display,
            screen=TwinScreen(world),
            cameras=cameras,
            ledger=ledger,
            plan=plan,
            events=events,
            clock=clock,
            stop=stop,
            release=kept.close,
        )
        cell.world = world
        cell.behind = Behind(
            world, devices.controller, devices.module, devices.television, cameras, devices.wires
        )
        kept.callback(taken.pop_all().close)
    return cell


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
