from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sessions.errors import LocalProtocolError
from sessions.wire import commands as c
from sessions.wire.commands import format_command, parse_command
from sessions.wire.dialects import DIALECTS
from sessions.wire.replies import InvalidArguments, UnknownCommand
from tests.sessions.wire.tables import ALL, COMMANDS, STEADY

CASES = [
    pytest.param(line, command, dialects, id=line.decode(errors="replace"))
    for line, command, dialects in COMMANDS
]


@pytest.mark.parametrize(("line", "command", "dialects"), CASES)
def test_a_line_reads_as_its_command_in_every_dialect_that_has_it(
    line: bytes, command: c.Command, dialects: tuple[str, ...]
) -> None:
    for version in ALL:
        wanted = command if version in dialects else UnknownCommand(line.decode().partition(" ")[0])
        assert parse_command(line, DIALECTS[version]) == wanted


@pytest.mark.parametrize(("line", "command", "dialects"), CASES)
def test_a_command_is_written_as_its_line(
    line: bytes, command: c.Command, dialects: tuple[str, ...]
) -> None:
    assert format_command(command) == line


@pytest.mark.parametrize(
    ("line", "arguments"),
    [
        (b"STATUS now", b"now"),
        (b"STATUS ", b""),
        (b"LIST_GOALS a b", b"a b"),
        (b"LIST_ENVIRONMENTS", b""),
        (b"LIST_ENVIRONMENTS A B", b"A B"),
        (b"INITIALIZE_TASK A", b"A"),
        (b"INITIALIZE_TASK A B C", b"A B C"),
        (b"INITIALIZE_TASK  A B", b" A B"),
        (b"ACTION 'UP", b"'UP"),
        (b"ACTION UP'", b"UP'"),
        (b"ACTION 'U'P", b"'U'P"),
        (b"ACTION 'UP' ", b"'UP' "),
        (b"ACTION 'UP\\'", b"'UP\\'"),
        (b"ACTION it's", b"it's"),
        (b"TEACHING", b""),
        (b"TEACHING on", b"on"),
        (b"TEACHING ON OFF", b"ON OFF"),
        (b"USE_GLOBAL_SEED -1", b"-1"),
        (b"USE_GLOBAL_SEED 4294967296", b"4294967296"),
        (b"USE_GLOBAL_SEED 1.5", b"1.5"),
        (b"USE_GLOBAL_SEED 0x10", b"0x10"),
        (b"USE_GLOBAL_SEED 1_0", b"1_0"),
        ("USE_GLOBAL_SEED ٣".encode(), "٣".encode()),
        (b"ACTION \xff\xfe", b"\xff\xfe"),
        (b"\xff\xfe", b""),
        (b"NO_SUCH \xc3\x28", b"\xc3\x28"),
    ],
)
def test_wrong_arguments_come_back_as_they_were_received(line: bytes, arguments: bytes) -> None:
    assert parse_command(line, DIALECTS["1.5"]) == InvalidArguments(arguments)


@pytest.mark.parametrize("line", [b"status", b"STATUS\tnow", b"'STATUS'", b" STATUS", b"STAT\0US"])
def test_what_is_no_command_is_named(line: bytes) -> None:
    answer = parse_command(line, DIALECTS["1.5"])

    assert answer == UnknownCommand(line.decode().partition(" ")[0])


def test_between_begin_and_end_other_lines_are_settings_and_commands_stay_commands() -> None:
    dialect = DIALECTS["1.5"]

    assert parse_command(b"colour 1 'a b'", dialect, is_in_setup=True) == c.Setting(
        "colour", ("1", "a b")
    )
    assert parse_command(b"STATUS", dialect, is_in_setup=True) == c.Status()
    assert parse_command(b"colour  1", dialect, is_in_setup=True) == InvalidArguments(b" 1")


@pytest.mark.parametrize("word", ["a b\\", "new line\\n"])
def test_a_word_that_quotes_cannot_say_is_refused(word: str) -> None:
    with pytest.raises(LocalProtocolError, match="backslash"):
        format_command(c.Action(word))


@STEADY
@given(st.binary(max_size=80), st.sampled_from(ALL), st.booleans())
def test_garbage_reads_as_a_command_or_a_refusal_and_nothing_else(
    line: bytes, version: str, is_in_setup: bool
) -> None:
    line = line.replace(b"\n", b"")

    parse_command(line, DIALECTS[version], is_in_setup=is_in_setup)


@STEADY
@given(st.text(alphabet=st.sampled_from("ab '\\n\n\r\té\0"), max_size=12))
def test_what_can_be_written_reads_back(word: str) -> None:
    try:
        line = format_command(c.Action(word))
    except LocalProtocolError:
        assert "\\" in word
        return

    assert b"\n" not in line
    assert parse_command(line, DIALECTS["1.5"]) == c.Action(word)


@STEADY
@given(st.text(alphabet=st.sampled_from("ab '\\n\n"), max_size=12))
def test_what_was_read_can_be_written_and_means_the_same(arguments: str) -> None:
    line = ("ACTION " + arguments.replace("\n", "")).encode()
    command = parse_command(line, DIALECTS["1.5"])

    if isinstance(command, c.Action):
        assert parse_command(format_command(command), DIALECTS["1.5"]) == command
