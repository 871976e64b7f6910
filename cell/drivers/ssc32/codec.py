"""SSC-32 commands to bytes and back, and what its replies mean; no I/O.

Case does not matter, spaces, tabs and line feeds are nothing, nothing happens before the
carriage return, and ESC takes back what was said of a line. The same questions are asked
again and again, so what was encoded or decoded lately is remembered.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from typing import assert_never

from cell.drivers.ssc32 import tables
from cell.drivers.ssc32.commands import (
    Command,
    Move,
    QueryMoving,
    QueryPulses,
    QueryVersion,
    ReadAnalogues,
    ReadInputs,
    ServoTarget,
    SetBanks,
    SetOffsets,
    SetOutputs,
    StopServo,
)
from cell.errors import DeviceError

_TARGET = re.compile(r"#(\d{1,5})P(\d{1,5})(?:S(\d{1,5}))?")
_MOVE = re.compile(rf"((?:{_TARGET.pattern})+)(?:T(\d{{1,5}}))?")
_OFFSET = re.compile(r"#(\d{1,5})PO([+-]?\d{1,5})")
_OUTPUT = re.compile(r"#(\d{1,5})([HL])")
_BANK = re.compile(r"#(\d{1,5}):(\d{1,5})")
_PULSE = re.compile(r"QP(\d{1,5})")
_INPUT = re.compile(r"([A-F])(L?)")
_ANALOGUE = re.compile(r"V([A-H])")
_PLAIN = re.compile(rb"[#0-9:A-Z+-]{0,200}\r")
"""One whole line that needs no cleaning, as this driver sends it."""
_STOP = re.compile(r"STOP(\d{1,5})")


class BadCommand(DeviceError):
    """A command that the controller does not know, or with a figure out of range."""

    def __init__(self, problem: str, *, device: str = "servo controller") -> None:
        super().__init__(device, problem)


class LineReader:
    """Gathers a controller's incoming bytes to lines, upper case, without blanks."""

    def __init__(self) -> None:
        self._line = bytearray()
        self._is_too_long = False

    def feed(self, data: bytes) -> list[str]:
        """Return the lines that `data` completes; too long ones are dropped whole."""
        if not self._line and not self._is_too_long and _PLAIN.fullmatch(data):
            return [data[:-1].decode("ascii")]
        lines = []
        for byte in data:
            if byte == tables.CARRIAGE_RETURN:
                if not self._is_too_long:
                    lines.append(self._line.upper().decode("latin-1"))
                self.clear()
            elif byte == tables.ESCAPE:
                self.clear()
            elif byte not in tables.IGNORED:
                if len(self._line) >= tables.MAX_LINE_BYTES:
                    self._is_too_long = True
                else:
                    self._line.append(byte)
        return lines

    def clear(self) -> None:
        """Forget what was gathered of a line."""
        self._line.clear()
        self._is_too_long = False


@lru_cache(maxsize=256)
def encode(command: Command) -> bytes:
    """Return the bytes of a command, its carriage return included.

    Raises:
        BadCommand: A figure is out of the protocol's range.
    """
    _check(command)
    return f"{_text(command)}\r".encode("ascii")


@lru_cache(maxsize=256)
def decode(line: str) -> Command:
    """Return the command of a line as `LineReader` gives it.

    Raises:
        BadCommand: It is none, or a figure is out of range.
    """
    command = _parse(line)
    if command is None:
        raise BadCommand(f"{line[:40]!r} is no command")
    _check(command)
    return command


def decode_moving(reply: bytes) -> bool:
    """Return whether a reply to `Q` says that servos are moving.

    Raises:
        BadCommand: It is neither `.` nor `+`.
    """
    if reply not in (tables.FINISHED, tables.MOVING):
        raise BadCommand(f"answered {reply!r} to Q; allowed are '.' and '+'")
    return reply == tables.MOVING


def decode_pulses(reply: bytes) -> tuple[int, ...]:
    """Return pulse widths in us, 0 for a channel that was never moved, to within 10 us.

    Raises:
        BadCommand: A byte is no pulse width.
    """
    pulses = tuple(byte * tables.QUERY_UNIT_US for byte in reply)
    for pulse in pulses:
        if pulse and not tables.LEAST_PULSE_US <= pulse <= tables.GREATEST_PULSE_US:
            raise BadCommand(
                f"answered a pulse width of {pulse} us; allowed are 0 and "
                f"{tables.LEAST_PULSE_US} to {tables.GREATEST_PULSE_US}"
            )
    return pulses


def decode_inputs(reply: bytes) -> tuple[bool, ...]:
    """Return whether each input of a reply is high.

    Raises:
        BadCommand: A byte is neither `0` nor `1`.
    """
    if any(byte not in b"01" for byte in reply):
        raise BadCommand(f"answered {reply!r} for inputs; allowed are '0' and '1'")
    return tuple(byte == ord("1") for byte in reply)


def decode_volts(reply: bytes) -> tuple[float, ...]:
    """Return the voltages of a reply."""
    return tuple(byte / tables.ANALOGUE_COUNTS_PER_V for byte in reply)


def encode_pulses(pulses_us: Sequence[float]) -> bytes:
    """Return what a controller answers to `QP`."""
    return bytes(int(pulse / tables.QUERY_UNIT_US + 0.5) for pulse in pulses_us)


