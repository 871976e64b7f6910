"""Finds the records of an MCAP file that may end in the middle of one."""

from __future__ import annotations

import mmap
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Metadata

from sessions.recording.errors import RecordingError
from sessions.recording.records import MAGIC, MESSAGE_HEAD, RECORD_HEAD


class Message(NamedTuple):
    """A message as it lies in the file.

    Attributes:
        topic: Topic of its channel.
        sequence: Number of the step it belongs to; 0 before the first.
        time_ns: Session clock.
        offset: Offset of its data in the file.
        length: Length of its data.
    """

    topic: str
    sequence: int
    time_ns: int
    offset: int
    length: int


class RecordScan:
    """The records of a file, read once; data is taken from the file when asked for."""

    def __init__(self, path: Path) -> None:
        """Scan a file up to its last complete record.

        Raises:
            RecordingError: The file cannot be read or is no MCAP file.
        """
        self.path = path
        self.messages: list[Message] = []
        self.metadata: dict[str, dict[str, str]] = {}
        self.attachments: dict[str, bytes] = {}
        self.is_finished = False
        self.complete_bytes = 0
        self._topics: dict[int, str] = {}
        try:
            with path.open("rb") as file:
                self._data: mmap.mmap | bytes = _map(file.fileno())
        except OSError as error:
            raise RecordingError(f"the recording {path} cannot be read: {error}") from error
        if self._data[: len(MAGIC)] != MAGIC:
            raise RecordingError(f"{path} is not a recording (no MCAP magic at its start)")
        self._scan()

    @property
    def missing_bytes(self) -> int:
        """Bytes at the end of the file that are a part of a record."""
        return len(self._data) - self.complete_bytes

    def data(self, message: Message) -> bytes:
        """Return the data of a message."""
        return bytes(self._data[message.offset : message.offset + message.length])

    def slice(self, message: Message, start: int, stop: int) -> bytes:
        """Return a part of the data of a message."""
        end = min(message.offset + stop, message.offset + message.length)
        return bytes(self._data[message.offset + start : end])

    def select(self, prefix: str) -> Iterator[Message]:
        """Yield the messages whose topic is, or begins with, a text, in file order."""
        return (m for m in self.messages if m.topic.startswith(prefix))

    def _scan(self) -> None:
        data = self._data
        size = len(data)
        offset = len(MAGIC)
        while offset + RECORD_HEAD.size <= size:
            opcode, length = RECORD_HEAD.unpack_from(data, offset)
            end = offset + RECORD_HEAD.size + length
            if end > size:
                break
            if opcode == Opcode.MESSAGE:
                self._take_message(offset, length)
            elif opcode in (Opcode.CHANNEL, Opcode.METADATA, Opcode.ATTACHMENT):
                self._take(opcode, bytes(data[offset + RECORD_HEAD.size : end]))
            offset = end
            if opcode in (Opcode.DATA_END, Opcode.FOOTER) and self._ends(opcode, offset):
                return
        self.complete_bytes = offset

    def _ends(self, opcode: int, offset: int) -> bool:
        """Note the end of the file; the summary repeats what is known and is not read."""
        if opcode == Opcode.FOOTER and self._data[offset : offset + len(MAGIC)] == MAGIC:
            self.is_finished = True
            self.complete_bytes = offset + len(MAGIC)
            return True
        return False

    def _take_message(self, offset: int, length: int) -> None:
        _, _, channel, sequence, time_ns, _ = MESSAGE_HEAD.unpack_from(self._data, offset)
        head = MESSAGE_HEAD.size - RECORD_HEAD.size
        topic = self._topics.get(channel)
        if topic is None:
            raise RecordingError(f"{self.path}: a message at byte {offset} is of no known channel")
        self.messages.append(
            Message(topic, sequence, time_ns, offset + MESSAGE_HEAD.size, length - head)
        )

    def _take(self, opcode: int, body: bytes) -> None:
        stream = ReadDataStream(BytesIO(body))
        if opcode == Opcode.CHANNEL:
            channel = Channel.read(stream)
            self._topics[channel.id] = channel.topic
        elif opcode == Opcode.METADATA:
            metadata = Metadata.read(stream)
            self.metadata[metadata.name] = metadata.metadata
        else:
            attachment = Attachment.read(stream)
            self.attachments[attachment.name] = attachment.data


def _map(descriptor: int) -> mmap.mmap | bytes:
    try:
        return mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ)
    except ValueError:  # An empty file cannot be mapped.
        return b""
