from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sessions.errors import RemoteProtocolError
from sessions.wire.dialects import DIALECTS
from sessions.wire.incoming import AnswerReader
from sessions.wire.replies import (
    ActionDone,
    Answer,
    Failure,
    StateUpdated,
    UnknownCommand,
    ViewData,
)
from sessions.wire.writing import write_answer
from tests.sessions.wire.tables import ALL, REPLIES, STEADY

CASES = [
    pytest.param(wire, answer, version, id=f"{version} {wire[:40].decode(errors='replace')}")
    for wire, answer, dialects in REPLIES
    for version in dialects
]


def joined(answer: Answer, version: str) -> bytes:
    text, data = write_answer(answer, DIALECTS[version])
    return text + bytes(data)


@pytest.mark.parametrize(("wire", "answer", "version"), CASES)
def test_a_reply_is_written_as_its_bytes(wire: bytes, answer: Answer, version: str) -> None:
    assert joined(answer, version) == wire


@pytest.mark.parametrize(("wire", "answer", "version"), CASES)
def test_the_bytes_read_as_the_reply(wire: bytes, answer: Answer, version: str) -> None:
    reader = AnswerReader(DIALECTS[version])
    reader.feed(wire + b"READY\nOK")

    assert reader.next_answer() == answer
    assert joined(reader.next_answer() or answer, version) == b"READY\n"
    assert reader.next_answer() is None


@pytest.mark.parametrize(("wire", "answer", "version"), CASES)
def test_a_reply_may_come_byte_by_byte_with_cr(wire: bytes, answer: Answer, version: str) -> None:
    reader = AnswerReader(DIALECTS[version])
    if not isinstance(answer, ViewData) and b"LOG_FILE" not in wire:
        wire = wire.replace(b"\n", b"\r\n")
    for byte in wire[:-1]:
        reader.feed(bytes([byte]))
        assert reader.next_answer() is None

    reader.feed(wire[-1:])

    assert reader.next_answer() == answer


def test_binary_data_is_received_straight_into_its_buffer() -> None:
    reader = AnswerReader(DIALECTS["1.5"])
    reader.feed(b"VIEW V image/mif 10\n012")
    assert reader.next_answer() is None
    place = reader.wanted()
    assert place is not None
    assert len(place) == 7

    place[:4] = b"3456"
    reader.received(4)
    assert reader.next_answer() is None
    rest = reader.wanted()
    assert rest is not None
    rest[:] = b"789"
    reader.received(3)

    assert reader.next_answer() == ViewData("V", "image/mif", b"0123456789")
    assert reader.wanted() is None


@pytest.mark.parametrize(
    "wire",
    [
        b"HELLO\n",
        b"READY now\n",
        b"\n",
        b"REWARD\n",
        b"REWARD nan\n",
        b"REWARD 1\nWHAT\n",
        b"REWARD 1\nFINISHED really\n",
        b"REWARD 1\nFAILED\n",
        b"REWARD 1\nEVENT 'half\nSTATE_UPDATED\n",
        b"VIEW V image/mif\n",
        b"VIEW V image/mif -1\n",
        b"VIEW V image/mif 9999999999\n",
        b"TYPE A\nPROTOCOL 1.5\n",
        b"GOAL A\nENVIRONMENT B\n",
        b"AVAILABLE_ACTIONS UP\nMODE STANDARD\n",
        b"AVAILABLE_ACTIONS UP\nAVAILABLE_VIEWS V\n",
        b"AVAILABLE_ACTIONS UP\nAVAILABLE_VIEWS V:640\n",
        b"LOG_FILE a\n",
        b"LOG_FILE a 0\nREADY\n",
        b"UNKNOWN_GOAL\n",
        b"SUGGESTED_ACTION UP\nSTATE_UPDATED\n",
        b"ERROR \xff\n",
    ],
)
def test_a_reply_that_the_protocol_does_not_allow_is_told(wire: bytes) -> None:
    reader = AnswerReader(DIALECTS["1.5"])
    reader.feed(wire)

    with pytest.raises(RemoteProtocolError):
        reader.next_answer()


def test_a_mode_that_does_not_exist_is_told() -> None:
    reader = AnswerReader(DIALECTS["1.4"])
    reader.feed(b"AVAILABLE_ACTIONS UP\nAVAILABLE_VIEWS\nMODE FAST\n")

    with pytest.raises(RemoteProtocolError, match="FAST"):
        reader.next_answer()


def test_a_line_without_end_is_told() -> None:
    reader = AnswerReader(DIALECTS["1.5"])
    reader.feed(b"x" * (1 << 20) + b"xx")

    with pytest.raises(RemoteProtocolError, match="more than"):
        reader.next_answer()


@pytest.mark.parametrize("version", ["1.2", "1.5"])
def test_where_there_is_no_failed_the_event_carries_the_failure(version: str) -> None:
    assert b"EVENT 'Block lost'\nSTATE_UPDATED\n".replace(
        b"'", b"" if version == "1.2" else b"'"
    ) in joined(ActionDone(-5.0, "Block lost", state="FAILED"), version)
    assert b"Task failed" in joined(ActionDone(-5.0, state="FAILED"), version)


def test_dialect_1_2_never_suggests_an_action() -> None:
    assert joined(ActionDone(0.0, suggestion="UP"), "1.2") == b"REWARD 0\nSTATE_UPDATED\n"


@pytest.mark.parametrize("version", ["1.2", "1.3", "1.5"])
def test_only_dialect_1_4_suggests_an_action_with_a_start(version: str) -> None:
    assert joined(StateUpdated("UP"), version) == b"STATE_UPDATED\n"


def test_text_for_people_never_breaks_the_line() -> None:
    assert joined(ActionDone(0.0, "a\nb\r"), "1.2") == b"REWARD 0\nEVENT a b \nSTATE_UPDATED\n"
    assert joined(Failure("lost C:\\new \\"), "1.5") == b"ERROR 'lost C:/new /'\n"


@STEADY
@given(st.binary(max_size=120), st.sampled_from(ALL))
def test_garbage_reads_as_replies_or_is_told(data: bytes, version: str) -> None:
    reader = AnswerReader(DIALECTS[version])
    reader.feed(data)
    try:
        while reader.next_answer() is not None:
            pass
    except RemoteProtocolError:
        return


@STEADY
@given(st.text(max_size=30), st.sampled_from(ALL))
def test_any_name_can_be_echoed_on_one_line(name: str, version: str) -> None:
    name = name.encode("utf-8", "replace").decode("utf-8")
    wire = joined(UnknownCommand(name), version)
    reader = AnswerReader(DIALECTS[version])
    reader.feed(wire)

    assert wire.count(b"\n") == 1
    assert isinstance(reader.next_answer(), UnknownCommand)
