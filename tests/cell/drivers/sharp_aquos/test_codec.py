import pytest
from hypothesis import given
from hypothesis import strategies as st

from cell.drivers.sharp_aquos.codec import (
    CommandRecord,
    Done,
    LineReader,
    LinkCheck,
    MalformedLine,
    Padding,
    Query,
    Refused,
    ReplyRecord,
    Set,
    Value,
    asks_for_text,
    decode_command,
    decode_reply,
    encode_command,
    encode_reply,
)
from cell.drivers.sharp_aquos.tables import RANGES, Word

EXCHANGES: list[tuple[CommandRecord, str, ReplyRecord, str]] = [
    (Set(Word.POWER, 1), "50 4F 57 52 31 20 20 20 0D", Done(), "4F 4B 0D"),
    (Set(Word.INPUT, 1), "49 41 56 44 31 20 20 20 0D", Done(), "4F 4B 0D"),
    (Set(Word.VOLUME, 30), "56 4F 4C 4D 33 30 20 20 0D", Done(), "4F 4B 0D"),
    (Query(Word.POWER), "50 4F 57 52 3F 3F 3F 3F 0D", Value("1"), "31 0D"),
    (LinkCheck(), "41 0D", Refused(), "45 52 52 0D"),
]


@pytest.mark.parametrize(("command", "request_text", "reply", "reply_text"), EXCHANGES, ids=str)
def test_a_worked_exchange_reads_and_writes(
    command: CommandRecord, request_text: str, reply: ReplyRecord, reply_text: str
) -> None:
    request = bytes.fromhex(request_text)
    answer = bytes.fromhex(reply_text)
    assert encode_command(command) == request
    assert decode_command(request[:-1]) == command
    assert encode_reply(reply) == answer
    assert decode_reply(answer[:-1]) == reply


@pytest.mark.parametrize("word", list(Word))
def test_every_word_survives_the_wire_with_every_padding(word: Word) -> None:
    paddings: tuple[Padding, ...] = ("spaces", "three digits", "four digits")
    for value in {RANGES[word].least, RANGES[word].most}:
        for padding in paddings:
            line = encode_command(Set(word, value), padding)
            assert len(line) == 9
            assert decode_command(line[:-1]) == Set(word, value)
    assert decode_command(encode_command(Query(word))[:-1]) == Query(word)


@pytest.mark.parametrize(
    ("padding", "line"),
    [("spaces", b"VOLM30  \r"), ("three digits", b"VOLM030 \r"), ("four digits", b"VOLM0030\r")],
)
def test_numbers_are_padded_as_the_settings_say(padding: Padding, line: bytes) -> None:
    assert encode_command(Set(Word.VOLUME, 30), padding) == line


@pytest.mark.parametrize("line", [b"POWR?   ", b"POWR????", b"POWR   ?"])
def test_a_query_may_be_padded_with_blanks_or_question_marks(line: bytes) -> None:
    assert decode_command(line) == Query(Word.POWER)


def test_a_number_may_be_negative() -> None:
    assert decode_command(b"HPOS-10 ") == Set(Word.HORIZONTAL_POSITION, -10)


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"POWR1",
        b"POWR1    ",
        b"XXXX1   ",
        b"POWR    ",
        b"POWRon  ",
        b"POWR1-1 ",
        b"powr1   ",
        b"\xff\xff\xff\xff1   ",
        b"VOLM\xb2   ",
    ],
)
def test_a_line_that_is_no_command_is_told_so(line: bytes) -> None:
    with pytest.raises(MalformedLine):
        decode_command(line)


@pytest.mark.parametrize("line", [b"", b"  ", b"\x00\x01", b"\xcfK"])
def test_a_line_that_is_no_reply_is_told_so(line: bytes) -> None:
    with pytest.raises(MalformedLine):
        decode_reply(line)


def test_a_number_too_long_for_its_field_is_not_sent() -> None:
    with pytest.raises(MalformedLine, match="12345"):
        encode_command(Set(Word.VOLUME, 12345))


def test_who_asks_for_a_text_does_not_expect_ok() -> None:
    assert asks_for_text(Query(Word.VOLUME))
    assert asks_for_text(Set(Word.MODEL, 1))
    assert not asks_for_text(Set(Word.VOLUME, 1))
    assert not asks_for_text(LinkCheck())


@pytest.mark.parametrize("size", [1, 2, 5, 100])
def test_lines_are_found_in_pieces_of_any_size(size: int) -> None:
    data = b"OK\rERR\r\n1\r"
    reader = LineReader()
    lines: list[bytes] = []
    for start in range(0, len(data), size):
        lines += reader.feed(data[start : start + size])
    assert lines == [b"OK", b"ERR", b"1"]


def test_a_line_without_an_end_is_dropped_and_counted() -> None:
    reader = LineReader()
    assert reader.feed(b"x" * 1000) == []
    assert reader.feed(b"yy\rOK\r") == [b"OK"]
    assert reader.discarded == 1002


@given(st.lists(st.binary(max_size=30), max_size=20))
def test_garbage_yields_records_or_malformed_lines_and_nothing_else(pieces: list[bytes]) -> None:
    reader = LineReader()
    lines = [line for piece in pieces for line in reader.feed(piece)]
    outcomes = 0
    for line in lines:
        for decode in (decode_command, decode_reply):
            try:
                decode(line)
            except MalformedLine:
                outcomes += 1
            else:
                outcomes += 1
    assert outcomes == 2 * len(lines)
    assert all(len(line) <= 64 for line in lines)
