from __future__ import annotations

import logging

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cell.clock import SimulatedClock
from cell.errors import DeviceError, LedgerError, MotionRefused
from cell.events import EventBus, StepTaken, TaskEnded, TaskStarted
from sessions.journal import SessionStart
from sessions.phase import TURNS, Phase, Turn, diagram
from sessions.recording.errors import RecordingError
from tests.sessions.fakes import (
    TO_READY,
    FakeCell,
    FakeJournal,
    make_desk,
    make_session,
    say,
)
from tests.sessions.wire.tables import ALL, NEWER, ON_REQUEST, STEADY

WITH_BOTH = pytest.mark.parametrize("version", ALL)


@WITH_BOTH
def test_a_session_goes_from_status_to_done(version: str) -> None:
    cell = FakeCell()
    session = make_session(make_desk(cell), version)

    assert say(session, "STATUS") == "READY"
    assert say(session, "INFO") == (
        f"TYPE ApplicationServer\nSUBTYPE Interactive\nPROTOCOL {version}"
    )
    assert say(session, "LIST_GOALS") == "GOAL Reach\nGOAL Wander\nEND_LIST_GOALS"
    assert say(session, "LIST_ENVIRONMENTS Reach") == (
        "ENVIRONMENT LINE\nENVIRONMENT OTHER\nEND_LIST_ENVIRONMENTS"
    )
    offer = (
        "AVAILABLE_ACTIONS UP LEFT RIGHT\n"
        "AVAILABLE_VIEWS CAMERA_TOP:640x480 CAMERA_GRIPPER:1280x960"
    )
    assert say(session, "INITIALIZE_TASK Reach LINE") == offer + (
        "\nMODE TEACHER" if version == "1.4" else ""
    )
    assert say(session, "BEGIN_TASK_SETUP") == "OK"
    assert say(session, "END_TASK_SETUP") == (
        "SUGGESTED_ACTION RIGHT\nSTATE_UPDATED" if version == "1.4" else "OK"
    )
    event = "EVENT Robot move" if version == "1.2" else "EVENT 'Robot move'"
    hint = "SUGGESTED_ACTION RIGHT\n" if version == "1.4" else ""
    assert say(session, "ACTION RIGHT") == f"REWARD 0\n{event}\n{hint}STATE_UPDATED"
    assert say(session, "ACTION RIGHT") == f"REWARD 0.25\n{event}\n{hint}STATE_UPDATED"
    assert say(session, "ACTION RIGHT").startswith("REWARD 20\nEVENT ")
    assert say(session, "RESET_TASK") == f"{hint}STATE_UPDATED"
    reply = session.handle(b"GET_VIEW CAMERA_TOP")
    assert (reply.text, len(reply.data)) == (b"VIEW CAMERA_TOP image/mif 921608\n", 921608)
    goodbye = session.handle(b"DONE")
    assert (goodbye.text, goodbye.closes) == (b"GOODBYE\n", True)
    assert cell.calls[-2:] == ["clean", "close"]


def test_devices_come_up_at_the_end_of_the_set_up_and_not_before() -> None:
    cell = FakeCell()
    session = make_session(make_desk(cell))
    say(session, *TO_READY[:2])
    assert cell.calls == []

    say(session, "END_TASK_SETUP")

    assert cell.calls == [
        "begin_session 42",
        "open",
        "show black",
        "lay_out 1",
        "move_to 710 -265 136.5",
    ]


@WITH_BOTH
def test_failed_is_told_as_the_dialect_can(version: str) -> None:
    session = make_session(make_desk(FakeCell()), version)
    say(session, *TO_READY)

    reply = say(session, "ACTION LEFT")

    assert (
        reply
        == {
            "1.2": "REWARD -50\nEVENT Task failed\nSTATE_UPDATED",
            "1.3": "REWARD -50\nFAILED",
            "1.4": "REWARD -50\nFAILED",
            "1.5": "REWARD -50\nEVENT 'Task failed'\nSTATE_UPDATED",
        }[version]
    )
    assert say(session, "ACTION RIGHT") == "ERROR 'The task has failed: send RESET_TASK first'"
    assert say(session, "RESET_TASK", "ACTION RIGHT").startswith("REWARD 0\n")


