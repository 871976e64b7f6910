"""How the doctor meets a cell on the twin."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from cell.doctor.patient import OpenLine, Patient
from cell.links.memory import MemoryLink
from cell.twin_cell import TwinCell


def patient_of_twin(
    cell: TwinCell, *, lattice: tuple[int, int] = (12, 12), views: tuple[str, ...] = ()
) -> Patient:
    """Return a twin, open or not, as a patient; its emulators are reached in memory.

    Args:
        cell: The twin.
        lattice: Columns and rows of the widest world that is played.
        views: Names of the cameras that the script's views need.
    """
    return Patient.of_cell(cell, lines_of_twin(cell), lattice=lattice, views=views)


def lines_of_twin(cell: TwinCell) -> Mapping[str, OpenLine]:
    """Return how to open the lines of a twin's emulated devices."""
    wires = cell.behind.wires
    return {name: partial(MemoryLink, name, wire, cell.clock) for name, wire in wires.items()}
