"""A small session to record, and the pieces it is made of."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from cell.clock import SimulatedClock
from cell.devices.camera import CameraSettings, Frame
from cell.events import EventBus, MotionFinished, StepTaken
from cell.geometry import Pose
from cell.profile import profile_text
from sessions.journal import Reply, SentView, SessionStart
from sessions.recording import PictureStorage, RecorderFactory, SessionRecorder

SETTINGS = CameraSettings(
    shutter_ms=16.02, gain_db=-4.0, white_balance_red=597, white_balance_blue=839
)
STARTED = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)


def a_start(session_id: str = "20260102T030405-abcdef") -> SessionStart:
    return SessionStart(
        session_id=session_id,
        script_name="mash.cell",
        script_text="# a script with ünïcode\n",
        profile_text=profile_text("mash"),
        dialect="1.5",
        seed=42,
        world_json='{"blocks": []}',
        peer="127.0.0.1:50000",
        versions={"robocell": "0.1.0", "python": "3.11"},
        backlog=((b"STATUS", Reply(text=b"READY\n")),),
    )


def a_frame(number: int, camera: str = "top", width: int = 64, height: int = 48) -> Frame:
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[:, : width // 2, 0] = 200
    pixels[: height // 2, :, 1] = 10 * number % 256
    pixels.setflags(write=False)
    return Frame(
        camera=camera, number=number, time_s=0.25 * number, pixels=pixels, settings=SETTINGS
    )


def a_view_reply(frame: Frame) -> Reply:
    data = b"mif\x01" + frame.pixels.tobytes()
    return Reply(
        text=f"VIEW CAMERA_TOP image/mif {len(data)}\n".encode(),
        data=data,
        view=SentView(frame=frame, mime="image/mif"),
    )


@dataclass
class Bench:
    """A recorder with everything around it."""

    clock: SimulatedClock
    events: EventBus
    factory: RecorderFactory
    recorder: SessionRecorder

    @property
    def path(self) -> Path:
        return self.recorder.path

    def step(self, number: int) -> None:
        """Record one action with motion, events and wire traffic."""
        self.recorder.received(b"ACTION RIGHT")
        for _ in range(4):
            self.factory.tap("arm", "to_device", b"1;1;EXECMVS P1\r")
            self.clock.sleep(0.01)
            self.factory.tap("arm", "from_device", b"QoK\r")
        self.events.emit(MotionFinished(Pose(710.0 - number, -265.25, 98.5)))
        self.events.emit(StepTaken(number, "RIGHT", number, 0, 0.0, "Robot move", "STATE_UPDATED"))
        self.recorder.replied(Reply(text=b"REWARD 0\nEVENT 'Robot move'\nSTATE_UPDATED\n"))

    def view(self, frame: Frame) -> None:
        self.recorder.received(b"GET_VIEW CAMERA_TOP")
        self.recorder.replied(a_view_reply(frame))


def a_bench(folder: Path, views: PictureStorage = "jpeg", session_id: str | None = None) -> Bench:
    clock = SimulatedClock()
    events = EventBus(clock)
    factory = RecorderFactory(folder, events, clock, views, wall_clock=lambda: STARTED)
    start = a_start() if session_id is None else a_start(session_id)
    return Bench(clock=clock, events=events, factory=factory, recorder=factory(start))


def a_recording(folder: Path, views: PictureStorage = "jpeg") -> Path:
    """Record a small session: a backlog line, three steps, three views of two frames."""
    bench = a_bench(folder, views)
    first, second = a_frame(1), a_frame(2)
    bench.step(1)
    bench.view(first)
    bench.step(2)
    bench.view(first)
    bench.view(second)
    bench.step(3)
    bench.recorder.received(b"DONE")
    bench.recorder.replied(Reply(text=b"GOODBYE\n", closes=True))
    bench.recorder.close("the client said DONE")
    return bench.path
