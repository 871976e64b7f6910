import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.framing import (
    FROM_MASTER,
    FROM_MODULE,
    DamagedFrame,
    Frame,
    FrameReader,
    Received,
    encode_frame,
)
from cell.drivers.schunk_smp.reply_codec import decode_reply, encode_reply
from tests.cell.drivers.schunk_smp.worked import COMMANDS, REPLIES

LINES = [text for *_, text in REPLIES]
STREAM = b"".join(bytes.fromhex(text) for text in LINES)


def frames(found: list[Received]) -> list[Frame]:
    return [item for item in found if isinstance(item, Frame)]


def test_a_stream_of_frames_is_cut_at_their_ends() -> None:
    found = FrameReader(FROM_MODULE).feed(STREAM)
    assert [encode_frame(f) for f in frames(found)] == [bytes.fromhex(t) for t in LINES]


@pytest.mark.parametrize("size", [1, 2, 3, 7, 64])
def test_frames_are_found_in_pieces_of_any_size(size: int) -> None:
    reader = FrameReader(FROM_MODULE)
    found: list[Received] = []
    for start in range(0, len(STREAM), size):
        found += reader.feed(STREAM[start : start + size])
    assert [encode_frame(f) for f in frames(found)] == [bytes.fromhex(t) for t in LINES]
    assert not reader.is_waiting
    assert reader.discarded == 0


@pytest.mark.parametrize("text", LINES)
def test_garbage_before_and_after_does_no_harm(text: str) -> None:
    reader = FrameReader(FROM_MODULE, module=bytes.fromhex(text)[1])
    garbage = bytes.fromhex("00 FF 55 AA 80 7F")
    found = reader.feed(garbage + bytes.fromhex(text) + garbage + bytes.fromhex(text))
    assert [encode_frame(f) for f in frames(found)] == [bytes.fromhex(text)] * 2
    assert reader.discarded == 2 * len(garbage)


@pytest.mark.parametrize("text", LINES)
def test_a_wrong_checksum_costs_only_its_own_frame(text: str) -> None:
    data = bytes.fromhex(text)
    reader = FrameReader(FROM_MODULE, module=data[1])
    found = reader.feed(data[:-1] + bytes((data[-1] ^ 0x80,)) + data)
    assert [encode_frame(f) for f in frames(found)] == [data]
    assert isinstance(found[0], DamagedFrame)
    assert found[0].command == data[3]
    assert reader.damaged >= 1


def test_a_reader_for_one_module_passes_over_the_others() -> None:
    reader = FrameReader(FROM_MODULE, module=12)
    expected = [bytes.fromhex(t) for module, *_, t in REPLIES if module == 12]
    assert [encode_frame(f) for f in frames(reader.feed(STREAM))] == expected


def test_a_master_does_not_hear_its_own_echo() -> None:
    echo = bytes.fromhex(COMMANDS[0][2])
    reader = FrameReader(FROM_MODULE, module=1)
    assert reader.feed(echo + bytes.fromhex(LINES[0])) != []
    assert FrameReader(FROM_MASTER).feed(echo)[0].command == echo[3]


def test_a_length_above_the_cap_is_garbage_at_once() -> None:
    reader = FrameReader(FROM_MODULE, module=12, max_length=50)
    good = bytes.fromhex("07 0C 03 8A 01 00 31 88")
    assert frames(reader.feed(bytes((0x07, 0x0C, 51)) + good)) == [
        Frame(0x07, 12, 0x8A, b"\x01\x00")
    ]


def test_a_length_of_nothing_is_garbage() -> None:
    reader = FrameReader(FROM_MODULE, module=12)
    good = bytes.fromhex("07 0C 03 8A 01 00 31 88")
    assert len(frames(reader.feed(bytes((0x07, 0x0C, 0)) + good))) == 1


def test_a_false_start_hides_a_frame_until_the_line_falls_silent() -> None:
    reader = FrameReader(FROM_MODULE, module=12)
    good = bytes.fromhex("07 0C 03 8A 01 00 31 88")
    assert reader.feed(bytes((0x07, 0x0C, 0xF0)) + good) == []
    assert reader.is_waiting
    assert len(frames(reader.skip_false_start())) == 1
    assert not reader.is_waiting


def test_clearing_forgets_half_a_frame() -> None:
    reader = FrameReader(FROM_MODULE)
    good = bytes.fromhex("07 0C 03 8A 01 00 31 88")
    reader.feed(good[:5])
    reader.clear()
    assert len(frames(reader.feed(good))) == 1
    assert reader.discarded == 5


def test_a_frame_longer_than_its_length_byte_is_refused() -> None:
    assert len(encode_frame(Frame(0x05, 12, 0xE5, bytes(254)))) == 260
    with pytest.raises(MalformedMessage, match="254"):
        encode_frame(Frame(0x05, 12, 0xE5, bytes(255)))


@given(st.binary(max_size=600))
def test_garbage_yields_frames_or_malformed_messages_and_nothing_else(data: bytes) -> None:
    reader = FrameReader(FROM_MODULE)
    found = reader.feed(data)
    found += reader.skip_false_start()
    for frame in frames(found):
        with contextlib.suppress(MalformedMessage):
            decode_reply(frame)
    whole = sum(frame.length + 5 for frame in frames(found))
    assert whole + reader.discarded == len(data)


@given(
    st.sampled_from([0x03, 0x07]),
    st.integers(0, 255),
    st.integers(0, 255),
    st.binary(max_size=254),
    st.integers(1, 40),
)
def test_any_frame_survives_the_wire_in_pieces(
    group: int, module: int, command: int, parameters: bytes, size: int
) -> None:
    frame = Frame(group, module, command, parameters)
    data = encode_frame(frame)
    reader = FrameReader(FROM_MODULE)
    found: list[Received] = []
    for start in range(0, len(data), size):
        found += reader.feed(data[start : start + size])
    assert found == [frame]


@given(st.sampled_from([0x03, 0x07]), st.integers(0, 255), st.binary(max_size=40))
def test_any_frame_with_any_parameters_decodes_or_is_malformed(
    group: int, command: int, parameters: bytes
) -> None:
    frame = Frame(group, 12, command, parameters)
    with contextlib.suppress(MalformedMessage):
        assert encode_reply(12, decode_reply(frame))[3] == command
