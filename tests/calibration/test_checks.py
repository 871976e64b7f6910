"""The last check is kept beside the calibrations, and counts for what it checked only."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest

from calibration.checks import (
    CHECKS_FILE,
    CameraChecked,
    Checks,
    Kept,
    LastCheck,
    grade_in,
    knowledge_of,
    moved_cameras,
)
from calibration.errors import ArchiveError
from calibration.verdict import Grade
from cell.profile import load_profile
from tests.calibration.records import a_record

PROFILE = load_profile("mash")
AT = datetime(2026, 5, 4, 3, 2, tzinfo=UTC)


def last_check(grade: Grade | None) -> LastCheck:
    checked = CameraChecked(
        grade=grade, text="2.1 mm off", hint="again", knowledge=knowledge_of(PROFILE, "top")
    )
    return LastCheck(at=AT, cameras={"top": checked})


def test_a_kept_check_is_read_back(tmp_path: Path) -> None:
    checks = Checks(tmp_path / "new")
    assert checks.read() == Kept()
    checks.keep(Kept(last=last_check(Grade.BAD)))
    assert Checks(tmp_path / "new").read().last == last_check(Grade.BAD)


def test_a_damaged_file_is_told_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / CHECKS_FILE).write_text('{"last": 3}')
    with pytest.raises(ArchiveError, match="move it away"):
        Checks(tmp_path).read()


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ArchiveError, match="cannot be written"):
        Checks(tmp_path / "file").keep(Kept())


@pytest.mark.parametrize("grade", [Grade.OK, Grade.DEGRADED, None])
def test_only_what_is_bad_is_said_to_have_moved(grade: Grade | None) -> None:
    assert moved_cameras(PROFILE, last_check(grade)) == {}
    assert moved_cameras(PROFILE, None) == {}
    assert "2026-05-04" in moved_cameras(PROFILE, last_check(Grade.BAD))["top"]
    assert last_check(grade).grade is grade


def test_a_check_counts_no_more_after_a_new_calibration_of_camera_or_screen() -> None:
    bad = last_check(Grade.BAD)
    top = PROFILE.cameras["top"].model_copy(
        update={"plane_map": ((0.0, 0.6, 222.0), (0.6, 0.0, -375.0), (0.0, 0.0, 1.0))}
    )
    again = PROFILE.model_copy(update={"cameras": {**PROFILE.cameras, "top": top}})
    assert moved_cameras(again, bad) == {}
    display = PROFILE.display.model_copy(update={"corner_x_mm": PROFILE.display.corner_x_mm + 1.0})
    assert moved_cameras(PROFILE.model_copy(update={"display": display}), bad) == {}
    settings = replace(PROFILE.cameras["top"].settings, gain_db=1.0)
    brighter = PROFILE.cameras["top"].model_copy(update={"settings": settings})
    set_up = PROFILE.model_copy(update={"cameras": {**PROFILE.cameras, "top": brighter}})
    assert set(moved_cameras(set_up, bad)) == {"top"}


def test_a_list_of_calibrations_tells_what_the_last_check_said_of_each() -> None:
    top = a_record(values={"cameras.top.plane_map": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]})
    lattice = a_record(values={"lattice.angle_deg": 1.0})
    assert grade_in(last_check(Grade.BAD), PROFILE, top) == "BAD"
    assert grade_in(last_check(None), PROFILE, top) == "cannot tell"
    assert grade_in(last_check(Grade.BAD), PROFILE, lattice) == ""
    assert grade_in(None, PROFILE, top) == ""
