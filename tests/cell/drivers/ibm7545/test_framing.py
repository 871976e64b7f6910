"""The bridge's bytes: as documented, there and back, and among garbage."""

from __future__ import annotations

import random
from binascii import crc_hqx

import pytest

from cell.drivers.ibm7545.framing import (
    REPLY,
    REQUEST,
    Acknowledge,
    Await,
    FrameReader,
    MalformedFrame,
    Read,
    Reply,
    Step,
    Write,
    decode_reply,
    decode_steps,
    encode_reply,
    encode_request,
    encode_steps,
)

EXAMPLES: list[tuple[Step, str]] = [
    (Read(0x10, 8), "01 10 00 08"),
    (Write(0x40, (0x800, 0xFFFF)), "02 40 00 02 00 08 ff ff"),
    (Await(0x04, 1, 0, 0x08, 50), "03 04 00 01 00 00 00 08 00 32 00"),
    (Acknowledge(), "04"),
]


@pytest.mark.parametrize(("step", "text"), EXAMPLES)
def test_a_step_is_as_documented(step: Step, text: str) -> None:
    assert encode_steps((step,)) == bytes.fromhex(text)
    assert decode_steps(bytes.fromhex(text)) == (step,)


def test_a_request_is_as_documented() -> None:
    head = bytes.fromhex("a5 07 04 00 01 10 00 08")
    assert encode_request(7, (Read(0x10, 8),)) == head + crc_hqx(head, 0xFFFF).to_bytes(2, "little")


def test_many_steps_come_back_in_their_order() -> None:
    steps = tuple(step for step, _ in EXAMPLES)
    assert decode_steps(encode_steps(steps)) == steps


@pytest.mark.parametrize("text", ["01 10", "02 40 00 02 00 08", "03 04 00", "09"])
def test_steps_cut_off_or_unknown_are_malformed(text: str) -> None:
    with pytest.raises(MalformedFrame):
        decode_steps(bytes.fromhex(text))


@pytest.mark.parametrize("body", [b"", b"\x00", b"\x00\x00\x01"])
def test_a_reply_cut_off_is_malformed(body: bytes) -> None:
    with pytest.raises(MalformedFrame, match="cut off"):
        decode_reply(1, body)


@pytest.mark.parametrize("seed", range(5))
def test_replies_are_found_among_garbage_however_they_are_cut(seed: int) -> None:
    source = random.Random(seed)
    replies = [
        Reply(n, 0, source.randrange(4), tuple(source.randrange(0x10000) for _ in range(n % 9)))
        for n in range(20)
    ]
    stream = b"".join(
        source.randbytes(source.randrange(4)).replace(b"\x5a", b"\x00") + encode_reply(reply)
        for reply in replies
    )
    reader, found = FrameReader(REPLY), []
    while stream:
        size = source.randrange(1, 12)
        found += [decode_reply(number, body) for number, body in reader.feed(stream[:size])]
        stream = stream[size:]
    assert found == replies, seed


@pytest.mark.parametrize("seed", range(5))
def test_no_single_turned_bit_passes_the_checksum(seed: int) -> None:
    source = random.Random(seed)
    frame = encode_request(3, (Read(0x10, 8), Write(0x40, (1, 2, 3, 4))))
    for at in range(len(frame)):
        turned = bytearray(frame)
        turned[at] ^= 1 << source.randrange(8)
        assert FrameReader(REQUEST).feed(bytes(turned)) == [], (seed, at)
