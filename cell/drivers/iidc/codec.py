"""The 32-bit words of IIDC feature registers, to records and back.

Bit 0 is the most significant one, as in the standard.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

_FIELD = 0xFFF


def _bit(number: int) -> int:
    return 1 << (31 - number)


_PRESENCE = _bit(0)
_ABSOLUTE = _bit(1)
_INQUIRY_ONE_PUSH = _bit(3)
_INQUIRY_READABLE = _bit(4)
_INQUIRY_ON_OFF = _bit(5)
_INQUIRY_AUTO = _bit(6)
_INQUIRY_MANUAL = _bit(7)
_ONE_PUSH = _bit(5)
_ON = _bit(6)
_AUTO = _bit(7)


@dataclass(frozen=True, slots=True, kw_only=True)
class InquiryWord:
    """What a feature can do: the word of its inquiry register."""

    is_present: bool
    has_absolute: bool = False
    has_one_push: bool = False
    is_readable: bool = True
    has_on_off: bool = False
    has_auto: bool = False
    has_manual: bool = True
    raw_min: int = 0
    raw_max: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlWord:
    """How a feature is set: the word of its control register.

    Attributes:
        is_present: Whether the camera has the feature.
        is_absolute: Whether the absolute value rules.
        is_one_push: Whether the camera is setting it once.
        is_on: Whether the feature is on.
        is_auto: Whether the camera sets it.
        value: Bits 20 to 31: the raw value; white balance keeps V (red) here.
        high_value: Bits 8 to 19: white balance keeps U (blue) here.
    """

    is_present: bool = True
    is_absolute: bool = False
    is_one_push: bool = False
    is_on: bool = True
    is_auto: bool = False
    value: int = 0
    high_value: int = 0


def decode_inquiry(word: int) -> InquiryWord:
    """Return the record of an inquiry word."""
    return InquiryWord(
        is_present=bool(word & _PRESENCE),
        has_absolute=bool(word & _ABSOLUTE),
        has_one_push=bool(word & _INQUIRY_ONE_PUSH),
        is_readable=bool(word & _INQUIRY_READABLE),
        has_on_off=bool(word & _INQUIRY_ON_OFF),
        has_auto=bool(word & _INQUIRY_AUTO),
        has_manual=bool(word & _INQUIRY_MANUAL),
        raw_min=word >> 12 & _FIELD,
        raw_max=word & _FIELD,
    )


def encode_inquiry(inquiry: InquiryWord) -> int:
    """Return the inquiry word of a record.

    Raises:
        ValueError: A limit has more than twelve bits.
    """
    flags = (
        (inquiry.is_present, _PRESENCE),
        (inquiry.has_absolute, _ABSOLUTE),
        (inquiry.has_one_push, _INQUIRY_ONE_PUSH),
        (inquiry.is_readable, _INQUIRY_READABLE),
        (inquiry.has_on_off, _INQUIRY_ON_OFF),
        (inquiry.has_auto, _INQUIRY_AUTO),
        (inquiry.has_manual, _INQUIRY_MANUAL),
    )
    bits = sum(bit for is_set, bit in flags if is_set)
    return bits | _field(inquiry.raw_min) << 12 | _field(inquiry.raw_max)


def decode_control(word: int) -> ControlWord:
    """Return the record of a control word."""
    return ControlWord(
        is_present=bool(word & _PRESENCE),
        is_absolute=bool(word & _ABSOLUTE),
        is_one_push=bool(word & _ONE_PUSH),
        is_on=bool(word & _ON),
        is_auto=bool(word & _AUTO),
        high_value=word >> 12 & _FIELD,
        value=word & _FIELD,
    )


def encode_control(control: ControlWord) -> int:
    """Return the control word of a record.

    Raises:
        ValueError: A value has more than twelve bits.
    """
    flags = (
        (control.is_present, _PRESENCE),
        (control.is_absolute, _ABSOLUTE),
        (control.is_one_push, _ONE_PUSH),
        (control.is_on, _ON),
        (control.is_auto, _AUTO),
    )
    bits = sum(bit for is_set, bit in flags if is_set)
    return bits | _field(control.high_value) << 12 | _field(control.value)


def decode_absolute(word: int) -> float:
    """Return the IEEE 754 single of a word, as the shortest decimal that names it.

    So a figure of up to six digits that was written comes back exactly.
    """
    (value,) = struct.unpack(">f", struct.pack(">I", word))
    for digits in range(1, 10):
        short = float(f"{value:.{digits}g}")
        if encode_absolute(short) == word:
            return short
    return float(value)


def encode_absolute(value: float) -> int:
    """Return the word of a number as IEEE 754 single.

    Raises:
        OverflowError: The number is too large for a single.
    """
    (word,) = struct.unpack(">I", struct.pack(">f", value))
    return int(word)


def decode_bytes(quadlet: bytes) -> int:
    """Return the word of four bytes as they travel, most significant first.

    Raises:
        struct.error: There are not four of them.
    """
    (word,) = struct.unpack(">I", quadlet)
    return int(word)


def encode_bytes(word: int) -> bytes:
    """Return the four bytes of a word as they travel."""
    return struct.pack(">I", word)


def _field(value: int) -> int:
    if not 0 <= value <= _FIELD:
        raise ValueError(f"{value} does not fit into twelve bits (0 to {_FIELD})")
    return value
