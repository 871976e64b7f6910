"""What is calibrated is what `cell profile show --calibrated` shows and the doctor looks at."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from calibration import catalogue
from cell.doctor.patient import Patient
from cell.profile import Profile, load_profile
from console import doctor
from console.options import Wires
from tests.calibration.sample_procedures import ENTRIES
from tests.console.hands import Cell, caller


@pytest.fixture
def cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Cell:
    monkeypatch.setattr(catalogue, "CATALOGUE", ENTRIES)
    monkeypatch.setattr(sys.stdin, "isatty", lambda: False, raising=False)
    return caller(tmp_path, monkeypatch, capsys)


def test_a_calibrated_value_is_shown_with_the_calibration_that_set_it(cell: Cell) -> None:
    plain = cell("profile", "show").out
    assert cell("profile", "show", "--calibrated").out == plain
    cell("calibrate", "typed", "--set", "origin=701 -259")
    (listed,) = json.loads(cell("calibration", "list", "--json").out)
    told = cell("profile", "show", "--calibrated")
    assert told.code == 0
    assert "with 1 calibration in force" in told.err
    changed = set(told.out.splitlines()) - set(plain.splitlines())
    (line,) = changed
    assert line.startswith("lattice.origin_mm = [701.0, -259.0]")
    assert line.endswith(f"# calibration {listed['identity'][:8]} (lattice of cell)")
    assert cell("profile", "show").out == plain
    data = json.loads(cell("profile", "show", "--calibrated", "--json").out)
    assert data["lattice"]["origin_mm"] == [701.0, -259.0]


def test_the_file_as_it_is_written_has_no_calibrations(cell: Cell) -> None:
    said = cell("profile", "show", "--calibrated", "--text")
    assert said.code == 2
    assert "leave out --calibrated" in said.err


def test_the_doctor_examines_what_is_known_of_a_twin_that_is_as_its_file_says(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell("calibrate", "typed", "--set", "origin=701 -259")
    seen: list[tuple[float, float]] = []
    real = doctor.meeting

    def spied(
        profile: Profile, script: str, wires: Wires, *, truth: Profile
    ) -> Callable[[], AbstractContextManager[Patient]]:
        seen.extend([profile.lattice.origin_mm, truth.lattice.origin_mm])
        return real(profile, script, wires, truth=truth)

    monkeypatch.setattr(doctor, "meeting", spied)
    said = cell("doctor", "--component", "profile")
    assert said.code == 0, said.err
    assert seen == [(701.0, -259.0), load_profile("mash").lattice.origin_mm]
