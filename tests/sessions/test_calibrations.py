"""Sessions know what was calibrated, name it in their recordings, and refuse what is too rough."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from calibration.applying import Misfit
from calibration.record import CalibrationRecord
from cell.clock import SimulatedClock
from cell.profile import Profile, load_profile, parse_profile, profile_text
from dsl.library import library_script
from sessions.cell_script import CellScript
from sessions.hosting import host_twin
from sessions.recording import RecordingError, SessionRecording
from sessions.script_source import served_script
from sessions.session import Session
from sessions.site import ProfileSite
from sessions.verify import compare, verify
from sessions.verify_twin import fresh_session
from sessions.wire.dialects import dialect_named
from tests.calibration.records import a_record

LATTICE = a_record(kind="lattice", subject="cell", values={"lattice.origin_mm": [706.0, -262.0]})
TOP = a_record(held_out_mm=3.1)
LINES = (
    b"INITIALIZE_TASK ReachRedCube STATIC_4x4",
    b"BEGIN_TASK_SETUP",
    b"END_TASK_SETUP",
    b"ACTION UP",
    b"GET_VIEW CAMERA_TOP",
    b"DONE",
)


def script(accuracy: str = "") -> CellScript:
    text = library_script("mash")
    head = "goal ReachRedCube {\n"
    assert head in text
    return served_script(text.replace(head, f"{head}  {accuracy}\n"), "mash.cell")


def played(
    recordings: Path | None,
    calibrations: Sequence[CalibrationRecord],
    *,
    accuracy: str = "",
    demands: str = "",
    lines: Sequence[bytes] = LINES,
) -> list[bytes]:
    """Play a short session and return its replies."""
    text = f"{profile_text('mash')}\n[demands]\n{demands}\n"
    hosted = host_twin(
        script(accuracy),
        parse_profile(text, "mash"),
        text,
        seed=3,
        clock=SimulatedClock(),
        recordings=recordings,
        calibrations=tuple(calibrations),
        views="none",
    )
    try:
        session = Session(hosted.desk, dialect_named("1.5"), "test")
        replies = [bytes(session.handle(line).text) for line in lines]
        session.end("over")
    finally:
        hosted.close()
    return replies


def recorded(folder: Path, calibrations: Sequence[CalibrationRecord]) -> SessionRecording:
    played(folder, calibrations)
    (path,) = folder.glob("*.mcap")
    return SessionRecording.open(path)


def first_words(replies: Sequence[bytes]) -> list[bytes]:
    return [reply.split()[0] for reply in replies]


def test_a_recording_holds_the_calibrations_whole_and_names_them(tmp_path: Path) -> None:
    recording = recorded(tmp_path, [LATTICE, TOP])
    assert recording.start.calibrations == (LATTICE, TOP)
    named = json.loads(recording.calibration["in_force/homography/top"])
    assert named == {
        "identity": TOP.identity, "grade": "OK", "accuracy": 3.1, "unit": "mm",
        "measured_at": "2026-11-10T09:30:00+00:00",
    }  # fmt: skip
    assert "706" in recording.calibration["lattice"]


def test_a_session_without_calibrations_records_as_it_always_did(tmp_path: Path) -> None:
    recording = recorded(tmp_path, [])
    assert recording.start.calibrations == ()
    assert set(recording.calibration) == {"plane_map/top", "lattice"}


def test_a_session_repeats_with_the_calibrations_that_it_recorded_and_not_without(
    tmp_path: Path,
) -> None:
    recording = recorded(tmp_path, [LATTICE])
    report = verify(recording)
    assert report.is_identical
    assert report.views == 1
    with fresh_session(replace(recording.start, calibrations=())) as session:
        # Blocks lie elsewhere on a cell that takes its lattice to be elsewhere.
        assert not compare(recording, session).is_identical


def test_a_damaged_calibration_in_a_recording_is_told(tmp_path: Path) -> None:
    path = recorded(tmp_path, [LATTICE]).path
    data = path.read_bytes()
    assert b'"kind":"lattice"' in data
    path.write_bytes(data.replace(b'"kind":"lattice"', b'"kinX":"lattice"'))
    with pytest.raises(RecordingError, match="start is not readable"):
        SessionRecording.open(path)


def test_a_calibration_of_another_cell_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Misfit, match="made for the cell other"):
        played(None, [a_record(cell="other")])


@pytest.mark.parametrize(
    ("accuracy", "demands", "told"),
    [
        ("accuracy 2 mm", "", b"the homography of top has 3.1 mm (held out), measured on"),
        ("accuracy 0.5 mm", "", b"the lattice of cell has 0.7 mm"),
        ("", "homography = 2.0", b"2 mm are demanded, but the homography of top has 3.1 mm"),
        ("", "screen = 2.0", b"2 mm are demanded, but no screen is known: none is kept"),
    ],
)
def test_a_task_that_needs_more_is_refused_with_the_figure_before_anything_moves(
    accuracy: str, demands: str, told: bytes
) -> None:
    replies = played(None, [LATTICE, TOP], accuracy=accuracy, demands=demands, lines=LINES[:3])
    assert first_words(replies)[2] == b"ERROR"
    assert told in replies[2]
    assert len(replies[2].splitlines()) == 1


def test_a_refused_task_leaves_the_session_as_it_was_after_a_failed_set_up() -> None:
    lines = (*LINES[:3], b"BEGIN_TASK_SETUP", b"STATUS")
    replies = played(None, [], accuracy="accuracy 2 mm", lines=lines)
    assert b"is not known: no calibration is kept" in replies[2]
    assert first_words(replies)[3] == b"OK"


@pytest.mark.parametrize(
    ("accuracy", "demands"),
    [("accuracy 4 mm", "homography = 3.1"), ("", "lattice = 0.7"), ("", "")],
)
def test_what_is_known_well_enough_is_played(accuracy: str, demands: str) -> None:
    replies = played(None, [LATTICE, TOP], accuracy=accuracy, demands=demands, lines=LINES[:4])
    assert b"ERROR" not in first_words(replies)


def _profile() -> Profile:
    return load_profile("mash")


def test_a_refusal_repeats_in_a_replay(tmp_path: Path) -> None:
    played(tmp_path, [TOP], accuracy="accuracy 2 mm", lines=LINES[:3])
    (path,) = tmp_path.glob("*.mcap")
    report = verify(SessionRecording.open(path))
    assert report.is_identical
    assert report.lines == 3


def test_a_site_tells_what_is_not_known_well_enough() -> None:
    site = ProfileSite(_profile(), [LATTICE, TOP])
    assert site.lattice_accuracy(1.0) is None
    assert site.view_accuracy("CAMERA_TOP", 4.0) is None
    told = site.view_accuracy("CAMERA_TOP", 2.0)
    assert told is not None
    assert "3.1 mm" in told
    assert site.view_accuracy("CAMERA_GRIPPER", 0.1) is None
