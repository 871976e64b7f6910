"""A whole cell on hardware: the ports of the profile, its cameras, its screen."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path

from cell.assembly.cameras import hardware_cameras
from cell.assembly.drivers import make_drivers
from cell.assembly.wires import WireLoom
from cell.clock import Clock
from cell.devices.camera import Camera
from cell.devices.display import Screen
from cell.events import EventBus
from cell.ledger import Ledger
from cell.links.base import Tap
from cell.lock import CellLock
from cell.motion.guard import Guard
from cell.motion.guarded import GuardedArm
from cell.profile import Profile
from cell.reporting import FaultReporter
from cell.robot_cell import RobotCell
from cell.stop import StopToken
from cell.store import StorePlan, with_calibration_object

_log = logging.getLogger(__name__)


def assemble_hardware(
    profile: Profile,
    plan: StorePlan,
    *,
    clock: Clock,
    state_folder: Path,
    screen: Screen,
    cameras: Mapping[str, Camera] | None = None,
    tap: Tap | None = None,
    events: EventBus | None = None,
) -> RobotCell:
    """Put a cell together whose drivers use the ports of the profile.

    No port is opened here: a device whose port is missing says so when it is first used, by
    its name, while the others can be used. Drivers that were never tried on hardware say
    that in the log when they open.

    Args:
        profile: The cell's profile.
        plan: The store, filled: each slot has its block.
        clock: Real time.
        state_folder: Where ledger and lock are kept.
        screen: What puts pictures on the display.
        cameras: The cameras by name; those of the profile unless given.
        tap: Shown every byte on every wire.
        events: Where events go; a bus of its own unless given.

    Raises:
        StillHeld: Another process has this cell.
        CellError: What is kept in the folder cannot be used.
    """
    events = events or EventBus(clock)
    stop = StopToken()
    kept = ExitStack()
    with ExitStack() as taken:
        taken.callback(CellLock(state_folder).release)
        loom = WireLoom.over_ports(profile, clock, tap, stop)
        taken.callback(loom.close)
        ledger = Ledger(state_folder / "ledger.sqlite")
        taken.callback(ledger.close)
        drivers = make_drivers(
            profile,
            loom.links,
            clock,
            stop,
            on_warning=_warner(),
            on_repeat=FaultReporter(events).repeated,
        )
        cell = RobotCell(
            profile,
            arm=GuardedArm(drivers.arm, Guard.from_profile(profile), profile.arm, events, stop),
            gripper=drivers.gripper,
            display=drivers.display,
            screen=screen,
            cameras=hardware_cameras(profile, clock) if cameras is None else cameras,
            ledger=ledger,
            plan=with_calibration_object(plan, profile.store),
            events=events,
            clock=clock,
            stop=stop,
            release=kept.close,
        )
        kept.callback(taken.pop_all().close)
    return cell


def _warner() -> Callable[[str], None]:
    """Return what logs a driver's warning, once, however often it opens."""
    told: set[str] = set()

    def warn(text: str) -> None:
        if text not in told:
            told.add(text)
            _log.warning("%s", text)

    return warn
