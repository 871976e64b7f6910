"""Writes a session down while it runs: the journal, the tap on the wires, the events.

Line and reply of a step leave in one write before the reply does; what happened on
the wires and in the cell follows in another when it has left. Views are finished later
by a thread of their own, so a reply that carries one only names its number
(`client/view_sent`); the record in `views/*` follows.
"""

from __future__ import annotations

import json
import logging
import struct
import threading
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path

from cell.clock import Clock
from cell.events import EventBus
from cell.links.base import Direction
from sessions.journal import Reply, SentView, SessionStart
from sessions.recording import layout
from sessions.recording.errors import RecordingError
from sessions.recording.events_json import encode_event, event_schema
from sessions.recording.file import RecordingFile
from sessions.recording.pictures import PictureStorage
from sessions.recording.records import MESSAGE_FIELDS_SIZE, MESSAGE_HEAD
from sessions.recording.view_writer import ViewWriter

_log = logging.getLogger(__name__)

_RUN_PIECES = 256
_FLUSH_PARTS = 256
_EVENT_CAPACITY = 100_000
_OPCODE_MESSAGE = 5
_WIRE_HEAD_SIZE = layout.WIRE_HEAD.size
_WIRE_PIECE_SIZE = layout.WIRE_PIECE.size
_EVENT_SCHEMA = layout.SchemaText(name="robocell.Event", encoding="jsonschema", text=event_schema())


@lru_cache(maxsize=1024)
def _wire_message(pieces: int) -> struct.Struct:
    """Return the packing of a message's head with its whole table of pieces."""
    piece = layout.WIRE_PIECE.format.removeprefix("<") * pieces
    return struct.Struct(MESSAGE_HEAD.format + layout.WIRE_HEAD.format.removeprefix("<") + piece)


