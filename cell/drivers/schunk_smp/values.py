"""Parameters: single floats and the values of registers, little-endian."""

from __future__ import annotations

import struct

from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.tables import REGISTER_TYPES, Code, ValueType

_SINGLE = struct.Struct("<f")
_INTEGERS: dict[ValueType, struct.Struct] = {
    "u8": struct.Struct("<B"),
    "u16": struct.Struct("<H"),
    "u32": struct.Struct("<I"),
}


def pack_floats(*values: float | None) -> bytes:
    """Return values as single floats up to the first None.

    Raises:
        MalformedMessage: A value follows one that was left out, or does not fit a single float.
    """
    packed = b""
    is_ended = False
    for value in values:
        if value is None:
            is_ended = True
        elif is_ended:
            raise MalformedMessage(
                "a parameter follows one that was left out", code=Code.WRONG_PARAMETER
            )
        else:
            packed += _pack(_SINGLE, value)
    return packed


def floats(data: bytes) -> tuple[float, ...]:
    """Return the single floats in `data`, whose length is a multiple of four."""
    return tuple(value for (value,) in _SINGLE.iter_unpack(data))


def pack_register(register: int, value: float) -> bytes:
    """Return a register's value as bytes of the register's type.

    Raises:
        MalformedMessage: There is no such register, or the value does not fit.
    """
    kind = _type_of(register)
    if kind == "f32":
        return _pack(_SINGLE, value)
    if value != int(value):
        raise MalformedMessage(
            f"register {register:#04x} takes whole numbers, not {value}", code=Code.WRONG_PARAMETER
        )
    return _pack(_INTEGERS[kind], int(value))


def unpack_register(register: int, data: bytes) -> float:
    """Return a register's value; a whole number where the register holds one.

    Raises:
        MalformedMessage: There is no such register, or `data` has the wrong length.
    """
    kind = _type_of(register)
    layout = _SINGLE if kind == "f32" else _INTEGERS[kind]
    if len(data) != layout.size:
        raise MalformedMessage(
            f"register {register:#04x} has {layout.size} bytes, not {len(data)}",
            code=Code.MESSAGE_LENGTH,
        )
    value: float = layout.unpack(data)[0]
    return value


def _type_of(register: int) -> ValueType:
    kind = REGISTER_TYPES.get(register)
    if kind is None:
        raise MalformedMessage(f"there is no register {register:#04x}", code=Code.WRONG_PARAMETER)
    return kind


def _pack(layout: struct.Struct, value: float) -> bytes:
    try:
        return layout.pack(value)
    except (struct.error, OverflowError) as error:
        raise MalformedMessage(
            f"{value} does not fit {layout.size} bytes", code=Code.WRONG_PARAMETER
        ) from error
