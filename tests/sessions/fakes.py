"""A cell and a script that are nothing but memory, and a desk over them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from cell.clock import SimulatedClock
from cell.devices.camera import CameraSettings, Frame
from cell.events import EventBus
from cell.manipulation import Deployment
from cell.profile import ServerProfile, load_profile
from dsl.host import Host, Placement
from sessions.desk import Desk
from sessions.journal import Journal, NoJournal, Reply, SessionStart
from sessions.script import RunningTask, Status, TaskSpec, ViewSpec
from sessions.session import Session
from sessions.wire.dialects import DIALECTS

SETTINGS = CameraSettings(shutter_ms=10, gain_db=0, white_balance_red=1, white_balance_blue=1)
PROFILE = load_profile("mash")
_PIXELS: dict[tuple[int, int], np.ndarray[tuple[int, ...], np.dtype[np.uint8]]] = {}


def pixels_of(width_px: int, height_px: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return the one picture of a size."""
    if (width_px, height_px) not in _PIXELS:
        ramp = np.arange(width_px * height_px * 3, dtype=np.uint32) % 251
        pixels = ramp.astype(np.uint8).reshape(height_px, width_px, 3)
        pixels.flags.writeable = False
        _PIXELS[width_px, height_px] = pixels
    return _PIXELS[width_px, height_px]


@dataclass
class FakeCell:
    """Writes down what it is asked to do; fails or waits where a test says so."""

    calls: list[str] = field(default_factory=list)
    failures: dict[str, Exception] = field(default_factory=dict)
    gates: dict[str, threading.Event] = field(default_factory=dict)
    entered: dict[str, threading.Event] = field(default_factory=dict)
    is_open: bool = False
    blocks_out: int = 0
    place_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    frames: dict[tuple[str, int, int], Frame] = field(default_factory=dict)

    def _note(self, name: str, words: str = "") -> None:
        self.calls.append(f"{name} {words}".strip())
        if name in self.entered:
            self.entered[name].set()
        if name in self.gates:
            assert self.gates[name].wait(30)
        if name in self.failures:
            raise self.failures.pop(name)

    def begin_session(self, seed: int) -> None:
        self._note("begin_session", str(seed))

    def world_json(self) -> str:
        return "{}"

    def open(self) -> None:
        self._note("open")
        self.is_open = True

    def close(self) -> None:
        self._note("close")
        self.is_open = False

    def show(self, picture: str) -> None:
        self._note("show", picture)

    def lay_out(self, deployments: Sequence[Deployment]) -> None:
        self._note("lay_out", str(len(deployments)))
        self.blocks_out = len(deployments)

    def move_to(self, x_mm: float, y_mm: float, z_mm: float) -> None:
        self._note("move_to", f"{x_mm:g} {y_mm:g} {z_mm:g}")
        self.place_mm = (x_mm, y_mm, z_mm)
        self.frames.clear()

    def clean(self) -> object:
        self._note("clean")
        self.blocks_out = 0
        return []

    def grab(self, camera: str, width_px: int, height_px: int) -> Frame:
        self._note("grab", f"{camera} {width_px}x{height_px}")
        key = camera, width_px, height_px
        if key not in self.frames:
            self.frames[key] = Frame(
                camera=camera,
                number=len(self.calls),
                time_s=0.0,
                pixels=pixels_of(width_px, height_px),
                settings=SETTINGS,
            )
        return self.frames[key]


@dataclass(frozen=True)
class FakeOutcome:
    step: int
    reward: float
    event: str | None
    status: Status


class FakeTask:
    """A line of points; the target is the fourth, a trap lies left of the start."""

    def __init__(self, host: Host, seed: int) -> None:
        self._host = host
        self._seed = seed
        self._x = self._steps = 0

    def set_up(self) -> None:
        self._host.show("black")
        self._host.lay_out([Placement(slot=7, kind="cube", colour="red", x=3, y=self._seed % 4)])
        self.reset()

    def reset(self) -> None:
        self._x = self._steps = 0
        self._host.move_to(0, 0, 65.0)

    def act(self, action: str) -> FakeOutcome:
        self._steps += 1
        if action == "UP":
            return FakeOutcome(self._steps, -10.0, "Robot hit the wall", "running")
        self._x += 1 if action == "RIGHT" else -1
        self._host.move_to(self._x, 0, 65.0)
        if self._x == 3:
            return FakeOutcome(self._steps, 20.0, "Target reached", "finished")
        if self._x < 0:
            return FakeOutcome(self._steps, -50.0, None, "failed")
        return FakeOutcome(self._steps, 0.25 if self._x == 2 else 0.0, "Robot move", "running")

    def suggest(self) -> str | None:
        return "RIGHT" if self._x < 3 else None


@dataclass
class FakeScript:
    """Two goals; the second one has no teacher."""

    name: str = "line.cell"
    text: str = "# a line\n"
    goals: tuple[str, ...] = ("Reach", "Wander")

    def environments(self, goal: str) -> tuple[str, ...]:
        return ("LINE", "OTHER") if goal == "Reach" else ("LINE",)

    def task(self, goal: str, environment: str) -> TaskSpec:
        return TaskSpec(
            goal=goal,
            environment=environment,
            actions=("UP", "LEFT", "RIGHT"),
            views=(
                ViewSpec(name="CAMERA_TOP", mime="image/mif", width_px=640, height_px=480),
                ViewSpec(name="CAMERA_GRIPPER", mime="image/pgm", width_px=1280, height_px=960),
            ),
            is_teaching=goal == "Reach",
        )

    def start(self, goal: str, environment: str, *, seed: int, host: Host) -> RunningTask:
        return FakeTask(host, seed)


@dataclass
class FakeJournal:
    """Writes down what it is told."""

    start: SessionStart
    notes: list[tuple[str, object]] = field(default_factory=list)

    def received(self, line: bytes) -> None:
        self.notes.append(("received", line))

    def replied(self, reply: Reply) -> None:
        self.notes.append(("replied", reply.text))

    def settled(self) -> None:
        pass

    def close(self, reason: str) -> None:
        self.notes.append(("closed", reason))


def no_journal(start: SessionStart) -> Journal:
    return NoJournal()


def make_desk(
    cell: FakeCell,
    *,
    seed: int = 42,
    journal_factory: Callable[[SessionStart], Journal] = no_journal,
    limits: ServerProfile | None = None,
    events: EventBus | None = None,
) -> Desk:
    """Return a desk over a fake cell and the fake script."""
    profile = PROFILE if limits is None else PROFILE.model_copy(update={"server": limits})
    return Desk(
        cell,
        FakeScript(),
        profile,
        events=events or EventBus(SimulatedClock()),
        seed=seed,
        journal_factory=journal_factory,
        new_session_id=lambda: "session-1",
    )


def make_session(desk: Desk, version: str = "1.5", peer: str = "test:1") -> Session:
    return Session(desk, DIALECTS[version], peer)


def say(session: Session, *lines: str) -> str:
    """Send lines; return the text of the last reply, without its last LF."""
    text = b""
    for line in lines:
        text = session.handle(line.encode()).text
    return text.decode().removesuffix("\n")


TO_READY = ("INITIALIZE_TASK Reach LINE", "BEGIN_TASK_SETUP", "END_TASK_SETUP")
