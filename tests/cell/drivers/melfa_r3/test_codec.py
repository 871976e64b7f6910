from __future__ import annotations

import pytest

from cell.drivers.melfa_r3 import tables
from cell.drivers.melfa_r3.codec import (
    MAX_REPLY_BYTES,
    MAX_REQUEST_BYTES,
    GarbledMessage,
    LineReader,
    Reply,
    Request,
    UnsendableRequest,
    decode_reply,
    decode_request,
    encode_reply,
    encode_request,
    encode_text,
)

REQUESTS = [
    (
        Request(1, 1, "OPEN", "=NARCUSR"),
        bytes.fromhex("31 3B 31 3B 4F 50 45 4E 3D 4E 41 52 43 55 53 52 0D"),
    ),
    (Request(1, 1, "CNTLON"), bytes.fromhex("31 3B 31 3B 43 4E 54 4C 4F 4E 0D")),
    (Request(1, 1, "OVRD", "=10"), bytes.fromhex("31 3B 31 3B 4F 56 52 44 3D 31 30 0D")),
    (Request(1, 1, "PPOSF"), bytes.fromhex("31 3B 31 3B 50 50 4F 53 46 0D")),
    (Request(1, 0, "STOP"), b"1;0;STOP\r"),
    (Request(2, 9, "EXEC", "MVS P1 TYPE 0,2"), b"2;9;EXECMVS P1 TYPE 0,2\r"),
    (Request(1, 1, "EXEC", "P1=(1.0,2.0)(7,0)"), b"1;1;EXECP1=(1.0,2.0)(7,0)\r"),
    (Request(1, 1, "EXEC", " MOV P1"), b"1;1;EXEC MOV P1\r"),
    (Request(1, 1, "PPOS", "X"), b"1;1;PPOSX\r"),
    (Request(1, 1, "JPOS", "3"), b"1;1;JPOS3\r"),
    (Request(1, 1, "ERROR"), b"1;1;ERROR\r"),
    (Request(1, 1, "ERRORMES", "5640"), b"1;1;ERRORMES5640\r"),
    (Request(1, 1, "ERRORRD"), b"1;1;ERRORRD\r"),
    (Request(1, 1, "HNDON", "1"), b"1;1;HNDON1\r"),
    (Request(1, 1, "IN", "8"), b"1;1;IN8\r"),
    (Request(1, 1, "OUT", "=5;0001"), b"1;1;OUT=5;0001\r"),
    (Request(1, 1, "IOSIGNAL", "0;0"), b"1;1;IOSIGNAL0;0\r"),
    (Request(1, 1, "VAL", "M_JOVRD;M"), b"1;1;VALM_JOVRD;M\r"),
    (Request(1, 1, "RUN", "WORK;1"), b"1;1;RUNWORK;1\r"),
    (Request(1, 1, "PDIR", "<"), b"1;1;PDIR<\r"),
    (Request(1, 1, "STPSIG"), b"1;1;STPSIG\r"),
]

REPLIES = [
    (Reply(True, False), bytes.fromhex("51 6F 4B 0D")),
    (Reply(True, False, 0, "10"), bytes.fromhex("51 6F 4B 31 30 0D")),
    (Reply(False, False, tables.BUSY), bytes.fromhex("51 65 52 35 36 34 30 0D")),
    (Reply(True, True), b"Qok\r"),
    (Reply(True, True, 0, "0060;H"), b"Qok0060;H\r"),
    (Reply(False, True, 60), b"Qer0060\r"),
    (Reply(False, True, 2602, "3"), b"Qer2602;3\r"),
    (
        Reply(
            True, False, 0, "X;535.21;Y;-0.03;Z;779.78;A;-89.97;B;0.03;C;0.00;;7,0;50;0.00;00000000"
        ),
        b"QoKX;535.21;Y;-0.03;Z;779.78;A;-89.97;B;0.03;C;0.00;;7,0;50;0.00;00000000\r",
    ),
]


@pytest.mark.parametrize(("request_", "data"), REQUESTS, ids=[d.decode() for _, d in REQUESTS])
def test_a_request_and_its_bytes_are_the_same_both_ways(request_: Request, data: bytes) -> None:
    assert encode_request(request_) == data
    assert decode_request(data[:-1]) == request_


