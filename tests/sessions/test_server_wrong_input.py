"""Wrong input over a real socket: the reply the protocol names, one line in the log, no harm."""

from __future__ import annotations

import logging
from dataclasses import dataclass

import pytest

from cell.errors import DeviceError, LedgerError
from tests.sessions.fakes import FakeCell, make_desk
from tests.sessions.serving import RawClient, serving, until_alone, until_ready

SELECTED = b"INITIALIZE_TASK Reach LINE\n"
IN_SETUP = SELECTED + b"BEGIN_TASK_SETUP\n"
READY = IN_SETUP + b"END_TASK_SETUP\n"
SOLVED = READY + b"ACTION RIGHT\n" * 3
LOST = READY + b"ACTION LEFT\n"
NO_TASK = b"NO_TASK_SELECTED\n"
INVALID = b"INVALID_ARGUMENTS"
LONG = b"ERROR 'The line is longer than 4096 bytes'\n"


@dataclass(frozen=True)
class Case:
    """What is sent in which state, and what must come back."""

    sent: bytes
    reply: bytes
    before: bytes = b""
    dialect: str = "1.5"


CASES = {
    # commands in the wrong state
    "action without a task": Case(b"ACTION UP\n", NO_TASK),
    "view without a task": Case(b"GET_VIEW CAMERA_TOP\n", NO_TASK),
    "reset task without a task": Case(b"RESET_TASK\n", NO_TASK),
    "teaching without a task": Case(b"TEACHING ON\n", NO_TASK),
    "begin without a task": Case(b"BEGIN_TASK_SETUP\n", NO_TASK),
    "end without a task": Case(b"END_TASK_SETUP\n", b"ERROR 'Task setup not started'\n"),
    "action before set-up": Case(b"ACTION UP\n", NO_TASK, SELECTED),
    "view before set-up": Case(b"GET_VIEW CAMERA_TOP\n", NO_TASK, SELECTED),
    "reset task before set-up": Case(b"RESET_TASK\n", NO_TASK, SELECTED),
    "end before begin": Case(b"END_TASK_SETUP\n", b"ERROR 'Task setup not started'\n", SELECTED),
    "action in set-up": Case(b"ACTION UP\n", NO_TASK, IN_SETUP),
    "view in set-up": Case(b"GET_VIEW CAMERA_TOP\n", NO_TASK, IN_SETUP),
    "reset task in set-up": Case(b"RESET_TASK\n", NO_TASK, IN_SETUP),
    "begin twice": Case(b"BEGIN_TASK_SETUP\n", b"ERROR 'Task setup already started'\n", IN_SETUP),
    "end twice": Case(b"END_TASK_SETUP\n", b"ERROR 'Task setup not started'\n", READY),
    "action after finished": Case(
        b"ACTION UP\n", b"ERROR 'The task has finished: send RESET_TASK first'\n", SOLVED
    ),
    "action after failed": Case(
        b"ACTION UP\n", b"ERROR 'The task has failed: send RESET_TASK first'\n", LOST
    ),
    "action after failed in 1.4": Case(
        b"ACTION UP\n", b"ERROR 'The task has failed: send RESET_TASK first'\n", LOST, "1.4"
    ),
    "teaching without a teacher": Case(
        b"TEACHING ON\n", b"NOT_SUPPORTED\n", b"INITIALIZE_TASK Wander LINE\n"
    ),
    "second seed": Case(
        b"USE_GLOBAL_SEED 1\n", b"GLOBAL_SEED_ALREADY_SET\n", b"USE_GLOBAL_SEED 1\n"
    ),
    "trajectory in a standard mode": Case(
        b"GET_TRAJECTORY_LENGTH 0\n", b"UNKNOWN_TRAJECTORY 0\n", dialect="1.4"
    ),
    # names that do not exist
    "unknown goal": Case(b"LIST_ENVIRONMENTS Fly\n", b"UNKNOWN_GOAL Fly\n"),
    "unknown goal of a task": Case(b"INITIALIZE_TASK Fly LINE\n", b"UNKNOWN_GOAL Fly\n"),
    "unknown environment": Case(b"INITIALIZE_TASK Reach SEA\n", b"UNKNOWN_ENVIRONMENT SEA\n"),
    "environment of another goal": Case(
        b"INITIALIZE_TASK Wander OTHER\n", b"UNKNOWN_ENVIRONMENT OTHER\n"
    ),
    "unknown view": Case(b"GET_VIEW CAMERA_MOON\n", b"UNKNOWN_VIEW CAMERA_MOON\n", READY),
    "view in lower case": Case(b"GET_VIEW camera_top\n", b"UNKNOWN_VIEW camera_top\n", READY),
    "unknown action": Case(b"ACTION JUMP\n", b"UNKNOWN_ACTION JUMP\n", READY),
    "action in lower case": Case(b"ACTION up\n", b"UNKNOWN_ACTION up\n", READY),
    "unknown action that needs quotes": Case(
        b"ACTION 'go \\'up\\'\\nnow'\n", b"UNKNOWN_ACTION 'go \\'up\\'\\nnow'\n", READY
    ),
    "empty action": Case(b"ACTION ''\n", b"UNKNOWN_ACTION ''\n", READY),
    "unknown setting": Case(b"colour blue\n", b"ERROR 'unknown setting colour'\n", IN_SETUP),
    "setting without a value": Case(b"colour\n", b"ERROR 'unknown setting colour'\n", IN_SETUP),
    "setting outside of set-up": Case(b"colour blue\n", b"UNKNOWN_COMMAND colour\n", READY),
    # commands that do not exist
    "unknown command": Case(b"JUMP\n", b"UNKNOWN_COMMAND JUMP\n"),
    "command in lower case": Case(b"status\n", b"UNKNOWN_COMMAND status\n"),
    "command with a tab": Case(b"STATUS\tx\n", b"UNKNOWN_COMMAND STATUS\tx\n"),
    "space before the command": Case(b" STATUS\n", b"UNKNOWN_COMMAND ''\n"),
    "only a space": Case(b" \n", b"UNKNOWN_COMMAND ''\n"),
    "quoted command": Case(b"'STATUS'\n", b"UNKNOWN_COMMAND '\\'STATUS\\''\n"),
    "zero byte in a command": Case(b"STA\0TUS\n", b"UNKNOWN_COMMAND STA\0TUS\n"),
    "sleep in 1.2": Case(b"SLEEP\n", b"UNKNOWN_COMMAND SLEEP\n", dialect="1.2"),
    "logs in 1.2": Case(b"LOGS\n", b"UNKNOWN_COMMAND LOGS\n", dialect="1.2"),
    "seed in 1.2": Case(
        b"USE_GLOBAL_SEED 1\n", b"UNKNOWN_COMMAND USE_GLOBAL_SEED\n", dialect="1.2"
    ),
    "reset in 1.2": Case(b"RESET\n", b"UNKNOWN_COMMAND RESET\n", dialect="1.2"),
    "teaching in 1.2": Case(b"TEACHING ON\n", b"UNKNOWN_COMMAND TEACHING\n", dialect="1.2"),
    "teaching in 1.4": Case(b"TEACHING ON\n", b"UNKNOWN_COMMAND TEACHING\n", dialect="1.4"),
    "trajectories in 1.5": Case(
        b"GET_TRAJECTORIES_COUNT\n", b"UNKNOWN_COMMAND GET_TRAJECTORIES_COUNT\n"
    ),
    "http": Case(b"GET / HTTP/1.1\r\n\r\n", b"UNKNOWN_COMMAND GET\n"),
    # wrong arguments
    "status with an argument": Case(b"STATUS now\n", INVALID + b" now\n"),
    "status with a trailing space": Case(b"STATUS \n", INVALID + b"\n"),
    "info with arguments": Case(b"INFO a b\n", INVALID + b" a b\n"),
    "done with an argument": Case(b"DONE now\n", INVALID + b" now\n"),
    "goals with an argument": Case(b"LIST_GOALS all\n", INVALID + b" all\n"),
    "environments without a goal": Case(b"LIST_ENVIRONMENTS\n", INVALID + b"\n"),
    "environments of two goals": Case(b"LIST_ENVIRONMENTS a b\n", INVALID + b" a b\n"),
    "task without an environment": Case(b"INITIALIZE_TASK Reach\n", INVALID + b" Reach\n"),
    "task with three names": Case(b"INITIALIZE_TASK a b c\n", INVALID + b" a b c\n"),
    "task with two spaces": Case(b"INITIALIZE_TASK Reach  LINE\n", INVALID + b" Reach  LINE\n"),
    "action without a name, without a task": Case(b"ACTION\n", INVALID + b"\n"),
    "action with two names": Case(b"ACTION UP UP\n", INVALID + b" UP UP\n", READY),
    "view without a name": Case(b"GET_VIEW\n", INVALID + b"\n", READY),
    "reset task with an argument": Case(b"RESET_TASK 1\n", INVALID + b" 1\n", READY),
    "teaching without a word": Case(b"TEACHING\n", INVALID + b"\n", READY),
    "teaching in lower case": Case(b"TEACHING on\n", INVALID + b" on\n", READY),
    "seed without a number": Case(b"USE_GLOBAL_SEED\n", INVALID + b"\n"),
    "negative seed": Case(b"USE_GLOBAL_SEED -1\n", INVALID + b" -1\n"),
    "seed beyond 32 bits": Case(b"USE_GLOBAL_SEED 4294967296\n", INVALID + b" 4294967296\n"),
    "seed of letters": Case(b"USE_GLOBAL_SEED seven\n", INVALID + b" seven\n"),
    "trajectory of letters": Case(
        b"GET_TRAJECTORY_LENGTH one\n", INVALID + b" one\n", dialect="1.4"
    ),
    "malformed setting": Case(b"colour 'blue\n", INVALID + b" 'blue\n", IN_SETUP),
    # quotes
    "quote that does not end": Case(b"ACTION 'UP\n", INVALID + b" 'UP\n", READY),
    "quote in a word": Case(b"ACTION U'P\n", INVALID + b" U'P\n", READY),
    "text after a quote": Case(b"ACTION 'U'P\n", INVALID + b" 'U'P\n", READY),
    "escaped closing quote": Case(b"ACTION 'UP\\'\n", INVALID + b" 'UP\\'\n", READY),
    "lone quote": Case(b"ACTION '\n", INVALID + b" '\n", READY),
    # bytes
    "argument that is not utf-8": Case(b"ACTION \xff\xfe\n", INVALID + b" \xff\xfe\n", READY),
    "command that is not utf-8": Case(b"\xc3\x28 a\n", INVALID + b" a\n"),
    "utf-8 cut short": Case(b"GET_VIEW \xe2\x82\n", INVALID + b" \xe2\x82\n"),
    "surrogate": Case(b"ACTION \xed\xa0\x80\n", INVALID + b" \xed\xa0\x80\n", READY),
    "binary garbage": Case(bytes(range(128, 256)) + b"\n", INVALID + b"\n"),
    "carriage returns": Case(b"STATUS\r\r\n", b"UNKNOWN_COMMAND 'STATUS\r'\n"),
    "line too long": Case(b"A" * 4097 + b"\n", LONG),
    "endless line": Case(b"A" * 300_000, LONG, READY),
    "long line in set-up": Case(b"A" * 5000 + b"\n", LONG, IN_SETUP),
}


