"""Commands and replies of an AQUOS set to bytes and back, without I/O.

A command is four letters, four characters of parameter and a carriage return.
A reply is a line: OK, ERR, or the value asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from cell.drivers.sharp_aquos.tables import TELLS_TEXT, Word
from cell.errors import CellError

END = b"\r"
MAX_LINE = 64
"""Longest line that is believed, without its end."""

Padding = Literal["spaces", "three digits", "four digits"]
"""How numbers fill the parameter: `30  `, `030 ` or `0030`; sets and sources differ."""

_QUERIES = frozenset({"?", "????"})


class MalformedLine(CellError):
    """A line is none that the other side may send."""


@dataclass(frozen=True, slots=True)
class LinkCheck:
    """A lone `A`, which every set answers with ERR."""


@dataclass(frozen=True, slots=True)
class Set:
    """Sets what a word stands for, or does it."""

    word: Word
    value: int = 0


@dataclass(frozen=True, slots=True)
class Query:
    """Asks for the value that a word stands for."""

    word: Word


CommandRecord: TypeAlias = LinkCheck | Set | Query


@dataclass(frozen=True, slots=True)
class Done:
    """The set did it."""


@dataclass(frozen=True, slots=True)
class Refused:
    """Unknown command, wrong value, or not now: the set does not say which."""


@dataclass(frozen=True, slots=True)
class Value:
    """What was asked for."""

    text: str


ReplyRecord: TypeAlias = Done | Refused | Value


def encode_command(command: CommandRecord, padding: Padding = "spaces") -> bytes:
    """Return a command's bytes.

    Raises:
        MalformedLine: The value does not fit four characters.
    """
    match command:
        case LinkCheck():
            return b"A" + END
        case Query(word):
            return f"{word}????".encode("ascii") + END
        case Set(word, value):
            return f"{word}{_parameter(value, padding):<4}".encode("ascii") + END


def decode_command(line: bytes) -> CommandRecord:
    """Return what a line (without its end) asks; padding of any kind is taken.

    Raises:
        MalformedLine: The line is too short or too long, or the word or its
            parameter is unknown.
    """
    if line == b"A":
        return LinkCheck()
    if len(line) != 8:
        raise MalformedLine(f"a command has 8 characters, not {len(line)}: {line!r}")
    try:
        text = line.decode("ascii")
        word = Word(text[:4])
        parameter = text[4:].strip()
        if parameter in _QUERIES:
            return Query(word)
        if not parameter.lstrip("-").isdecimal():
            raise MalformedLine(f"no number: {line!r}")
        return Set(word, int(parameter))
    except ValueError as error:
        raise MalformedLine(f"no command: {line!r}") from error


def encode_reply(reply: ReplyRecord) -> bytes:
    """Return a reply's bytes."""
    match reply:
        case Done():
            return b"OK" + END
        case Refused():
            return b"ERR" + END
        case Value(text):
            return text.encode("ascii", "replace") + END


def decode_reply(line: bytes) -> ReplyRecord:
    """Return what a line (without its end) answers.

    Raises:
        MalformedLine: The line is empty or holds what no set sends.
    """
    text = line.strip()
    if text == b"OK":
        return Done()
    if text == b"ERR":
        return Refused()
    if not text or not text.isascii() or any(byte < 0x20 for byte in text):
        raise MalformedLine(f"no reply: {line!r}")
    return Value(text.decode("ascii"))


def asks_for_text(command: CommandRecord) -> bool:
    """Return whether a value, and not OK, is the good answer."""
    return isinstance(command, Query) or (isinstance(command, Set) and command.word in TELLS_TEXT)


class LineReader:
    """Collects bytes as they come and cuts them into lines.

    Attributes:
        discarded: How many bytes were dropped because their line never ended.
    """

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._is_overlong = False
        self.discarded = 0

    def feed(self, data: bytes) -> list[bytes]:
        """Take bytes and return the lines they complete, without their ends."""
        *ends, rest = data.split(END)
        lines = []
        for piece in ends:
            self._keep(piece)
            if not self._is_overlong:
                lines.append(bytes(self._buffer).strip(b"\n"))
            self.clear()
        self._keep(rest)
        return lines

    def clear(self) -> None:
        """Forget the line that has not ended yet."""
        self._buffer.clear()
        self._is_overlong = False

    def _keep(self, piece: bytes) -> None:
        if self._is_overlong or len(self._buffer) + len(piece) > MAX_LINE:
            self.discarded += len(self._buffer) + len(piece)
            self._buffer.clear()
            self._is_overlong = True
        else:
            self._buffer += piece


def _parameter(value: int, padding: Padding) -> str:
    match padding:
        case "spaces":
            text = str(value)
        case "three digits":
            text = f"{value:03d}"
        case "four digits":
            text = f"{value:04d}"
    if len(text) > 4:
        raise MalformedLine(f"{value} does not fit four characters")
    return text