def test_after_finished_an_action_is_an_error_until_the_task_is_reset() -> None:
    session = make_session(make_desk(FakeCell()))
    assert say(session, *TO_READY, *["ACTION RIGHT"] * 3).endswith("\nFINISHED")

    assert say(session, "ACTION UP") == "ERROR 'The task has finished: send RESET_TASK first'"
    assert say(session, "ACTION SIDEWAYS") == "UNKNOWN_ACTION SIDEWAYS"
    assert say(session, "RESET_TASK", "ACTION UP").startswith("REWARD -10\n")


@pytest.mark.parametrize("version", ON_REQUEST)
def test_the_teacher_speaks_after_teaching_on_only(version: str) -> None:
    session = make_session(make_desk(FakeCell()), version)
    assert say(session, "TEACHING ON") == "NO_TASK_SELECTED"
    say(session, *TO_READY)
    assert "TEACHER" not in say(session, "ACTION UP")

    assert say(session, "TEACHING ON") == "OK"

    assert say(session, "ACTION UP") == (
        "REWARD -10\nEVENT 'Robot hit the wall'\nTEACHER_ACTION RIGHT\nSTATE_UPDATED"
    )
    assert say(session, "RESET_TASK") == "STATE_UPDATED"
    assert "TEACHER" in say(session, "ACTION RIGHT")
    assert "TEACHER" not in say(session, "ACTION RIGHT", "ACTION RIGHT")
    assert "TEACHER" not in say(session, "RESET_TASK", "TEACHING OFF", "ACTION RIGHT")


def test_a_task_without_teacher_says_so() -> None:
    session = make_session(make_desk(FakeCell()))

    assert say(session, "INITIALIZE_TASK Wander LINE", "TEACHING ON") == "NOT_SUPPORTED"


def test_dialect_1_4_names_the_mode_of_a_task_without_teacher() -> None:
    session = make_session(make_desk(FakeCell()), "1.4")

    assert say(session, "INITIALIZE_TASK Wander LINE").endswith("\nMODE STANDARD")
    assert say(session, "BEGIN_TASK_SETUP", "END_TASK_SETUP") == "STATE_UPDATED"
    assert "SUGGESTED" not in say(session, "ACTION RIGHT")
    assert say(session, "GET_TRAJECTORIES_COUNT") == "NB_TRAJECTORIES 0"
    assert say(session, "GET_TRAJECTORY_LENGTH 0") == "UNKNOWN_TRAJECTORY 0"


@pytest.mark.parametrize("line", ["ACTION UP", "GET_VIEW CAMERA_TOP", "RESET_TASK"])
@pytest.mark.parametrize("before", [(), TO_READY[:1], TO_READY[:2]])
def test_no_task_is_ready_before_the_set_up_has_ended(line: str, before: tuple[str, ...]) -> None:
    session = make_session(make_desk(FakeCell()))

    assert say(session, *before, line) == "NO_TASK_SELECTED"


def test_the_set_up_is_begun_once_and_ended_once() -> None:
    session = make_session(make_desk(FakeCell()))
    assert say(session, "BEGIN_TASK_SETUP") == "NO_TASK_SELECTED"
    assert say(session, "END_TASK_SETUP") == "ERROR 'Task setup not started'"
    assert say(session, TO_READY[0], "END_TASK_SETUP") == "ERROR 'Task setup not started'"

    say(session, "BEGIN_TASK_SETUP")

    assert say(session, "BEGIN_TASK_SETUP") == "ERROR 'Task setup already started'"
    assert say(session, "colour red") == "ERROR 'unknown setting colour'"
    assert say(session, "colour  red") == "INVALID_ARGUMENTS  red"
    assert say(session, "STATUS") == "READY"
    assert say(session, "END_TASK_SETUP") == "OK"
    assert say(session, "END_TASK_SETUP") == "ERROR 'Task setup not started'"


def test_arguments_are_judged_before_the_task() -> None:
    session = make_session(make_desk(FakeCell()))

    assert say(session, "ACTION") == "INVALID_ARGUMENTS"
    assert say(session, "GET_VIEW a b") == "INVALID_ARGUMENTS a b"
    assert say(session, "RESET_TASK now") == "INVALID_ARGUMENTS now"
    assert say(session, "TEACHING maybe") == "INVALID_ARGUMENTS maybe"


