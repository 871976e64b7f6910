"""What it costs a session to be written down."""

from __future__ import annotations

import functools
import tempfile
import time
from io import BytesIO
from itertools import cycle
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer

from benchmarks.measure import Result, interleaved_s, median_s
from benchmarks.serving import ACTIONS, exchange, make_ready, serve_desk, server_process
from cell.clock import SimulatedClock
from cell.devices.camera import CameraSettings, Frame
from cell.events import EventBus, MotionFinished, StepTaken
from cell.geometry import Pose
from cell.profile import parse_profile, profile_text
from dsl.library import library_script
from sessions.hosting import host_twin, settle_memory
from sessions.journal import Reply, SessionStart
from sessions.recording import (
    PictureStorage,
    RecorderFactory,
    RecordingError,
    SessionRecording,
)
from sessions.recording.events_json import encode_event
from sessions.recording.pictures import encode_view
from sessions.script_source import served_script
from sessions.session import Session
from sessions.verify import verify
from sessions.wire.dialects import dialect_named

_LINES, _WIRE, _EVENTS = 2, 8, 3
_SETTINGS = CameraSettings(
    shutter_ms=16.0, gain_db=0.0, white_balance_red=600, white_balance_blue=700
)


def run() -> list[Result]:
    with tempfile.TemporaryDirectory() as folder:
        return [
            _small_records(Path(folder)),
            *_views(),
            _reading(Path(folder)),
            _served_rate(),
            *_step_rates(Path(folder)),
            _verifying(Path(folder)),
        ]


def _start(name: str) -> SessionStart:
    return SessionStart(
        session_id=name,
        script_name="mash.cell",
        script_text="",
        profile_text=profile_text("mash"),
        dialect="1.5",
        seed=1,
        world_json="{}",
        peer="127.0.0.1:1",
        versions={},
    )


