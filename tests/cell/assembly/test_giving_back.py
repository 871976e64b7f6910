"""A cell that cannot be put together holds nothing of what it had taken."""

from __future__ import annotations

import gc
from collections.abc import Callable
from pathlib import Path

import pytest

from cell.assembly import assemble_hardware, assemble_twin
from cell.clock import SimulatedClock
from cell.errors import CellError
from cell.lock import CellLock
from cell.profile import load_profile
from cell.robot_cell import RobotCell
from cell.store import StorePlan
from tests.cell.assembly.test_wires import BareScreen

PROFILE = load_profile("mash")
PLAN = StorePlan(())
Assemble = Callable[[Path], RobotCell]


def _twin(folder: Path) -> RobotCell:
    return assemble_twin(PROFILE, PLAN, seed=1, clock=SimulatedClock(), state_folder=folder)


def _twin_over_pty(folder: Path) -> RobotCell:
    return assemble_twin(
        PROFILE, PLAN, seed=1, clock=SimulatedClock(), state_folder=folder, wires="pty"
    )


def _hardware(folder: Path) -> RobotCell:
    return assemble_hardware(
        PROFILE,
        PLAN,
        clock=SimulatedClock(),
        state_folder=folder,
        screen=BareScreen(),
        cameras={},
    )


@pytest.mark.parametrize(
    ("assemble", "broken"),
    [
        (_twin, "world.json"),
        (_twin, "ledger.sqlite"),
        (_twin_over_pty, "ledger.sqlite"),
        (_hardware, "ledger.sqlite"),
    ],
)
@pytest.mark.filterwarnings("error::ResourceWarning")
def test_what_was_taken_is_given_back_when_a_kept_file_is_broken(
    assemble: Assemble, broken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ports, cell = tmp_path / "ports", tmp_path / "cell"
    ports.mkdir()
    cell.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(ports))
    (cell / broken).write_text("no such thing" * 100)
    with pytest.raises(CellError, match=broken):
        assemble(cell)
    gc.collect()
    assert list(ports.iterdir()) == []
    CellLock(cell).release()
    (cell / broken).unlink()
    assemble(cell).dispose()


@pytest.mark.parametrize("assemble", [_twin, _hardware])
def test_a_disposed_cell_gives_its_lock_back(assemble: Assemble, tmp_path: Path) -> None:
    cell = assemble(tmp_path)
    with pytest.raises(CellError, match="in use"):
        CellLock(tmp_path)
    cell.dispose()
    CellLock(tmp_path).release()