def test_another_task_ends_the_running_one() -> None:
    cell = FakeCell()
    session = make_session(make_desk(cell))
    say(session, *TO_READY)

    assert say(session, "INITIALIZE_TASK Reach NOWHERE") == "UNKNOWN_ENVIRONMENT NOWHERE"
    assert say(session, "INITIALIZE_TASK Nothing LINE") == "UNKNOWN_GOAL Nothing"
    assert cell.blocks_out == 1
    say(session, "INITIALIZE_TASK Wander LINE")

    assert cell.calls[-1] == "clean"
    assert say(session, "ACTION RIGHT") == "NO_TASK_SELECTED"


def test_set_up_again_lays_out_again() -> None:
    cell = FakeCell()
    session = make_session(make_desk(cell))
    say(session, *TO_READY)
    cell.calls.clear()

    assert say(session, "BEGIN_TASK_SETUP", "END_TASK_SETUP") == "OK"

    assert cell.calls[:3] == ["clean", "open", "show black"]


# Seeds


@pytest.mark.parametrize("version", NEWER)
def test_a_client_may_choose_the_seed_once_a_session(version: str) -> None:
    cell = FakeCell()
    session = make_session(make_desk(cell), version)

    assert say(session, "USE_GLOBAL_SEED 4294967295") == "OK"
    assert say(session, "USE_GLOBAL_SEED 1") == "GLOBAL_SEED_ALREADY_SET"
    say(session, *TO_READY)
    assert cell.calls[0] == "begin_session 4294967295"
    assert say(session, "RESET") == "OK"
    assert say(session, "USE_GLOBAL_SEED 1") == "OK"


def test_each_session_has_its_own_seed_that_follows_from_the_servers() -> None:
    def seeds(server_seed: int) -> list[str]:
        cell = FakeCell()
        session = make_session(make_desk(cell, seed=server_seed))
        for _ in range(3):
            say(session, *TO_READY, "RESET")
        return [call for call in cell.calls if call.startswith("begin_session")]

    assert seeds(7) == seeds(7)
    assert seeds(7)[0] == "begin_session 7"
    assert len({*seeds(7), *seeds(8)}) == 6


def test_the_tasks_of_a_session_differ_and_repeat_with_its_seed() -> None:
    def tasks() -> list[int]:
        bus = EventBus(SimulatedClock())
        events, _ = bus.subscribe()
        session = make_session(make_desk(FakeCell(), events=bus))
        say(session, *TO_READY, *TO_READY)
        bodies = [event.body for event in events.take()]
        return [body.seed for body in bodies if isinstance(body, TaskStarted)]

    assert tasks() == tasks()
    assert tasks()[0] == 42
    assert tasks()[1] != 42


def test_a_seed_chosen_late_counts_from_the_next_task_on() -> None:
    cell = FakeCell()
    session = make_session(make_desk(cell))

    say(session, *TO_READY, "USE_GLOBAL_SEED 5", *TO_READY)

    assert [call for call in cell.calls if "begin" in call] == [
        "begin_session 42",
        "begin_session 5",
    ]


# Logs, events, journal


def test_the_log_names_seed_task_and_steps_and_no_path() -> None:
    session = make_session(make_desk(FakeCell()))
    assert say(session, "LOGS") == "END_LOGS"

    text = say(session, *TO_READY, "ACTION RIGHT", "ACTION UP", "RESET_TASK", "LOGS")

    lines = (
        "seed 42 drawn by the server\n"
        "task Reach LINE seed 42\n"
        "step 1 RIGHT reward 0 running Robot move\n"
        "step 2 UP reward -10 running Robot hit the wall\n"
        "reset\n"
    )
    assert text == f"LOG_FILE session.log {len(lines)}\n{lines}END_LOGS"
    assert say(session, "RESET", "LOGS") == "END_LOGS"


