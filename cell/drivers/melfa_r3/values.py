"""Alarms, override, signals, variables, parameters and hands: the data of short replies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.drivers.melfa_r3.fields import whole_field


def parse_alarm(data: str) -> tuple[int, str] | None:
    """Read the data of an ERROR reply: number and level, None when no alarm is active.

    Raises:
        GarbledMessage: The data hold no number.
    """
    if not data.strip(";"):
        return None
    number, _, level = data.partition(";")
    try:
        return whole_field(number), level.rstrip(";")
    except ValueError as error:
        raise GarbledMessage(f"the alarm reads {data[:80]!r}") from error


def print_alarm(alarm: tuple[int, str] | None) -> str:
    """Return the data of an ERROR reply."""
    return "" if alarm is None else f"{alarm[0]:04d};{alarm[1]}"


def parse_percent(data: str) -> int:
    """Read the data of an OVRD reply.

    Raises:
        GarbledMessage: The data are no whole number.
    """
    try:
        return whole_field(data)
    except ValueError as error:
        raise GarbledMessage(f"the override reads {data[:80]!r}") from error


def parse_word(data: str) -> int:
    """Read the data of an OUT or IN reply: 16 signals, the first one in bit 0.

    Raises:
        GarbledMessage: The data are not four hexadecimal digits.
    """
    return _hex_words(data, 1)[0]


def parse_word_pair(data: str) -> tuple[int, int]:
    """Read the data of an IOSIGNAL reply: 16 inputs and 16 outputs.

    Raises:
        GarbledMessage: The data are not eight hexadecimal digits.
    """
    inputs, outputs = _hex_words(data, 2)
    return inputs, outputs


def print_words(*words: int) -> str:
    """Return the data of an OUT, IN or IOSIGNAL reply."""
    return "".join([f"{word:04X}" for word in words])


def parse_variable(data: str) -> tuple[str, str]:
    """Read the data of a VAL reply: name and value as printed.

    Raises:
        GarbledMessage: The data hold no `=`.
    """
    name, equals, value = data.partition("=")
    if not equals or not name:
        raise GarbledMessage(f"the variable reads {data[:80]!r}")
    return name, value


def parse_parameter(data: str) -> tuple[str, tuple[str, ...]]:
    """Read the data of a PNR reply: name and values.

    Raises:
        GarbledMessage: The data hold no `;`.
    """
    name, semicolon, values = data.partition(";")
    if not semicolon or not name:
        raise GarbledMessage(f"the parameter reads {data[:80]!r}")
    return name, tuple([value.strip() for value in values.split(",")])


def print_parameter(name: str, values: Sequence[str]) -> str:
    """Return the data of a PNR reply."""
    return f"{name};{', '.join(values)}"


class HandState(NamedTuple):
    """One hand in the reply to HNDSTS.

    Attributes:
        output: Number of its output, -1 for unused.
        status: 1 open, 2 closed.
        solenoids: 0 single, 1 double solenoid.
    """

    output: int
    status: int
    solenoids: int


def parse_hands(data: str) -> tuple[HandState, ...]:
    """Read the data of a HNDSTS reply.

    Raises:
        GarbledMessage: The data are not whole triples of numbers.
    """
    fields = data.removesuffix(";").split(";")
    try:
        numbers = [int(field) for field in fields]
    except ValueError as error:
        raise GarbledMessage(f"the hands read {data[:120]!r}") from error
    if len(numbers) % 3:
        raise GarbledMessage(f"the hands read {data[:120]!r}")
    return tuple([HandState(*numbers[i : i + 3]) for i in range(0, len(numbers), 3)])


def print_hands(hands: Sequence[HandState]) -> str:
    """Return the data of a HNDSTS reply."""
    return ";".join([f"{hand.output};{hand.status};{hand.solenoids}" for hand in hands])


class StopSources(NamedTuple):
    """Reply to STPSIG: who holds the arm (one source only).

    Attributes:
        stops: Stop signals: bits pendant, computer, input, panel from bit 0 up.
        emergencies: Emergency stops: bits input, panel, pendant from bit 0 up.
    """

    stops: int
    emergencies: int


def parse_stop_sources(data: str) -> StopSources:
    """Read the data of a STPSIG reply: two hexadecimal digits one character apart.

    Raises:
        GarbledMessage: The data have another layout.
    """
    try:
        return StopSources(int(data[0:1], 16), int(data[2:3], 16))
    except ValueError as error:
        raise GarbledMessage(f"the stop sources read {data[:80]!r}") from error


def print_stop_sources(sources: StopSources) -> str:
    """Return the data of a STPSIG reply."""
    return f"{sources.stops:X};{sources.emergencies:X}"


def _hex_words(data: str, count: int) -> list[int]:
    try:
        if len(data) != 4 * count:
            raise ValueError(data)
        return [int(data[i : i + 4], 16) for i in range(0, len(data), 4)]
    except ValueError as error:
        raise GarbledMessage(f"the signals read {data[:80]!r}") from error
