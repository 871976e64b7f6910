from __future__ import annotations

import struct

import pytest

from cell.drivers.iidc.codec import (
    ControlWord,
    InquiryWord,
    decode_absolute,
    decode_bytes,
    decode_control,
    decode_inquiry,
    encode_absolute,
    encode_bytes,
    encode_control,
    encode_inquiry,
)

CONTROLS = [
    pytest.param(ControlWord(value=0x200), 0x82000200, id="gain 0x200 by hand"),
    pytest.param(ControlWord(is_auto=True), 0x83000000, id="automatic shutter"),
    pytest.param(ControlWord(is_absolute=True), 0xC2000000, id="absolute control on"),
    pytest.param(
        ControlWord(high_value=500, value=850), 0x821F4352, id="white balance U 500, V 850"
    ),
    pytest.param(ControlWord(is_on=False, value=1), 0x80000001, id="off"),
    pytest.param(ControlWord(is_one_push=True), 0x86000000, id="one-push"),
    pytest.param(ControlWord(is_present=False, is_on=False), 0x00000000, id="no such feature"),
]

INQUIRIES = [
    pytest.param(
        InquiryWord(
            is_present=True,
            has_absolute=True,
            has_one_push=True,
            has_on_off=True,
            has_auto=True,
            raw_max=1023,
        ),
        0xDF0003FF,
        id="everything, 0 to 1023",
    ),
    pytest.param(
        InquiryWord(is_present=True, raw_min=512, raw_max=4095), 0x89200FFF, id="512 to 4095"
    ),
]


@pytest.mark.parametrize(("record", "word"), CONTROLS)
def test_control_words_both_ways(record: ControlWord, word: int) -> None:
    assert encode_control(record) == word
    assert decode_control(word) == record


@pytest.mark.parametrize(("record", "word"), INQUIRIES)
def test_inquiry_words_both_ways(record: InquiryWord, word: int) -> None:
    assert encode_inquiry(record) == word
    assert decode_inquiry(word) == record


@pytest.mark.parametrize("value", [-1, 4096])
def test_value_of_more_than_twelve_bits_is_refused(value: int) -> None:
    with pytest.raises(ValueError, match="twelve bits"):
        encode_control(ControlWord(value=value))


@pytest.mark.parametrize(
    ("value", "word"), [(1.0, 0x3F800000), (-4.012, 0xC08062 << 8 | 0x4E), (0.0, 0)]
)
def test_absolute_values_are_ieee_singles(value: float, word: int) -> None:
    assert encode_absolute(value) == word
    assert decode_absolute(word) == value


@pytest.mark.parametrize("value", [0.01602, 0.149869, 0.172678, 1.757, 9.678, 1e-5, 4 / 7.5])
def test_figure_of_the_profile_survives_the_register(value: float) -> None:
    read = decode_absolute(encode_absolute(value))
    assert read == pytest.approx(value, rel=1e-7)
    assert len(repr(value)) > 9 or read == value


def test_bytes_travel_most_significant_first() -> None:
    assert encode_bytes(0x82000200) == b"\x82\x00\x02\x00"
    assert decode_bytes(b"\x82\x1f\x43\x52") == 0x821F4352
    with pytest.raises(struct.error):
        decode_bytes(b"\x82\x1f\x43")
