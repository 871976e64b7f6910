"""Puts together the cell that a command works with, on the twin or on hardware."""

from __future__ import annotations

import logging
import sys
from typing import TYPE_CHECKING

from console.calibrating import with_calibrations
from console.options import Wires
from console.places import cell_folder

if TYPE_CHECKING:
    from calibration.applying import Calibrated
    from cell.clock import Clock
    from cell.links.base import Tap
    from cell.profile import Profile
    from cell.robot_cell import RobotCell
    from cell.store import StorePlan


def clock_for(wires: Wires, *, in_real_time: bool = False) -> Clock:
    """Return the clock of a cell: hardware and people know real time only."""
    from cell.clock import SimulatedClock, SystemClock

    return SystemClock() if in_real_time or wires == "hardware" else SimulatedClock()


def plan_of(script: str) -> StorePlan:
    """Return the store of a script, given by name or path."""
    from console.scripts import load_script
    from sessions.hosting import store_plan

    return store_plan(load_script(script))


def assemble(
    profile: Profile,
    script: str,
    wires: Wires,
    clock: Clock,
    tap: Tap | None = None,
) -> RobotCell:
    """Return a cell with a playground, closed, whose state is kept in its folder.

    What is known of the cell by its calibrations in force goes before its profile; the twin
    is as the profile says, whatever was calibrated.

    Args:
        profile: What the cell's file says.
        script: Script whose store it is, by name or path.
        wires: How its devices are reached.
        clock: The clock of everything in the cell, from `clock_for`.
        tap: Shown every byte on every wire.

    Raises:
        StillHeld: Another process has the cell.
        CellError: What is kept of the cell cannot be used.
        ArchiveError: What is kept of its calibrations cannot be read.
    """
    return assemble_known(with_calibrations(profile), profile, plan_of(script), wires, clock, tap)


def assemble_known(
    known: Calibrated[Profile],
    profile: Profile,
    plan: StorePlan,
    wires: Wires,
    clock: Clock,
    tap: Tap | None = None,
) -> RobotCell:
    """Return a cell of which is known what its calibrations say; see `assemble`.

    Args:
        known: The profile with the calibrations in force.
        profile: What the cell's file says, which the twin is made by.
        plan: The store.
        wires: How its devices are reached.
        clock: The clock of everything in the cell.
        tap: Shown every byte on every wire.
    """
    from cell.assembly import assemble_twin

    if wires == "hardware":
        return _on_hardware(known.profile, plan, clock, tap)
    return assemble_twin(
        known.profile,
        plan,
        seed=0,
        clock=clock,
        state_folder=cell_folder(profile.name),
        tap=tap,
        wires=wires,
        truth=profile,
    )


def _on_hardware(profile: Profile, plan: StorePlan, clock: Clock, tap: Tap | None) -> RobotCell:
    from cell.assembly import assemble_hardware
    from cell.assembly.cameras import hardware_cameras
    from console.hand_screen import HandScreen

    logging.basicConfig(stream=sys.stderr, level=logging.WARNING, format="%(message)s")
    folder = cell_folder(profile.name)
    return assemble_hardware(
        profile,
        plan,
        clock=clock,
        state_folder=folder,
        screen=HandScreen(profile.display, folder),
        cameras=hardware_cameras(profile, clock),
        tap=tap,
    )