def wrong_lines(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]


def test_there_are_at_least_sixty_cases() -> None:
    assert len(CASES) >= 60


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_wrong_input(case: Case, caplog: pytest.LogCaptureFixture) -> None:
    cell = FakeCell()
    with serving(make_desk(cell), case.dialect) as server:
        client = RawClient(server, case.dialect)
        client.send(case.before + b"STATUS\n")
        while client.line() != b"READY\n":
            pass

        client.send(case.sent)

        assert client.line() == case.reply
        client.leave()
        assert len(wrong_lines(caplog)) == 1
        assert "\n" not in wrong_lines(caplog)[0]
        assert (cell.blocks_out, cell.is_open) == (0, False)
        with RawClient(server, case.dialect) as following:
            assert following.ask("STATUS") == "READY"
            following.send(READY + b"ACTION RIGHT\n")
            while not (line := following.line()).startswith(b"REWARD"):
                assert line
            assert line == b"REWARD 0\n"
            following.leave()
        until_alone(server)
        assert len(wrong_lines(caplog)) == 1


@pytest.mark.parametrize(
    "sent", [b"STAT", b"\xff\xfe", b"ACTION UP\r"], ids=["half a line", "garbage", "no LF"]
)
def test_leaving_in_the_middle_of_a_line(sent: bytes, caplog: pytest.LogCaptureFixture) -> None:
    with serving(make_desk(FakeCell())) as server:
        with RawClient(server) as client:
            assert client.ask("STATUS") == "READY"
            client.send(sent)
        until_alone(server)

        assert [m.partition(": ")[2] for m in wrong_lines(caplog)] == [
            "connection closed in the middle of a line"
        ]
        until_ready(server)


@pytest.mark.parametrize(
    ("failing", "failure", "line", "reply"),
    [
        ("move_to", DeviceError("arm", "is silent"), "ACTION RIGHT", "ERROR 'arm: is silent'"),
        ("grab", DeviceError("top", "is dark"), "GET_VIEW CAMERA_TOP", "ERROR 'top: is dark'"),
        ("move_to", KeyError("/etc/x"), "RESET_TASK", "ERROR 'Internal error'"),
        (
            "move_to",
            LedgerError("/var/lib/x: locked"),
            "ACTION RIGHT",
            "ERROR 'The ledger of blocks cannot be used'",
        ),
    ],
)
def test_a_failing_cell(
    failing: str, failure: Exception, line: str, reply: str, caplog: pytest.LogCaptureFixture
) -> None:
    cell = FakeCell()
    with serving(make_desk(cell)) as server:
        with RawClient(server) as client:
            client.to_ready()
            cell.failures[failing] = failure
            assert client.ask(line) == reply
            client.leave()
        assert len(wrong_lines(caplog)) == 1
        with RawClient(server) as following:
            following.to_ready().leave()