def encode_volts(volts: Sequence[float]) -> bytes:
    """Return what a controller answers to `VA` to `VH`; 0 V to 5 V, cut off beyond."""
    counts = (int(volt * tables.ANALOGUE_COUNTS_PER_V + 0.5) for volt in volts)
    return bytes(min(max(count, 0), 255) for count in counts)


def reply_length(command: Command) -> int | None:
    """Return how many bytes answer a command; None for a line of any length."""
    match command:
        case QueryMoving():
            return 1
        case QueryPulses(channels):
            return len(channels)
        case ReadInputs(inputs):
            return len(inputs)
        case ReadAnalogues(letters):
            return len(letters)
        case QueryVersion():
            return None
        case Move() | SetOffsets() | SetOutputs() | SetBanks() | StopServo():
            return 0
        case _:
            assert_never(command)


def _text(command: Command) -> str:
    match command:
        case Move(targets, time_ms):
            servos = "".join(
                f"#{t.channel}P{t.pulse_us}" + (f"S{t.speed_us_s}" if t.speed_us_s else "")
                for t in targets
            )
            return servos + (f"T{time_ms}" if time_ms else "")
        case SetOffsets(offsets):
            return "".join(f"#{channel}PO{offset}" for channel, offset in offsets)
        case SetOutputs(levels):
            return "".join(f"#{channel}{'H' if high else 'L'}" for channel, high in levels)
        case SetBanks(values):
            return "".join(f"#{bank}:{value}" for bank, value in values)
        case QueryMoving():
            return "Q"
        case QueryPulses(channels):
            return "".join(f"QP{channel}" for channel in channels)
        case QueryVersion():
            return "VER"
        case ReadInputs(inputs):
            return "".join(f"{letter}{'L' if latched else ''}" for letter, latched in inputs)
        case ReadAnalogues(letters):
            return "".join(f"V{letter}" for letter in letters)
        case StopServo(channel):
            return f"STOP{channel}"
        case _:
            assert_never(command)


def _parse(line: str) -> Command | None:
    if not line.isascii():
        return None
    if line == "Q":
        return QueryMoving()
    if line == "VER":
        return QueryVersion()
    if move := _MOVE.fullmatch(line):
        targets = tuple(
            ServoTarget(int(channel), int(pulse), int(speed or 0))
            for channel, pulse, speed in _TARGET.findall(move[1])
        )
        return Move(targets, int(move[5] or 0))
    if found := _all_of(_OFFSET, line):
        return SetOffsets(tuple((int(channel), int(offset)) for channel, offset in found))
    if found := _all_of(_OUTPUT, line):
        return SetOutputs(tuple((int(channel), level == "H") for channel, level in found))
    if found := _all_of(_BANK, line):
        return SetBanks(tuple((int(bank), int(value)) for bank, value in found))
    if found := _all_of(_PULSE, line):
        return QueryPulses(tuple(int(channel) for (channel,) in found))
    if found := _all_of(_INPUT, line):
        return ReadInputs(tuple((letter, bool(latch)) for letter, latch in found))
    if found := _all_of(_ANALOGUE, line):
        return ReadAnalogues(tuple(letter for (letter,) in found))
    if stop := _STOP.fullmatch(line):
        return StopServo(int(stop[1]))
    return None


def _all_of(pattern: re.Pattern[str], line: str) -> list[tuple[str, ...]]:
    """Return the groups of a pattern that a line consists of, nothing if it does not."""
    found, position = [], 0
    while match := pattern.match(line, position):
        found.append(tuple(match.groups()))
        position = match.end()
    return found if position == len(line) else []


def _check(command: Command) -> None:
    match command:
        case Move(targets, time_ms):
            _require("number of servos", len(targets), 1, tables.CHANNELS)
            _require("T", time_ms, 0, tables.GREATEST_TIME_MS)
            for target in targets:
                _require("channel", target.channel, 0, tables.CHANNELS - 1)
                _require(
                    "pulse width", target.pulse_us, tables.LEAST_PULSE_US, tables.GREATEST_PULSE_US
                )
                _require("S", target.speed_us_s, 0, tables.GREATEST_SPEED_US_S)
        case SetOffsets(offsets):
            for channel, offset in offsets:
                _require("channel", channel, 0, tables.CHANNELS - 1)
                _require("offset", offset, -tables.GREATEST_OFFSET_US, tables.GREATEST_OFFSET_US)
        case SetOutputs(levels):
            for channel, _ in levels:
                _require("channel", channel, 0, tables.CHANNELS - 1)
        case SetBanks(values):
            for bank, value in values:
                _require("bank", bank, 0, tables.BANKS - 1)
                _require("byte", value, 0, 255)
        case QueryPulses(channels):
            _require("number of channels", len(channels), 1, tables.MAX_LINE_BYTES)
            for channel in channels:
                _require("channel", channel, 0, tables.CHANNELS - 1)
        case StopServo(channel):
            _require("channel", channel, 0, tables.CHANNELS - 1)
        case ReadInputs(inputs):
            if not inputs or any(len(x) != 1 or x not in tables.INPUTS for x, _ in inputs):
                raise BadCommand("inputs are A to F, one or more")
        case ReadAnalogues(letters):
            if not letters or any(len(x) != 1 or x not in tables.ANALOGUES for x in letters):
                raise BadCommand("analogue inputs are A to H, one or more")
        case QueryMoving() | QueryVersion():
            pass
        case _:
            assert_never(command)


def _require(what: str, value: int, low: int, high: int) -> None:
    if not low <= value <= high:
        raise BadCommand(f"{what} {value} is out of range; allowed are {low} to {high}")
