"""The watchdog and sessions share one cell: never both at once, and replays are not disturbed."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest

from calibration.checks import CameraChecked, Checks, Kept, LastCheck, knowledge_of
from calibration.drift.between_sessions import DriftCheck
from calibration.verdict import Grade
from cell.clock import SimulatedClock
from cell.profile import parse_profile, profile_text
from cell.twin_cell import TwinCell
from dsl.library import library_script
from sessions.hosting import Hosted, host_twin, versions
from sessions.quality import shortcomings
from sessions.script_source import served_script
from sessions.session import Session
from sessions.watching import Watch, lend_from, watch
from sessions.wire.dialects import DIALECTS
from tests.calibration.records import a_record

TEXT = profile_text("mash")


def host(recordings: Path) -> Hosted[TwinCell]:
    return host_twin(
        served_script(library_script("mash"), "mash"),
        parse_profile(TEXT, "mash"),
        TEXT,
        seed=5,
        clock=SimulatedClock(),
        recordings=recordings,
    )


@pytest.fixture
def hosted(tmp_path: Path) -> Iterator[Hosted[TwinCell]]:
    hosted = host(tmp_path)
    yield hosted
    hosted.close()


@pytest.fixture
def watching(hosted: Hosted[TwinCell]) -> Iterator[Watch]:
    made = watch(
        hosted.cell,
        lend_from(hosted.desk),
        None,
        SimulatedClock(),
        wire=hosted.wire,
        versions=versions(),
    )
    yield made
    made.close()


def say(session: Session, *lines: str) -> list[str]:
    return [session.handle(line.encode()).text.decode().strip() for line in lines]


def test_no_round_while_a_session_has_the_cell(hosted: Hosted[TwinCell], watching: Watch) -> None:
    session = Session(hosted.desk, DIALECTS["1.5"], "here")
    say(session, "INITIALIZE_TASK ReachRedCube STATIC_4x4")
    assert session.has_cell
    assert watching.watchdog.run_round(["arm"]) is None
    session.end("done")
    assert watching.watchdog.run_round(["arm"]) is not None


def test_a_client_is_told_that_the_cell_is_busy_during_a_round(
    hosted: Hosted[TwinCell],
) -> None:
    session = Session(hosted.desk, DIALECTS["1.5"], "here")
    with lend_from(hosted.desk)() as is_mine:
        assert is_mine
        assert say(session, "INITIALIZE_TASK ReachRedCube STATIC_4x4") == ["BUSY"]
        with lend_from(hosted.desk)() as is_mine_too:
            assert not is_mine_too
    assert say(session, "STATUS") == ["READY"]
    session.end("done")


def test_a_session_is_the_same_with_and_without_a_round_before_it(
    hosted: Hosted[TwinCell], watching: Watch, tmp_path: Path
) -> None:
    lines = (
        "USE_GLOBAL_SEED 3",
        "INITIALIZE_TASK ReachRedCube STATIC_4x4",
        "BEGIN_TASK_SETUP",
        "END_TASK_SETUP",
        "ACTION UP",
        "ACTION RIGHT",
        "GET_VIEW CAMERA_TOP",
        "DONE",
    )

    def play(hosted: Hosted[TwinCell]) -> list[bytes]:
        session = Session(hosted.desk, DIALECTS["1.5"], "here")
        replies = [session.handle(line.encode()) for line in lines]
        return [reply.text + bytes(reply.data) for reply in replies]

    done = watching.watchdog.run_round()
    assert done is not None
    assert done.failed == ()
    after_a_round = play(hosted)
    alone = host(tmp_path / "alone")
    without = play(alone)
    alone.close()
    assert after_a_round[-2].startswith(b"VIEW CAMERA_TOP")
    assert after_a_round == without


def moved_check(folder: Path) -> Checks:
    """Keep a check that found the top camera moved."""
    profile = parse_profile(TEXT, "mash")
    checked = CameraChecked(
        grade=Grade.BAD, text="2.1 mm off", knowledge=knowledge_of(profile, "top")
    )
    checks = Checks(folder)
    checks.keep(Kept(last=LastCheck(at=datetime(2026, 5, 4, tzinfo=UTC), cameras={"top": checked})))
    return checks


def test_a_demand_on_a_camera_that_moved_since_is_refused_with_the_check(tmp_path: Path) -> None:
    profile = parse_profile(TEXT, "mash")
    checks = moved_check(tmp_path)
    record = a_record(values={"cameras.top.plane_map": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]})
    assert shortcomings(profile, [record], checks=checks) == []
    demanding = profile.model_copy(update={"demands": {record.kind: 1000.0}})
    assert shortcomings(demanding, [record]) == []
    (told,) = shortcomings(demanding, [record], checks=checks)
    assert "the check of 2026-05-04 00:00 found: 2.1 mm off" in told
    assert "calibrate again" in told
    other = a_record(values={"cameras.oblique.plane_map": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]})
    assert shortcomings(demanding, [other], checks=checks) == []


def test_a_desk_knows_that_somebody_waits_until_it_lends_the_cell_again(
    hosted: Hosted[TwinCell],
) -> None:
    desk, session = hosted.desk, Session(hosted.desk, DIALECTS["1.5"], "here")
    with lend_from(desk)():
        assert not desk.is_wanted
        assert say(session, "INITIALIZE_TASK ReachRedCube STATIC_4x4") == ["BUSY"]
        assert desk.is_wanted
    with lend_from(desk)():
        assert not desk.is_wanted
    session.end("done")


def test_the_drift_check_is_one_of_the_components_of_a_served_cell(
    hosted: Hosted[TwinCell], tmp_path: Path
) -> None:
    profile = hosted.cell.profile
    check = DriftCheck(profile, (), Checks(tmp_path), lambda: datetime.now(UTC))
    watching = watch(
        hosted.cell, lend_from(hosted.desk), None, SimulatedClock(), wire=hosted.wire,
        versions=versions(), calibrations=check, is_wanted=lambda: hosted.desk.is_wanted,
    )  # fmt: skip
    try:
        outcomes = []
        for _ in range(2):
            done = watching.watchdog.run_round(["calibrations"])
            assert done is not None
            outcomes.append((done.records[-1].component, done.records[-1].outcome))
        assert outcomes == [("calibrations", "cannot tell"), ("calibrations", "ok")]
        assert watching.history.faults() == []
    finally:
        watching.close()
