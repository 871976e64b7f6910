"""An MCAP file that is appended to as things happen and closed with a summary.

What `append` has taken is with the kernel when it returns, so it survives the
end of this process however it comes. (It does not survive a power cut before
the file system writes it back; no step waits for the disk.)
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import threading
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from mcap.records import Attachment, AttachmentIndex, Channel, Header, Metadata, MetadataIndex
from mcap.records import Schema as McapSchema

from sessions.recording.errors import RecordingError
from sessions.recording.layout import MCAP_PROFILE, SchemaText
from sessions.recording.records import MAGIC, Index, pack, pack_end


class RecordingFile:
    """One MCAP file being written. Safe to use from several threads."""

    def __init__(self, path: Path) -> None:
        """Create the file; it must not be there yet.

        Raises:
            RecordingError: The file cannot be created, or it exists.
        """
        self.path = path
        self._index = Index()
        self._schema_ids: dict[str, int] = {}
        self._channel_ids: dict[str, int] = {}
        self._lock = threading.Lock()
        self._offset = 0
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._descriptor = os.open(
                path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | os.O_CLOEXEC, 0o644
            )
        except OSError as error:
            raise RecordingError(f"the recording {path} cannot be created: {error}") from error
        # Held as long as the file is open, so that whoever lists recordings sees it is alive.
        # Where locks do not work, the list only says "not finished" a little early.
        with contextlib.suppress(OSError):
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        library = f"robocell {version('robocell')}; mcap {version('mcap')}"
        self.append(MAGIC + pack(Header(profile=MCAP_PROFILE, library=library)))

    @property
    def message_counts(self) -> dict[int, int]:
        """How many messages each channel has; whoever appends messages counts them here."""
        return self._index.message_counts

    def append(self, data: bytes) -> None:
        """Write whole records at the end of the file.

        Raises:
            RecordingError: The file cannot be written.
        """
        with self._lock:
            self._write(data)

    def add_channel(self, topic: str, schema: SchemaText) -> int:
        """Announce a channel (once) and return its number."""
        with self._lock:
            known = self._channel_ids.get(topic)
            if known is not None:
                return known
            number = len(self._channel_ids) + 1
            channel = Channel(
                id=number,
                topic=topic,
                message_encoding=schema.message_encoding,
                metadata={},
                schema_id=self._schema_id(schema),
            )
            self._write(pack(channel))
            self._channel_ids[topic] = number
            self._index.channels.append(channel)
            self._index.message_counts[number] = 0
            return number

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a table of names and texts."""
        packed = pack(Metadata(name=name, metadata=dict(values)))
        with self._lock:
            self._index.metadata.append(
                MetadataIndex(offset=self._offset, length=len(packed), name=name)
            )
            self._write(packed)

    def add_attachment(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Write a file into the file."""
        packed = pack(
            Attachment(create_time=0, log_time=time_ns, name=name, media_type=media_type, data=data)
        )
        with self._lock:
            self._index.attachments.append(
                AttachmentIndex(
                    offset=self._offset,
                    length=len(packed),
                    log_time=time_ns,
                    create_time=0,
                    data_size=len(data),
                    name=name,
                    media_type=media_type,
                )
            )
            self._write(packed)

    def finish(self, start_ns: int, end_ns: int) -> None:
        """Write the summary and close the file.

        Args:
            start_ns: Time of the first message.
            end_ns: Time of the last message.

        Raises:
            RecordingError: The file cannot be written; it is closed all the same.
        """
        self._index.start_ns = start_ns
        self._index.end_ns = end_ns
        try:
            with self._lock:
                self._write(pack_end(self._index, self._offset))
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Close the file as it is, without a summary."""
        os.close(self._descriptor)

    def _schema_id(self, schema: SchemaText) -> int:
        known = self._schema_ids.get(schema.name)
        if known is not None:
            return known
        number = len(self._schema_ids) + 1
        record = McapSchema(
            id=number, name=schema.name, encoding=schema.encoding, data=schema.text.encode()
        )
        self._write(pack(record))
        self._schema_ids[schema.name] = number
        self._index.schemas.append(record)
        return number

    def _write(self, data: bytes) -> None:
        try:
            written = os.write(self._descriptor, data)
            while written < len(data):
                written += os.write(self._descriptor, memoryview(data)[written:])
        except OSError as error:
            raise RecordingError(f"{self.path} cannot be written: {error}") from error
        self._offset += written
