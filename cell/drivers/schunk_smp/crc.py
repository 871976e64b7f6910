"""CRC-16/ARC: reflected polynomial 0xA001, start 0x0000, no final XOR.

Not the Modbus checksum, which starts at 0xFFFF.
"""

from __future__ import annotations


def _table() -> tuple[int, ...]:
    entries = []
    for byte in range(256):
        value = byte
        for _ in range(8):
            value = (value >> 1) ^ 0xA001 if value & 1 else value >> 1
        entries.append(value)
    return tuple(entries)


_TABLE = _table()


def crc16(data: bytes | bytearray | memoryview) -> int:
    """Return the checksum of `data`, 0 to 0xFFFF; of `b"123456789"` it is 0xBB3D."""
    value = 0
    table = _TABLE
    for byte in data:
        value = (value >> 8) ^ table[(value ^ byte) & 0xFF]
    return value
