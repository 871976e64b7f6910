"""Encoder pulses and joint positions.

The slide counts upwards as it goes down (its overrun limits are -1 mm and +251 mm), while
the kinematics has its height: 0 up, negative down. Scales: Bloch 1994, section 5.3.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cell.geometry import JointPositions

PULSES_PER_UNIT = (872.2222, 444.4444, -380.96, 227.5556)
"""Pulses for each deg, deg, mm upwards, deg."""


def to_pulses(values: Iterable[float]) -> tuple[float, ...]:
    """Return joint positions (deg, deg, mm, deg) in pulses, not rounded."""
    return tuple(v * scale for v, scale in zip(values, PULSES_PER_UNIT, strict=True))


def to_joints(pulses: Sequence[float]) -> JointPositions:
    """Return pulses as joint positions."""
    return JointPositions(
        tuple(p / scale for p, scale in zip(pulses, PULSES_PER_UNIT, strict=True))
    )


def positions_of(words: Sequence[int]) -> tuple[int, ...]:
    """Return the signed positions in eight words, low word first."""
    found = []
    for low, high in zip(words[0::2], words[1::2], strict=True):
        value = low | high << 16
        found.append(value - 0x1_0000_0000 if value & 0x8000_0000 else value)
    return tuple(found)


def words_of(pulses: Iterable[int]) -> tuple[int, ...]:
    """Return positions as words, low word first."""
    words: list[int] = []
    for value in pulses:
        words += (value & 0xFFFF, value >> 16 & 0xFFFF)
    return tuple(words)
