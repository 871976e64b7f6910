"""Puts together the cell that a command works with, on the twin or on hardware."""

from __future__ import annotations

import logging
import sys
from typing import TYPE_CHECKING

from console.options import Wires
from console.places import cell_folder

if TYPE_CHECKING:
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

    Args:
        profile: The cell's profile.
        script: Script whose store it is, by name or path.
        wires: How its devices are reached.
        clock: The clock of everything in the cell, from `clock_for`.
        tap: Shown every byte on every wire.

    Raises:
        StillHeld: Another process has the cell.
        CellError: What is kept of the cell cannot be used.
    """
    from cell.assembly import assemble_twin

    plan = plan_of(script)
    if wires == "hardware":
        return _on_hardware(profile, plan, clock, tap)
    folder = cell_folder(profile.name)
    return assemble_twin(
        profile, plan, seed=0, clock=clock, state_folder=folder, tap=tap, wires=wires
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
