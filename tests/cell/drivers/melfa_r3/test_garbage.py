"""Whatever arrives, the codec gives a record or a DeviceError, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cell.drivers.melfa_r3 import records
from cell.drivers.melfa_r3.codec import LineReader, decode_reply, decode_request
from cell.drivers.melfa_r3.statements import parse_statement
from cell.drivers.melfa_r3.tables import COMMANDS
from cell.errors import DeviceError

PARSERS: list[Callable[[str], object]] = [
    records.parse_axes,
    records.parse_short_state,
    records.parse_full_state,
    records.parse_identity,
    records.parse_alarm,
    records.parse_percent,
    records.parse_word,
    records.parse_word_pair,
    records.parse_variable,
    records.parse_parameter,
    records.parse_hands,
    records.parse_stop_sources,
    parse_statement,
]

SAMPLES = [
    "X;535.21;Y;-0.03;Z;779.78;A;-89.97;B;0.03;C;0.00;;7,0;50;0.00;00000000",
    "A1060;1;0",
    "1;0;50;00;A1060;1;01;;;;;;;;1;REP;START;1;1",
    "FF;FF;7,0;3,5,A;MB5;PRM;RV;CRnX;MELFA;17-10-06;Ver;ENG;C;1;3;8;",
    "900;1;1;-1;-1;-1",
    "P1=(1,2,3,4,5,6)(7,0)",
    "MVS P_CURR*PT TYPE 0,2",
    "M_OUT(8)=1",
]


@st.composite
def mutilated(draw: st.DrawFn) -> str:
    """A sample with a piece of it replaced."""
    sample = draw(st.sampled_from(SAMPLES))
    start = draw(st.integers(0, len(sample)))
    end = draw(st.integers(start, len(sample)))
    alphabet = ";,.()+-*=_0179AFPJeEnaifx \u00b2\u0000"
    return sample[:start] + draw(st.text(alphabet=alphabet, max_size=8)) + sample[end:]


def _reads_or_refuses(parse: Callable[[str], object], data: str) -> None:
    with suppress(DeviceError):
        parse(data)


@pytest.mark.parametrize("parse", PARSERS, ids=[parse.__name__ for parse in PARSERS])
@given(data=mutilated() | st.text(st.characters(max_codepoint=255), max_size=60))
@settings(max_examples=150, deadline=None)
def test_any_data_give_a_record_or_a_device_error(
    parse: Callable[[str], object], data: str
) -> None:
    _reads_or_refuses(parse, data)


@given(line=st.binary(max_size=80))
@settings(deadline=None)
def test_any_line_gives_a_message_or_a_device_error(line: bytes) -> None:
    _reads_or_refuses(lambda text: decode_reply(text.encode("latin-1")), line.decode("latin-1"))
    _reads_or_refuses(lambda text: decode_request(text.encode("latin-1")), line.decode("latin-1"))


@given(
    status=st.sampled_from(["QoK", "Qok", "QeR", "Qer"]),
    data=st.text(st.characters(max_codepoint=255), max_size=40),
)
@settings(deadline=None)
def test_any_data_behind_a_status_give_a_reply_or_a_device_error(status: str, data: str) -> None:
    _reads_or_refuses(lambda text: decode_reply(text.encode("latin-1")), status + data)


@given(command=st.sampled_from(sorted(COMMANDS)), args=st.text(st.characters(max_codepoint=255)))
@settings(deadline=None)
def test_any_arguments_give_a_request_or_a_device_error(command: str, args: str) -> None:
    line = f"1;1;{command}{args}"
    _reads_or_refuses(lambda text: decode_request(text.encode("latin-1")), line)


@given(pieces=st.lists(st.binary(max_size=12) | st.just(b"\r") | st.just(b"\x00\n"), max_size=20))
@settings(deadline=None)
def test_lines_do_not_depend_on_how_the_bytes_were_cut(pieces: list[bytes]) -> None:
    data = b"".join(pieces)
    whole, cut, single = LineReader(24), LineReader(24), LineReader(24)
    expected = whole.feed(data)
    assert [line for piece in pieces for line in cut.feed(piece)] == expected
    assert [line for byte in data for line in single.feed(bytes([byte]))] == expected
    assert all(0 < len(line) <= 25 for line in expected)
