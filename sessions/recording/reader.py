"""Reads a recording, also one that ends in the middle of a record."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from pydantic import TypeAdapter

from calibration.record import CalibrationRecord
from cell.links.base import Direction
from sessions.journal import SessionStart
from sessions.recording import layout
from sessions.recording.errors import RecordingError
from sessions.recording.events_json import decode_event
from sessions.recording.scan import Message, RecordScan


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewReference:
    """A view that a reply carried.

    Attributes:
        view: Number of the kept view; `SessionRecording.view` finds it.
        camera: Name of the camera.
        mime: How it was encoded.
        width: Width in pixels.
        height: Height in pixels.
        size: Number of bytes that were sent.
    """

    view: int
    camera: str
    mime: str
    width: int
    height: int
    size: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedStep:
    """A line of the client and what it was answered.

    Attributes:
        number: Counts the session's lines from 1.
        time_ns: When the line came, session clock.
        line: The line without its LF.
        reply: The reply's text; None when the recording ends before it.
        data_size: Bytes of binary data after the text.
        closes: Whether the connection was closed afterwards.
        view: The view that the data was, if it was one.
    """

    number: int
    time_ns: int
    line: bytes
    reply: bytes | None
    data_size: int = 0
    closes: bool = False
    view: ViewReference | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedView:
    """A view as it was kept.

    Attributes:
        view: Its number.
        step: The step it was first sent in.
        camera: Name of the camera.
        frame: The camera's number of the frame.
        captured_ns: When it was taken, session clock.
        width: Width in pixels.
        height: Height in pixels.
        mime: How it was encoded for the client.
        size: Number of bytes that were sent.
        sha256: Hash of the bytes that were sent.
        encoding: How `picture` is encoded: `jpeg`, `png` or `none`.
        picture: The picture; empty when none was kept.
    """

    view: int
    step: int
    camera: str
    frame: int
    captured_ns: int
    width: int
    height: int
    mime: str
    size: int
    sha256: str
    encoding: str
    picture: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedEvent:
    """An event of the cell; `fields` are those of its class in `cell.events`."""

    step: int
    sequence: int
    time_s: float
    type: str
    fields: dict[str, object]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedBytes:
    """Bytes on the wire of a device."""

    step: int
    time_ns: int
    device: str
    direction: Direction
    data: bytes


class SessionRecording:
    """One recorded session."""

    def __init__(self, scan: RecordScan) -> None:
        """Read the start of a session from a scanned file; callers use `open`."""
        self._scan = scan
        self.path = scan.path
        session = scan.metadata.get(layout.SESSION_METADATA)
        if session is None:
            raise RecordingError(f"{scan.path} ends before the start of its session is complete")
        _check_format(scan.path, session.get("format", ""))
        self.start = _session_start(scan, session)
        self.started_utc = datetime.fromisoformat(session["started_utc"])
        self.calibration = scan.metadata.get(layout.CALIBRATION_METADATA, {})

    @classmethod
    def open(cls, path: Path) -> SessionRecording:
        """Open a recording; one that was cut short is read up to its last complete record.

        Raises:
            RecordingError: The file cannot be read, is no recording, is of another format
                version, or ends before the session's start is complete.
        """
        return cls(RecordScan(path))

    @property
    def is_finished(self) -> bool:
        """Whether the recording was closed in an orderly way."""
        return self._scan.is_finished

    @property
    def missing_bytes(self) -> int:
        """Size of the broken record at the end of a recording that was cut short."""
        return self._scan.missing_bytes

    @property
    def end_reason(self) -> str | None:
        """Why the session ended, or None if the recording does not say."""
        for message in self._scan.select(layout.ENDED):
            return str(self._json(message)["reason"])
        return None

    @property
    def duration_ns(self) -> int:
        """Session time from the first to the last message."""
        times = [message.time_ns for message in self._scan.messages]
        return max(times) - min(times) if times else 0

    def steps(self) -> Iterator[RecordedStep]:
        """Yield every line with its reply, in order."""
        line: Message | None = None
        view: ViewReference | None = None
        for message in self._scan.select("client/"):
            if message.topic == layout.RECEIVED:
                if line is not None:
                    yield self._step(line, None, None)
                line, view = message, None
            elif message.topic == layout.VIEW_SENT:
                view = _view_reference(self._json(message))
            elif line is not None:
                yield self._step(line, message, view)
                line = None
        if line is not None:
            yield self._step(line, None, None)

    def lines(self) -> Iterator[bytes]:
        """Yield every line of the client, in order."""
        return (self._scan.data(message) for message in self._scan.select(layout.RECEIVED))

    def events(self) -> Iterator[RecordedEvent]:
        """Yield every event, in order."""
        for message in self._scan.select(layout.EVENTS):
            fields = self._decoded(message)
            yield RecordedEvent(
                step=message.sequence,
                sequence=_integer(fields.pop("sequence")),
                time_s=_number(fields.pop("time_s")),
                type=str(fields.pop("type")),
                fields=fields,
            )

    def wire(self, device: str | None = None) -> Iterator[RecordedBytes]:
        """Yield the bytes on the wire of one device, or of all, in order."""
        wanted = None if device is None else layout.WIRE_PREFIX + device
        for message in self._scan.select(layout.WIRE_PREFIX):
            if wanted is not None and message.topic != wanted:
                continue
            yield from self._pieces(message)

    def views(self) -> Iterator[RecordedView]:
        """Yield every kept view, in the order they were written."""
        return (self._view(m) for m in self._scan.select(layout.VIEWS_PREFIX))

    def view_hashes(self) -> dict[int, str]:
        """Return the hash of every kept view by its number."""
        return {
            _integer(head["view"]): str(head["sha256"])
            for head in map(self._view_head, self._scan.select(layout.VIEWS_PREFIX))
        }

    def _step(
        self, line: Message, reply: Message | None, view: ViewReference | None
    ) -> RecordedStep:
        text = self._scan.data(line)
        if reply is None:
            return RecordedStep(number=line.sequence, time_ns=line.time_ns, line=text, reply=None)
        data = self._scan.data(reply)
        flags, size = layout.REPLY_HEAD.unpack_from(data)
        return RecordedStep(
            number=line.sequence,
            time_ns=line.time_ns,
            line=text,
            reply=data[layout.REPLY_HEAD.size :],
            data_size=size,
            closes=bool(flags & layout.REPLY_CLOSES),
            view=view if flags & layout.REPLY_HAS_VIEW else None,
        )

    def _pieces(self, message: Message) -> Iterator[RecordedBytes]:
        data = self._scan.data(message)
        (count,) = layout.WIRE_HEAD.unpack_from(data)
        table = layout.WIRE_HEAD.size
        start = table + count * layout.WIRE_PIECE.size
        for mark, time_s, size in layout.WIRE_PIECE.iter_unpack(data[table:start]):
            yield RecordedBytes(
                step=message.sequence,
                time_ns=int(time_s * 1e9 + 0.5),
                device=message.topic.removeprefix(layout.WIRE_PREFIX),
                direction="to_device" if mark == layout.TO_DEVICE else "from_device",
                data=data[start : start + size],
            )
            start += size

    def _view(self, message: Message) -> RecordedView:
        head = self._view_head(message)
        data = self._scan.data(message)
        (length,) = layout.PICTURE_HEAD.unpack_from(data)
        return RecordedView(
            view=_integer(head["view"]),
            step=message.sequence,
            camera=str(head["camera"]),
            frame=_integer(head["frame"]),
            captured_ns=_integer(head["captured_ns"]),
            width=_integer(head["width"]),
            height=_integer(head["height"]),
            mime=str(head["mime"]),
            size=_integer(head["bytes"]),
            sha256=str(head["sha256"]),
            encoding=str(head["encoding"]),
            picture=data[layout.PICTURE_HEAD.size + length :],
        )

    def _view_head(self, message: Message) -> dict[str, object]:
        start = layout.PICTURE_HEAD.size
        (length,) = layout.PICTURE_HEAD.unpack_from(self._scan.slice(message, 0, start))
        return self._parse(self._scan.slice(message, start, start + length), message)

    def _json(self, message: Message) -> dict[str, object]:
        return self._parse(self._scan.data(message), message)

    def _decoded(self, message: Message) -> dict[str, object]:
        try:
            return decode_event(self._scan.data(message))
        except ValueError as error:
            raise self._broken(message) from error

    def _parse(self, data: bytes, message: Message) -> dict[str, object]:
        try:
            parsed: object = json.loads(data)
        except ValueError as error:
            raise self._broken(message) from error
        if not isinstance(parsed, dict):
            raise self._broken(message)
        return parsed

    def _broken(self, message: Message) -> RecordingError:
        return RecordingError(
            f"{self.path}: the message at byte {message.offset} ({message.topic}) is not JSON"
        )


def _check_format(path: Path, version: str) -> None:
    if version != str(layout.FORMAT_VERSION):
        raise RecordingError(
            f"{path} has format version {version or 'unknown'}; this program reads version "
            f"{layout.FORMAT_VERSION}"
        )


def _session_start(scan: RecordScan, session: dict[str, str]) -> SessionStart:
    try:
        return SessionStart(
            session_id=session["session_id"],
            script_name=session["script_name"],
            script_text=scan.attachments[layout.SCRIPT_FILE].decode(),
            profile_text=scan.attachments[layout.PROFILE_FILE].decode(),
            dialect=session["dialect"],
            seed=int(session["seed"]),
            world_json=scan.attachments[layout.WORLD_FILE].decode(),
            peer=session["peer"],
            versions=scan.metadata.get(layout.VERSIONS_METADATA, {}),
            calibrations=_calibrations(scan.attachments.get(layout.CALIBRATIONS_FILE, b"[]")),
        )
    except (KeyError, ValueError) as error:
        raise RecordingError(
            f"{scan.path}: the session's start is not readable: {error}"
        ) from error


def _calibrations(data: bytes) -> tuple[CalibrationRecord, ...]:
    """Return the calibrations that were in force.

    Raises:
        ValueError: The data holds none that this program reads.
    """
    return TypeAdapter(tuple[CalibrationRecord, ...]).validate_json(data)


def _view_reference(sent: dict[str, object]) -> ViewReference:
    return ViewReference(
        view=_integer(sent["view"]),
        camera=str(sent["camera"]),
        mime=str(sent["mime"]),
        width=_integer(sent["width"]),
        height=_integer(sent["height"]),
        size=_integer(sent["bytes"]),
    )


def _integer(value: object) -> int:
    if isinstance(value, int):
        return value
    raise RecordingError(f"a recording has {value!r} where a whole number belongs")


def _number(value: object) -> float:
    if isinstance(value, int | float):
        return float(value)
    raise RecordingError(f"a recording has {value!r} where a number belongs")