class SessionRecorder:
    """The journal of one session, kept in one MCAP file.

    The conversation belongs to the thread that has the cell. The tap may be used by several
    threads at once, as devices that come up at the same time do; views are finished by
    another. A disk that fails must not stop an arm: the first failure is logged, nothing more
    is written, and the file stays without its summary ("not finished").
    """

    def __init__(
        self,
        file: RecordingFile,
        start: SessionStart,
        *,
        events: EventBus,
        clock: Clock,
        views: PictureStorage,
        calibration: Mapping[str, str],
        started_utc: datetime,
    ) -> None:
        """Write the start of the session into a fresh file.

        Args:
            file: The file.
            start: What a replay needs to begin.
            events: Where the cell's events come from.
            clock: The session's clock; all times in the file are its nanoseconds.
            views: How pictures are kept.
            calibration: Calibrated values by name, as JSON.
            started_utc: Wall time of the start.

        Raises:
            RecordingError: The file cannot be written.
        """
        self._file = file
        self._lock = threading.RLock()
        self._now_s = clock.now_s
        self._counts = file.message_counts
        self._parts: list[bytes] = []
        self._traffic: list[bytes] = []
        self._run_link = ""
        self._run: list[float] = []
        self._run_data: list[bytes] = []
        self._step = 0
        self._failure: RecordingError | None = None
        self._is_closed = False
        self._start_ns = self._end_ns = self._views_end_ns = round(clock.now_s() * 1e9)
        self._wire_channels: dict[str, int] = {}
        self._subscription, self._unsubscribe = events.subscribe(_EVENT_CAPACITY)
        self._views = ViewWriter(self._write_view, views)
        self._write_start(start, views, calibration, started_utc)
        self._received = file.add_channel(layout.RECEIVED, layout.LINE_SCHEMA)
        self._replied = file.add_channel(layout.REPLIED, layout.REPLY_SCHEMA)
        self._view_sent = file.add_channel(layout.VIEW_SENT, layout.VIEW_SENT_SCHEMA)
        self._events = file.add_channel(layout.EVENTS, _EVENT_SCHEMA)
        self._ended = file.add_channel(layout.ENDED, layout.ENDED_SCHEMA)
        for line, reply in start.backlog:
            self.received(line)
            self.replied(reply)

    @property
    def path(self) -> Path:
        """The recording's file."""
        return self._file.path

    @property
    def failure(self) -> RecordingError | None:
        """Why nothing more is written, or None."""
        return self._failure

    def received(self, line: bytes) -> None:
        """Note a line of the client (without its LF); it begins a step."""
        with self._lock:
            self.settled()
            self._step = (self._step + 1) & 0xFFFFFFFF
            self._note(self._received, self._now_s(), line)

    def replied(self, reply: Reply) -> None:
        """Note the reply to the last line and write both to the file."""
        with self._lock:
            now_s = self._now_s()
            flags = layout.REPLY_CLOSES if reply.closes else 0
            if reply.view is not None and self._failure is None:
                flags |= layout.REPLY_HAS_VIEW
                self._note(self._view_sent, now_s, self._hand_over(reply.view, reply.data))
            head = layout.REPLY_HEAD.pack(flags, len(reply.data))
            self._note(self._replied, now_s, head + reply.text)
            self._write(self._parts)

    def settled(self) -> None:
        """Write what happened on the wires and in the cell since the last time."""
        with self._lock:
            if self._run:
                self._end_run()
            self._note_events()
            if self._traffic:
                self._flush()

    def wire(self, link: str, direction: Direction, data: bytes) -> None:
        """Note bytes on the wire of a device; after the end of the session they are not noted."""
        with self._lock:
            # Called for every piece of traffic: what can wait until the step is written, waits.
            if link != self._run_link or len(self._run_data) >= _RUN_PIECES:
                if self._is_closed:
                    return
                if self._run:
                    self._end_run()
                if len(self._traffic) >= _FLUSH_PARTS:
                    self._flush()
                self._run_link = link
            self._run += (direction == "from_device", self._now_s(), len(data))
            self._run_data.append(data)

    def close(self, reason: str) -> None:
        """Write what is left, the summary, and close the file; closing twice is harmless."""
        with self._lock:
            if self._is_closed:
                return
            self._is_closed = True
            self.settled()
            self._run_link = ""
            self._unsubscribe()
            self._flush()
            try:
                self._views.close()
            except RecordingError as error:
                self._fail(error)
            ended = {
                "reason": reason,
                "lines": self._step,
                "views": self._views.count,
                "events_lost": self._subscription.dropped,
            }
            self._note(self._ended, self._now_s(), json.dumps(ended).encode("ascii"))
            self._flush()
            self._finish()

    def _finish(self) -> None:
        if self._failure is not None:
            self._file.abandon()
            return
        try:
            self._file.finish(self._start_ns, max(self._end_ns, self._views_end_ns))
        except RecordingError as error:
            self._fail(error)

    def _note(self, channel: int, time_s: float, data: bytes) -> None:
        """Keep a message of the conversation for the next write."""
        self._parts += self._message(channel, time_s, data)

    def _message(self, channel: int, time_s: float, data: bytes) -> tuple[bytes, bytes]:
        """Return a message, its head apart."""
        time_ns = int(time_s * 1e9 + 0.5)
        size = MESSAGE_FIELDS_SIZE + len(data)
        head = MESSAGE_HEAD.pack(_OPCODE_MESSAGE, size, channel, self._step, time_ns, time_ns)
        self._counts[channel] += 1
        self._end_ns = time_ns
        return head, data

    def _note_events(self) -> None:
        """Keep what happened since the last time."""
        for event in self._subscription.take():
            self._traffic += self._message(self._events, event.time_s, encode_event(event))

    def _hand_over(self, view: SentView, data: bytes | memoryview) -> bytes:
        """Have a view written beside the session; return the message that it was sent."""
        frame = view.frame
        number = self._views.take(frame, view.mime, data, self._step)
        height, width = frame.pixels.shape[:2]
        return (
            f'{{"view":{number},"camera":{json.dumps(frame.camera)},"frame":{frame.number},'
            f'"mime":{json.dumps(view.mime)},"width":{width},"height":{height},'
            f'"bytes":{len(data)}}}'
        ).encode("ascii")

    def _end_run(self) -> None:
        """Keep the traffic in a row with one device as a message for the next write."""
        run, data = self._run, self._run_data
        pieces = len(data)
        size = MESSAGE_FIELDS_SIZE + _WIRE_HEAD_SIZE + pieces * _WIRE_PIECE_SIZE
        size += sum(map(len, data))
        time_ns = int(run[1] * 1e9 + 0.5)
        channel = self._wire_channels.get(self._run_link) or self._add_wire_channel()
        head = _wire_message(pieces).pack(
            _OPCODE_MESSAGE, size, channel, self._step, time_ns, time_ns, pieces, *run
        )
        self._traffic.append(head)
        self._traffic += data
        self._counts[channel] += 1
        run.clear()
        data.clear()

    def _flush(self) -> None:
        """Write all kept messages in one go, the conversation first."""
        self._parts += self._traffic
        self._traffic.clear()
        self._write(self._parts)

    def _write(self, parts: list[bytes]) -> None:
        data = b"".join(parts)
        parts.clear()
        if self._failure is not None:
            return
        try:
            self._file.append(data)
        except RecordingError as error:
            self._fail(error)

    def _fail(self, error: RecordingError) -> None:
        if self._failure is None:
            self._failure = error
            _log.error("recording stopped: %s", error)

    def _add_wire_channel(self) -> int:
        """Announce the channel of a device's traffic."""
        link = self._run_link
        try:
            channel = self._file.add_channel(layout.WIRE_PREFIX + link, layout.WIRE_SCHEMA)
        except RecordingError as error:
            self._fail(error)
            channel = self._received  # Nothing is written any more; the number is not used.
        self._wire_channels[link] = channel
        return channel

    def _write_view(self, camera: str, step: int, message: bytes) -> None:
        """Write a finished view; called by the thread that finishes views."""
        time_ns = round(self._now_s() * 1e9)
        channel = self._file.add_channel(layout.VIEWS_PREFIX + camera, layout.PICTURE_SCHEMA)
        head = MESSAGE_HEAD.pack(
            _OPCODE_MESSAGE, MESSAGE_FIELDS_SIZE + len(message), channel, step, time_ns, time_ns
        )
        self._file.append(head + message)
        self._counts[channel] += 1
        self._views_end_ns = time_ns

    def _write_start(
        self,
        start: SessionStart,
        views: PictureStorage,
        calibration: Mapping[str, str],
        started_utc: datetime,
    ) -> None:
        file = self._file
        file.add_attachment(
            layout.SCRIPT_FILE, "text/plain", start.script_text.encode(), self._start_ns
        )
        file.add_attachment(
            layout.PROFILE_FILE, "application/toml", start.profile_text.encode(), self._start_ns
        )
        file.add_attachment(
            layout.WORLD_FILE, "application/json", start.world_json.encode(), self._start_ns
        )
        if start.calibrations:
            records = b",\n".join(record.canonical() for record in start.calibrations)
            file.add_attachment(
                layout.CALIBRATIONS_FILE, "application/json", b"[" + records + b"]", self._start_ns
            )
        file.add_metadata(layout.VERSIONS_METADATA, start.versions)
        file.add_metadata(layout.CALIBRATION_METADATA, calibration)
        # Last, so that whoever finds it finds everything above, too.
        file.add_metadata(
            layout.SESSION_METADATA,
            {
                "format": str(layout.FORMAT_VERSION),
                "session_id": start.session_id,
                "started_utc": started_utc.astimezone(UTC).isoformat(),
                "script_name": start.script_name,
                "dialect": start.dialect,
                "seed": str(start.seed),
                "peer": start.peer,
                "views": views,
            },
        )
