"""How the doctor meets a cell: on the twin, over pseudo-terminals, or over the profile's ports.

Drivers are not needed for that, and so nothing comes up: the doctor asks over the lines.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from cell.assembly.twin import assemble_twin
from cell.assembly.wires import TwinWires, WireLoom
from cell.clock import Clock
from cell.devices.camera import Camera
from cell.doctor.patient import OpenLine, Patient
from cell.errors import CellError, LedgerError
from cell.ledger import Ledger
from cell.links.base import Link
from cell.links.memory import MemoryLink
from cell.lock import CellLock
from cell.profile import Profile
from cell.stop import StopToken
from cell.store import StorePlan
from cell.twin.keeping import WorldFile
from cell.twin_cell import TwinCell

_WORLD = "world.json"


def patient_of_twin(
    cell: TwinCell, *, lattice: tuple[int, int] = (12, 12), views: tuple[str, ...] = ()
) -> Patient:
    """Return a twin, open or not, as a patient; its emulators are reached in memory.

    Args:
        cell: The twin.
        lattice: Columns and rows of the widest world that is played.
        views: Names of the cameras that the script's views need.
    """
    wires = cell.behind.wires
    lines = {name: partial(MemoryLink, name, wire, cell.clock) for name, wire in wires.items()}
    return Patient.of_cell(cell, lines, lattice=lattice, views=views)


@contextmanager
def meet_twin(
    profile: Profile,
    plan: StorePlan,
    *,
    clock: Clock,
    state_folder: Path | None = None,
    wires: TwinWires = "memory",
    lattice: tuple[int, int] = (12, 12),
    views: tuple[str, ...] = (),
    truth: Profile | None = None,
) -> Iterator[Patient]:
    """Put a twin together for the doctor, and away afterwards.

    It begins with the world that is kept in the folder, and writes nothing there. Where that
    world cannot be used, which is a finding of its own, it begins with a clean one.

    Args:
        profile: What is known of the cell.
        plan: Its store.
        clock: The clock of everything in it.
        state_folder: Where world and ledger are kept.
        wires: How drivers and emulators are joined.
        lattice: Columns and rows of the widest world that is played.
        views: Names of the cameras that the script's views need.
        truth: How the cell really is; as it is known unless given.

    Raises:
        StillHeld: Another process has the cell.
        CellError: The profile's figures cannot be used, or there are no pseudo-terminals.
    """
    folder = state_folder if state_folder is not None and state_folder.is_dir() else None
    with ExitStack() as stack:
        if folder is not None:
            stack.callback(CellLock(folder).release)
        copied = None
        if folder is not None and _has_sound_world(profile, plan, clock, folder):
            copied = Path(stack.enter_context(TemporaryDirectory(prefix="robocell-doctor-")))
            shutil.copy(folder / _WORLD, copied / _WORLD)
        cell = assemble_twin(profile, plan, seed=0, clock=clock, state_folder=copied, truth=truth)
        stack.callback(cell.dispose)
        patient = patient_of_twin(cell, lattice=lattice, views=views)
        if folder is not None:
            ledger = _kept_ledger(folder)
            if ledger is not None:
                stack.callback(ledger.close)
            patient = replace(patient, ledger=ledger)
        if wires == "pty":
            loom = WireLoom.over_pty(profile, cell.behind.wires, clock, None, StopToken())
            stack.callback(loom.close)
            patient = replace(patient, lines=borrowed_lines(loom))
        yield patient


@contextmanager
def meet_hardware(
    profile: Profile,
    plan: StorePlan,
    *,
    clock: Clock,
    cameras: Mapping[str, Camera],
    state_folder: Path | None = None,
    lattice: tuple[int, int] = (12, 12),
    views: tuple[str, ...] = (),
) -> Iterator[Patient]:
    """Make a cell's ports and cameras ready for the doctor; no port is opened before its turn."""
    loom = WireLoom.over_ports(profile, clock, None, StopToken())
    ledger = _kept_ledger(state_folder)
    try:
        yield Patient(
            profile=profile,
            plan=plan,
            clock=clock,
            lines=borrowed_lines(loom),
            cameras=cameras,
            ledger=ledger,
            lattice=lattice,
            views=views,
            riding_cameras=riding_cameras(profile),
        )
    finally:
        loom.close()
        if ledger is not None:
            ledger.close()


def riding_cameras(profile: Profile) -> tuple[str, ...]:
    """Return the names of the cameras that hang on the arm."""
    placed = profile.twin.cameras
    return tuple(name for name, camera in placed.items() if camera.mount == "flange")


def borrowed_lines(loom: WireLoom) -> dict[str, OpenLine]:
    """Return the lines of a loom as the doctor opens them; the loom closes them in the end."""
    return {name: partial(_Borrowed, link) for name, link in loom.links.items()}


def _has_sound_world(profile: Profile, plan: StorePlan, clock: Clock, folder: Path) -> bool:
    """Return whether a folder keeps a world that a twin can begin with."""
    file = WorldFile(folder / _WORLD)
    if not file.exists():
        return False
    cell = assemble_twin(profile, plan, seed=0, clock=clock)
    try:
        file.load_into(cell.world)
    except CellError:
        return False
    finally:
        cell.dispose()
    return True


def _kept_ledger(state_folder: Path | None) -> Ledger | None:
    """Return the ledger of a folder; none is made where there is none, which means no block out."""
    path = None if state_folder is None else state_folder / "ledger.sqlite"
    try:
        return Ledger(path if path is not None and path.is_file() else None)
    except LedgerError:
        return None


class _Borrowed:
    """A link that its user does not close."""

    def __init__(self, link: Link) -> None:
        self._link = link

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._link.name

    def write(self, data: bytes) -> None:
        """Send all bytes."""
        self._link.write(data)

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, waiting for at least one byte."""
        return self._link.read(timeout_s)

    def close(self) -> None:
        """Leave the link open: whoever lent it closes it."""