@pytest.mark.parametrize(("reply", "data"), REPLIES, ids=[d.decode() for _, d in REPLIES])
def test_a_reply_and_its_bytes_are_the_same_both_ways(reply: Reply, data: bytes) -> None:
    assert encode_reply(reply) == data
    assert decode_reply(data[:-1]) == reply


@pytest.mark.parametrize("data", [d for _, d in REQUESTS + REPLIES])
def test_a_line_is_the_same_in_one_piece_and_byte_by_byte(data: bytes) -> None:
    whole, piecewise = LineReader(MAX_REPLY_BYTES), LineReader(MAX_REPLY_BYTES)
    expected = [data[:-1]]
    assert whole.feed(data) == expected
    assert [line for byte in data for line in piecewise.feed(bytes([byte]))] == expected


def test_what_follows_a_line_waits_for_its_own_end() -> None:
    reader = LineReader(MAX_REPLY_BYTES)
    assert reader.feed(b"QoK10\rQoK2") == [b"QoK10"]
    assert reader.pending == b"QoK2"
    assert reader.feed(b"0\r") == [b"QoK20"]


@pytest.mark.parametrize("data", [b"\x00QoK\r", b"\nQoK\r", b"QoK\n\r", b"QoK\x00\r", b"\r\rQoK\r"])
def test_stray_ends_around_a_line_are_dropped(data: bytes) -> None:
    reader = LineReader(MAX_REPLY_BYTES)
    assert reader.feed(data) == [b"QoK"]
    assert [line for byte in data for line in reader.feed(bytes([byte]))] == [b"QoK"]


def test_a_cleared_reader_forgets_the_line_that_has_begun() -> None:
    reader = LineReader(MAX_REPLY_BYTES)
    reader.feed(b"Qo")
    reader.clear()
    assert reader.feed(b"QoK\r") == [b"QoK"]


def test_an_endless_line_stays_bounded_and_is_no_message() -> None:
    reader = LineReader(MAX_REQUEST_BYTES)
    for _ in range(100):
        assert reader.feed(b"1;1;" + b"A" * 1000) == []
        assert len(reader.pending) <= MAX_REQUEST_BYTES + 1
    (line,) = reader.feed(b"\r")
    with pytest.raises(GarbledMessage, match="longer than 256"):
        decode_request(line)


def test_an_endless_reply_is_no_message() -> None:
    reader = LineReader(MAX_REPLY_BYTES)
    (line,) = reader.feed(b"QoK" + b"1" * 10_000 + b"\r")
    with pytest.raises(GarbledMessage):
        decode_reply(line)


@pytest.mark.parametrize(
    "line",
    [b"", b"QoK", b"1;PPOSF", b"1;1;", b"1;1;NONSENSE", b"x;1;PPOSF", b"1;1;pposf", b"-1;1;STOP"],
)
def test_what_is_no_request_is_refused(line: bytes) -> None:
    with pytest.raises(GarbledMessage):
        decode_request(line)


@pytest.mark.parametrize(
    "line", [b"", b"Q", b"QOK", b"qok", b"QeR", b"QeRxx", b"QeR-1", b" QoK", b"?"]
)
def test_what_is_no_reply_is_refused(line: bytes) -> None:
    with pytest.raises(GarbledMessage):
        decode_reply(line)


@pytest.mark.parametrize("data", [b";;STOP", b"1;;STOP", b";1;STOP"])
def test_robot_and_slot_left_out_are_one(data: bytes) -> None:
    assert decode_request(data) == Request(1, 1, "STOP")


@pytest.mark.parametrize("text", ["1;1;EXECP1=\r1;1;SRVON", "1;1;ä", "1;1;\n", "1;1;" + "A" * 260])
def test_what_cannot_be_sent_is_refused(text: str) -> None:
    with pytest.raises(UnsendableRequest, match="correct the value"):
        encode_text(text)


@pytest.mark.parametrize("command", sorted(tables.COMMANDS))
def test_every_command_is_read_back_as_itself(command: str) -> None:
    request = Request(1, 1, command, "")
    assert decode_request(encode_request(request)[:-1]) == request
