"""What the last check found is told when a cell is served."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest

from calibration.checks import CHECKS_FILE, CameraChecked, Checks, Kept, LastCheck, knowledge_of
from calibration.verdict import Grade
from cell.profile import load_profile
from console.drifting import tell_last_check
from console.places import calibrations_folder


@pytest.fixture
def checks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Checks:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return Checks(calibrations_folder("mash"))


def told(capsys: pytest.CaptureFixture[str]) -> str:
    tell_last_check(load_profile("mash"))
    return capsys.readouterr().err


def test_a_camera_that_moved_is_told_in_a_line_with_what_to_do(
    checks: Checks, capsys: pytest.CaptureFixture[str]
) -> None:
    assert told(capsys) == ""
    profile = load_profile("mash")
    for grade, lines in ((Grade.OK, 0), (Grade.BAD, 1)):
        checked = CameraChecked(
            grade=grade, text="2.1 mm off", hint="calibrate again",
            knowledge=knowledge_of(profile, "top"),
        )  # fmt: skip
        at = datetime(2026, 5, 4, 3, 2, tzinfo=UTC)
        checks.keep(Kept(last=LastCheck(at=at, cameras={"top": checked})))
        text = told(capsys)
        assert len(text.splitlines()) == lines
    assert "2026-05-04 03:02" in text
    assert "2.1 mm off; calibrate again" in text


def test_a_check_that_cannot_be_read_is_told_and_stops_nothing(
    checks: Checks, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = calibrations_folder("mash")
    folder.mkdir(parents=True)
    (folder / CHECKS_FILE).write_text("{")
    assert "move it away" in told(capsys)
