"""Requests and replies of the R3 text protocol as bytes and as records; no I/O.

A request is `<robot>;<slot>;<COMMAND><args>` and a carriage return. A reply is
three characters of status, then data, then a carriage return. What the data of
each command mean is `records`' business.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

from cell.drivers.melfa_r3.tables import COMMANDS, LONGEST_COMMAND, SHORTEST_COMMAND
from cell.errors import DeviceError

MAX_REQUEST_BYTES = 256
"""Longest request the controller takes, without its end."""
MAX_REPLY_BYTES = 4096
"""Longest reply a driver accepts; the longest one known has some 200 bytes."""
END = b"\r"

_REMEMBERED = 64
"""A driver repeats few requests over and over; these many are read only once."""
_NUMBERS = {str(number): number for number in range(100)} | {"": 1}
_STRAY = b"\x00\r\n"
_STATUS = {
    b"QoK": (True, False),
    b"Qok": (True, True),
    b"QeR": (False, False),
    b"Qer": (False, True),
}
_PREFIX = {
    (True, False): "QoK",
    (True, True): "Qok",
    (False, False): "QeR",
    (False, True): "Qer",
}


class GarbledMessage(DeviceError):
    """Bytes that are no message of this protocol."""

    def __init__(self, problem: str, *, device: str = "arm") -> None:
        super().__init__(
            device, problem, hint="check the cable and the port's baud rate, parity and stop bits"
        )


class UnsendableRequest(DeviceError):
    """A request that cannot be put into bytes."""

    def __init__(self, problem: str, *, device: str = "arm") -> None:
        super().__init__(device, problem, hint="correct the value")


class Request(NamedTuple):
    """One request to the controller.

    Attributes:
        robot: 1 to 3, 0 for all.
        slot: Task slot, 1 to 32, 0 for all.
        command: A command word of `tables.COMMANDS`.
        args: Whatever follows the command word.
    """

    robot: int
    slot: int
    command: str
    args: str = ""


class Reply(NamedTuple):
    """One reply of the controller.

    Attributes:
        is_accepted: Whether the request was accepted.
        has_alarm: Whether an alarm is active (the third character is small).
        error: Why the request was refused, 0 when it was accepted.
        data: What follows the status.
    """

    is_accepted: bool
    has_alarm: bool
    error: int = 0
    data: str = ""


def encode_request(request: Request) -> bytes:
    """Return the bytes of a request, its end included.

    Raises:
        UnsendableRequest: The text holds what cannot be sent, or is too long.
    """
    robot, slot, command, args = request
    return encode_text(f"{robot};{slot};{command}{args}")


def encode_text(text: str) -> bytes:
    """Return the bytes of a request given as text without its end.

    Raises:
        UnsendableRequest: The text holds what cannot be sent, or is too long.
    """
    if len(text) > MAX_REQUEST_BYTES:
        raise UnsendableRequest(
            f"a request of {len(text)} bytes is too long, the most is {MAX_REQUEST_BYTES}"
        )
    if not (text.isascii() and text.replace("\x0b", "").isprintable()):
        raise UnsendableRequest(f"the request {text!r} holds characters that cannot be sent")
    return text.encode("ascii") + END


@lru_cache(maxsize=_REMEMBERED)
def decode_request(line: bytes) -> Request:
    """Read a request from a line without its end.

    Raises:
        GarbledMessage: The line is no request, or its command is unknown.
    """
    if len(line) > MAX_REQUEST_BYTES:
        raise GarbledMessage(f"a request is longer than {MAX_REQUEST_BYTES} bytes")
    text = line.decode("latin-1")
    head = text.split(";", 2)
    if len(head) != 3:
        raise GarbledMessage(f"the request {text!r} does not start with <robot>;<slot>;")
    robot, slot, rest = head
    word = command_word(rest)
    if not word:
        raise GarbledMessage(f"the request {text!r} holds no known command")
    try:
        return Request(_NUMBERS[robot], _NUMBERS[slot], word, rest[len(word) :])
    except KeyError as error:
        raise GarbledMessage(f"the request {text!r} names no robot or slot") from error


def command_word(text: str) -> str:
    """Return the command word that `text` starts with, or an empty string."""
    if text in COMMANDS:
        return text
    if text.startswith("EXEC"):
        return "EXEC"
    for length in range(LONGEST_COMMAND, SHORTEST_COMMAND - 1, -1):
        if text[:length] in COMMANDS:
            return text[:length]
    return ""


def encode_reply(reply: Reply) -> bytes:
    """Return the bytes of a reply, its end included."""
    accepted, alarm, error, data = reply
    prefix = _PREFIX[accepted, alarm]
    if not accepted:
        data = f"{error:04d};{data}" if data else f"{error:04d}"
    return f"{prefix}{data}\r".encode("latin-1")


def decode_reply(line: bytes) -> Reply:
    """Read a reply from a line without its end.

    Raises:
        GarbledMessage: The line is no reply.
    """
    status = _STATUS.get(line[:3])
    if status is None or len(line) > MAX_REPLY_BYTES:
        raise GarbledMessage(f"the controller answered {line[:80]!r}, which is no reply")
    data = line[3:].decode("latin-1")
    accepted, alarm = status
    if accepted:
        return Reply(True, alarm, 0, data)
    digits, _, rest = data.partition(";")
    if not (digits.isascii() and digits.isdigit() and len(digits) <= 6):
        raise GarbledMessage(f"the refusal {line[:80]!r} holds no error number")
    return Reply(False, alarm, int(digits), rest)


class LineReader:
    """Gathers pieces of a byte stream into lines that end with a carriage return.

    Stray NUL and LF bytes around a line are dropped, and so are empty lines. A
    line longer than `max_bytes` is cut one byte above it, so that memory stays
    bounded and the decoders still see that it was too long.
    """

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._rest = b""

    @property
    def pending(self) -> bytes:
        """The beginning of a line whose end has not come yet."""
        return self._rest

    def feed(self, data: bytes) -> list[bytes]:
        """Take bytes and return the lines they complete, in order."""
        size = len(data)
        if not self._rest and data.find(END) == size - 1 and 1 < size <= self._max_bytes:
            # One whole line in one piece, as nearly always.
            line = data.strip(_STRAY)
            return [line] if line else []
        *ends, rest = (self._rest + data).split(END)
        lines = []
        for end in ends:
            line = self._capped(end).rstrip(_STRAY)
            if line:
                lines.append(line)
        self._rest = self._capped(rest)
        return lines

    def clear(self) -> None:
        """Forget a line that has begun."""
        self._rest = b""

    def _capped(self, line: bytes) -> bytes:
        line = line.lstrip(_STRAY)
        if len(line) <= self._max_bytes:
            return line
        # The last byte is none that gets stripped, so the line stays too long.
        return line[: self._max_bytes] + b"\xff"