def test_events_tell_start_steps_and_end() -> None:
    bus = EventBus(SimulatedClock())
    events, _ = bus.subscribe()
    session = make_session(make_desk(FakeCell(), events=bus))

    say(session, *TO_READY, "ACTION RIGHT", "ACTION RIGHT", "DONE")

    assert [event.body for event in events.take()] == [
        TaskStarted("Reach", "LINE", 42, 1),
        StepTaken(1, "RIGHT", 1, 0, 0.0, "Robot move", "running"),
        StepTaken(2, "RIGHT", 2, 0, 0.25, "Robot move", "running"),
        TaskEnded("done"),
    ]


def test_the_journal_hears_every_line_before_and_every_reply_after_it_is_carried_out() -> None:
    journals: list[FakeJournal] = []

    def open_journal(start: SessionStart) -> FakeJournal:
        journals.append(FakeJournal(start))
        return journals[-1]

    session = make_session(make_desk(FakeCell(), journal_factory=open_journal))
    say(session, "STATUS", "WHAT", *TO_READY, "ACTION RIGHT", "RESET", "STATUS")
    say(session, "INITIALIZE_TASK Reach LINE")
    session.end("connection closed")

    first, second = journals
    assert [(line, reply.text) for line, reply in first.start.backlog] == [
        (b"STATUS", b"READY\n"),
        (b"WHAT", b"UNKNOWN_COMMAND WHAT\n"),
    ]
    assert first.start.seed == 42
    assert [note for note in first.notes if note[0] != "replied"] == [
        ("received", TO_READY[0].encode()),
        ("received", b"BEGIN_TASK_SETUP"),
        ("received", b"END_TASK_SETUP"),
        ("received", b"ACTION RIGHT"),
        ("received", b"RESET"),
        ("closed", "reset"),
    ]
    assert first.notes[-2:] == [("replied", b"OK\n"), ("closed", "reset")]
    assert [line for line, _ in second.start.backlog] == [b"STATUS"]
    assert second.notes[-1] == ("closed", "connection closed")


def test_done_is_in_the_journal_after_the_clean_up() -> None:
    journals: list[FakeJournal] = []

    def open_journal(start: SessionStart) -> FakeJournal:
        journals.append(FakeJournal(start))
        return journals[-1]

    cell = FakeCell()
    desk = make_desk(cell, journal_factory=open_journal)
    session = make_session(desk)
    say(session, *TO_READY, "DONE")
    session.end("connection closed")

    assert journals[0].notes[-2:] == [("replied", b"GOODBYE\n"), ("closed", "done")]
    assert not desk.is_taken


# Failures


def one_line(caplog: pytest.LogCaptureFixture) -> str:
    records = [record for record in caplog.records if record.levelno >= logging.WARNING]
    assert len(records) == 1
    message = records[0].getMessage()
    assert "\n" not in message
    assert records[0].exc_info is None
    return message


@pytest.mark.parametrize(
    ("failure", "reply"),
    [
        (
            MotionRefused("J5", value=120, limit=100, nearest=100, unit="deg", why="is too far"),
            "ERROR 'J5 is too far: 120.0 deg asked, limit 100.0 deg, nearest allowed 100.0 deg'",
        ),
        (
            DeviceError("arm", "answered nonsense, see /var/log/arm.log", code=7),
            "ERROR 'arm: answered nonsense, see ... (error 7)'",
        ),
        (
            LedgerError("/home/cell/ledger.sqlite: disk full\nreally"),
            "ERROR 'The ledger of blocks cannot be used'",
        ),
    ],
)
def test_a_failing_cell_is_an_error_of_one_sentence_and_the_task_goes_on(
    failure: Exception, reply: str, caplog: pytest.LogCaptureFixture
) -> None:
    cell = FakeCell()
    session = make_session(make_desk(cell))
    say(session, *TO_READY)
    cell.failures["move_to"] = failure

    assert say(session, "ACTION RIGHT") == reply

    assert "ACTION RIGHT" in one_line(caplog)
    assert say(session, "ACTION RIGHT").startswith("REWARD")