class _Session:
    """The small records of a step, again and again, in a real file."""

    def __init__(self, folder: Path, name: str) -> None:
        self.clock = SimulatedClock()
        self.events = EventBus(self.clock)
        self.factory = RecorderFactory(folder, self.events, self.clock, "none")
        self.recorder = self.factory(_start(name))
        self.reply = Reply(text=b"REWARD 0\nEVENT 'Robot move'\nSTATE_UPDATED\n")
        pose = Pose(650.0, -245.0, 98.5)
        self.bodies = (
            MotionFinished(pose),
            MotionFinished(pose),
            StepTaken(12, "RIGHT", 3, 4, 0.0, "Robot move", "STATE_UPDATED"),
        )

    def emit(self) -> None:
        """Only what happens without a recorder, too."""
        for body in self.bodies:
            self.events.emit(body)

    def step(self) -> None:
        """Note one line, eight pieces of wire traffic, three events and the reply."""
        recorder, tap = self.recorder, self.factory.tap
        recorder.received(b"ACTION RIGHT")
        for _ in range(_WIRE // 2):
            tap("arm", "to_device", b"1;1;PPOSF\r")
            tap("arm", "from_device", b"QoKX;650.00;Y;-245.00;Z;98.50;A;180.00;B;0.00;C;180.00\r")
        self.emit()
        recorder.replied(self.reply)


def _small_records(folder: Path) -> Result:
    session = _Session(folder, "small")
    with_recorder_s = median_s(session.step, repeat=15, number=1000)
    session.recorder.close("measured")
    emitting_s = median_s(session.emit, repeat=15, number=1000)
    return Result(
        name=f"{_LINES} lines, {_WIRE} wire messages, {_EVENTS} events of a step",
        value=(with_recorder_s - emitting_s) * 1e6,
        unit="us",
        peer="the same with mcap's writer",
        peer_value=_library_writer_s(folder, session) * 1e6,
        target=30.0,
    )


def _library_writer_s(folder: Path, session: _Session) -> float:
    """Return the time of the same step, written message by message with the library."""
    with (folder / "library.mcap").open("wb", buffering=0) as file:
        writer = Writer(file, use_chunking=False, compression=CompressionType.NONE)
        writer.start()
        channel = writer.register_channel("x", "octets", 0)
        subscription, _ = session.events.subscribe()

        def step() -> None:
            session.emit()
            for event in subscription.take():
                writer.add_message(channel, 0, encode_event(event), 0)
            for data in (b"ACTION RIGHT", session.reply.text, *([b"x" * 40] * _WIRE)):
                writer.add_message(channel, 0, data, 0)

        return median_s(step, repeat=5, number=500)


def _frame() -> Frame:
    """Return a full-size picture with shading, edges and sensor noise."""
    noise = np.random.default_rng(1).normal(0.0, 1.5, (960, 1280, 3))
    ramp = np.linspace(40, 200, 1280)[None, :, None] + noise
    ramp[300:400, 500:600] = (200, 30, 30)
    pixels = np.clip(ramp, 0, 255).astype(np.uint8)
    return Frame(camera="top", number=1, time_s=0.0, pixels=pixels, settings=_SETTINGS)


def _views() -> list[Result]:
    frame = _frame()
    data = frame.pixels.tobytes()
    hashing_s = median_s(lambda: encode_view(1, frame, "image/mif", data, "none"))
    results = []
    storages: tuple[PictureStorage, ...] = ("jpeg", "lossless")
    for storage in storages:
        encode = functools.partial(encode_view, 1, frame, "image/mif", data, storage)
        encoding_s = median_s(encode)
        size = len(encode())
        results.append(
            Result(
                name=f"a 1280x960 view, {storage} ({size / 1e3:.0f} kB), beside the session",
                value=encoding_s * 1e3,
                unit="ms",
                peer="its hash alone",
                peer_value=hashing_s * 1e3,
            )
        )
    return results


def _reading(folder: Path) -> Result:
    session = _Session(folder, "long")
    for _ in range(5000):
        session.step()
    session.recorder.close("measured")
    path = folder / "long.mcap"
    reading_s = median_s(lambda: sum(1 for _ in SessionRecording.open(path).steps()), repeat=5)
    raw_s = median_s(lambda: BytesIO(path.read_bytes()), repeat=5)
    return Result(
        name="reading the steps of 5,000",
        value=reading_s * 1e3,
        unit="ms",
        peer="reading the file's bytes",
        peer_value=raw_s * 1e3,
    )


_EXPECTED = (b"AVAILABLE_ACTIONS", b"OK", b"REWARD 0", b"VIEW")
_VIEW_NAMES = (b"CAMERA_TOP", b"CAMERA_OBLIQUE", b"CAMERA_GRIPPER")


class _Played:
    """A session on the whole twin, in process, ready for actions."""

    def __init__(self, recordings: Path | None, views: PictureStorage = "jpeg") -> None:
        text = profile_text("mash")
        self.hosted = host_twin(
            served_script(library_script("mash"), "mash.cell"),
            parse_profile(text, "mash"),
            text,
            seed=1,
            clock=SimulatedClock(),
            recordings=recordings,
            views=views,
        )
        self.session = Session(self.hosted.desk, dialect_named("1.5"), "benchmark")
        for line in (
            b"INITIALIZE_TASK ReachRedCube STATIC_12x12",
            b"BEGIN_TASK_SETUP",
            b"END_TASK_SETUP",
        ):
            self._say(line)
        self._steps = 0

    def step(self) -> None:
        """Move one point, to and fro."""
        self._steps += 1
        self._say(b"ACTION RIGHT" if self._steps % 2 else b"ACTION LEFT")

    def step_with_views(self) -> None:
        """Move one point and fetch all views."""
        self.step()
        for name in _VIEW_NAMES:
            self._say(b"GET_VIEW " + name)

    def close(self) -> None:
        """End the session and everything under it."""
        self.session.end("measured")
        self.hosted.close()

    def _say(self, line: bytes) -> None:
        reply = self.session.handle(line)
        if not reply.text.startswith(_EXPECTED):
            raise RecordingError(f"{line!r} was answered {reply.text!r}; nothing is measured")


def _step_rates(folder: Path) -> list[Result]:
    """Return steps a second with a recorder beside those without, views and all."""
    plain, recorded = _Played(None), _Played(folder / "rates")
    results = []
    for name, job, repeat, number, least in (
        ("steps in process, recorded", _Played.step, 40, 200, None),
        ("steps with three fresh views, recorded as jpeg", _Played.step_with_views, 12, 8, 0.8),
    ):
        plain_s, recorded_s = interleaved_s(
            functools.partial(job, plain),
            functools.partial(job, recorded),
            repeat=repeat,
            number=number,
        )
        results.append(
            Result(
                name=name,
                value=1 / recorded_s,
                unit="1/s",
                peer="the same, not recorded",
                peer_value=1 / plain_s,
                target=least,
                target_is="at least",
                of="ratio",
            )
        )
    plain.close()
    recorded.close()
    return results


def _serve_plain(pipe: Connection) -> None:
    _serve(pipe, None)


def _serve_recorded(pipe: Connection) -> None:
    with tempfile.TemporaryDirectory() as folder:
        _serve(pipe, Path(folder))


def _serve(pipe: Connection, recordings: Path | None) -> None:
    text = profile_text("mash")
    hosted = host_twin(
        served_script(library_script("mash"), "mash.cell"),
        parse_profile(text, "mash"),
        text,
        seed=1,
        clock=SimulatedClock(),
        recordings=recordings,
    )
    settle_memory()
    serve_desk(hosted.desk, pipe)
    hosted.close()


def _served_rate() -> Result:
    """Return actions a second over loopback with a recorder beside those without."""
    with server_process(_serve_plain, 2) as plain, server_process(_serve_recorded, 2) as recorded:
        for connected in (plain, recorded):
            make_ready(connected)
        ways = cycle(ACTIONS)
        plain_s, recorded_s = interleaved_s(
            lambda: exchange(plain, next(ways)),
            lambda: exchange(recorded, next(ways)),
            repeat=40,
            number=200,
        )
    return Result(
        name="actions over loopback, two cores, recorded",
        value=1 / recorded_s,
        unit="1/s",
        peer="the same, not recorded",
        peer_value=1 / plain_s,
        target=0.9,
        target_is="at least",
        of="ratio",
    )


def _verifying(folder: Path) -> Result:
    """Return how long the replay of 300 steps with three views each takes."""
    played = _Played(folder / "verified", "none")
    started_s = time.perf_counter()
    for _ in range(300):
        played.step_with_views()
    playing_s = time.perf_counter() - started_s
    played.close()
    (path,) = (folder / "verified").glob("*.mcap")
    started_s = time.perf_counter()
    report = verify(SessionRecording.open(path))
    verifying_s = time.perf_counter() - started_s
    if not report.is_identical:
        raise RecordingError(report.describe())
    return Result(
        name=f"verify of 300 steps with {report.views} full-size views",
        value=verifying_s,
        unit="s",
        peer="playing them",
        peer_value=playing_s,
        target=15.0,
    )
