from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sessions.wire.lines import LineReader, Overflow
from tests.sessions.wire.tables import STEADY


@pytest.mark.parametrize(
    ("data", "items"),
    [
        (b"STATUS\n", [b"STATUS"]),
        (b"STATUS\r\n", [b"STATUS"]),
        (b"STATUS", []),
        (b"\n\r\n\n", []),
        (b"A\nB\r\nC\n", [b"A", b"B", b"C"]),
        (b"A\r\r\n", [b"A\r"]),
        (b"A\rB\n", [b"A\rB"]),
        (b"0123456789\n", [b"0123456789"]),
        (b"0123456789\r\n", [b"0123456789"]),
        (b"0123456789\r", []),
        (b"0123456789A\nB\n", [Overflow(b"0123456789A"), b"B"]),
        (b"0123456789AB", [Overflow(b"0123456789A")]),
        (b"0123456789ABCDEF\nB\n", [Overflow(b"0123456789A"), b"B"]),
        (b"0123456789\rA\nB\n", [Overflow(b"0123456789\r"), b"B"]),
    ],
)
def test_bytes_become_lines_whole_and_byte_by_byte(
    data: bytes, items: list[bytes | Overflow]
) -> None:
    whole, drop_by_drop = LineReader(10), LineReader(10)

    assert whole.feed(data) == items
    assert [item for byte in data for item in drop_by_drop.feed(bytes([byte]))] == items


def test_an_endless_line_is_told_once_and_costs_no_memory() -> None:
    reader = LineReader(100)
    items = [item for _ in range(1000) for item in reader.feed(b"x" * 1000)]

    assert items == [Overflow(b"x" * 101)]
    assert reader.pending_bytes == 0
    assert reader.feed(b"tail\nSTATUS\n") == [b"STATUS"]


@STEADY
@given(st.binary(max_size=200), st.lists(st.integers(0, 200), max_size=8))
def test_how_the_bytes_are_cut_makes_no_difference(data: bytes, cuts: list[int]) -> None:
    cut_reader = LineReader(20)
    edges = [0, *sorted(cuts), len(data)]
    pieces = [data[a:b] for a, b in zip(edges, edges[1:], strict=False)]

    assert [i for piece in pieces for i in cut_reader.feed(piece)] == LineReader(20).feed(data)