def test_a_failing_set_up_leaves_a_clean_cell_and_may_be_tried_again(
    caplog: pytest.LogCaptureFixture,
) -> None:
    cell = FakeCell()
    session = make_session(make_desk(cell))
    say(session, *TO_READY[:2])
    cell.failures["lay_out"] = DeviceError("gripper", "is silent")

    assert say(session, "END_TASK_SETUP") == "ERROR 'gripper: is silent'"

    one_line(caplog)
    assert cell.calls[-1] == "clean"
    assert say(session, "ACTION UP") == "NO_TASK_SELECTED"
    assert say(session, "BEGIN_TASK_SETUP", "END_TASK_SETUP") == "OK"


def test_what_nobody_foresaw_ends_the_task_and_not_the_session(
    caplog: pytest.LogCaptureFixture,
) -> None:
    cell = FakeCell()
    session = make_session(make_desk(cell))
    say(session, *TO_READY)
    cell.failures["move_to"] = ZeroDivisionError("in /secret/file.py\nline 2")

    assert say(session, "ACTION RIGHT") == "ERROR 'Internal error'"

    assert "ZeroDivisionError at fakes.py" in one_line(caplog)
    assert cell.calls[-1] == "clean"
    assert say(session, "ACTION RIGHT") == "NO_TASK_SELECTED"
    assert say(session, "TEACHING ON") == "NO_TASK_SELECTED"
    assert say(session, *TO_READY) == "OK"


def test_a_clean_up_that_fails_frees_the_cell_all_the_same(
    caplog: pytest.LogCaptureFixture,
) -> None:
    cell = FakeCell()
    desk = make_desk(cell)
    session = make_session(desk)
    say(session, *TO_READY)
    cell.failures["clean"] = DeviceError("arm", "is jammed")
    cell.failures["close"] = ZeroDivisionError()

    session.end("connection closed")

    assert not desk.is_taken
    assert ["jammed" in m or "closing" in m for m in caplog.messages] == [True, True]


def test_a_session_that_cannot_be_recorded_does_not_begin(
    caplog: pytest.LogCaptureFixture,
) -> None:
    def refuse(start: SessionStart) -> FakeJournal:
        raise RecordingError("/data/x.mcap: disk full")

    desk = make_desk(FakeCell(), journal_factory=refuse)
    session = make_session(desk)

    assert say(session, TO_READY[0]) == "ERROR 'The session cannot go on'"

    assert "disk full" in one_line(caplog)
    assert not desk.is_taken
    assert say(session, "BEGIN_TASK_SETUP") == "NO_TASK_SELECTED"


def test_a_session_whose_recording_breaks_ends_clean() -> None:
    class Breaking(FakeJournal):
        def received(self, line: bytes) -> None:
            if line.startswith(b"ACTION"):
                raise OSError(28, "No space left on device")

        def replied(self, reply: object) -> None:
            if b"ERROR" in getattr(reply, "text", b""):
                raise OSError(28, "No space left on device")

    cell = FakeCell()
    desk = make_desk(cell, journal_factory=Breaking)
    session = make_session(desk)

    assert say(session, *TO_READY, "ACTION RIGHT") == "ERROR 'Internal error'"

    assert cell.calls[-2:] == ["clean", "close"]
    assert not desk.is_taken
    assert say(session, "ACTION RIGHT") == "NO_TASK_SELECTED"


def test_a_line_beyond_the_limit_is_an_error() -> None:
    session = make_session(make_desk(FakeCell()))

    assert say(session, "X" * 4097) == "ERROR 'The line is longer than 4096 bytes'"
    assert say(session, "X" * 4096) == "UNKNOWN_COMMAND " + "X" * 4096


@STEADY
@given(st.lists(st.binary(max_size=40), max_size=8), st.sampled_from(ALL))
def test_garbage_never_raises_and_always_answers_one_line(lines: list[bytes], version: str) -> None:
    session = make_session(make_desk(FakeCell()), version)
    for line in [b"INITIALIZE_TASK Reach LINE", b"BEGIN_TASK_SETUP", *lines]:
        reply = session.handle(line.replace(b"\n", b""))
        assert reply.text.endswith(b"\n")
        assert reply.text.count(b"\n") <= 3


# The table of phases


def test_every_phase_can_be_reached_and_left() -> None:
    assert set(TURNS.values()) == set(Phase)
    assert {phase for phase, turn in TURNS if turn is not Turn.TASK_DROPPED} == set(Phase)
    assert diagram().startswith("stateDiagram-v2\n")
