"""A served twin cell on which faults happen when they are due, and a record of what moved when."""

from __future__ import annotations

import logging
import math
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from cell.assembly import assemble_twin
from cell.drivers.schunk_smp.tables import Command
from cell.events import ArmHeld, Body, DeviceOpened, EventBus, ResumeChecked
from cell.links.base import Direction
from cell.profile import parse_profile, profile_text
from cell.twin.behind import Behind
from cell.twin.timetable import EventfulClock, Timetable
from cell.twin_cell import TwinCell
from dsl.library import library_script
from sessions.desk import Desk
from sessions.hosting import store_plan
from sessions.script_source import served_script
from sessions.session import Session
from sessions.wire.dialects import dialect_named

TEXT = profile_text("mash")
PROFILE = parse_profile(TEXT, "mash")
SCRIPT = served_script(library_script("mash"), "mash.cell")
HOME_WITHIN_MM = 8.0
FALLEN_WITHIN_MM = 40.0
LONGEST_S = 3600.0
DEADLINE_S = 60

_ARM_MOTIONS = (b"EXECMOV", b"EXECMVS", b"EXECHOPEN", b"EXECHCLOSE", b";RUN", b";MOVSP", b";HND")
_GRIPPER_MOTIONS = {
    Command.REFERENCE,
    Command.MOVE_POSITION,
    Command.MOVE_POSITION_RELATIVE,
    Command.MOVE_POSITION_TIME,
    Command.MOVE_POSITION_TIME_RELATIVE,
    Command.MOVE_CURRENT,
    Command.MOVE_VELOCITY,
    Command.MOVE_GRIP,
}


def starts_motion(link: str, data: bytes) -> bool:
    """Return whether bytes to a device start a motion."""
    if link == "arm":
        return any(word in data for word in _ARM_MOTIONS)
    return link == "gripper" and len(data) > 3 and data[3] in _GRIPPER_MOTIONS


class Hang(BaseException):
    """A session took longer than any may; passes every `except Exception`."""


class BoundedClock(EventfulClock):
    """A clock that ends a session that waits for ever."""

    def sleep(self, duration_s: float) -> None:
        super().sleep(duration_s)
        if self.now_s() > LONGEST_S:
            raise Hang(f"more than {LONGEST_S:.0f} s of simulated time")


class Witness(EventBus):
    """An event bus that keeps, in one order, openings, stops, checks and motions on the wires."""

    def __init__(self, clock: EventfulClock) -> None:
        super().__init__(clock)
        self.bodies: list[Body] = []
        self.is_held = False
        self.wrong: list[str] = []
        self.motions = 0

    def emit(self, body: Body) -> None:
        self.bodies.append(body)
        if isinstance(body, ArmHeld) or (isinstance(body, DeviceOpened) and body.device == "arm"):
            self.is_held = True
        elif isinstance(body, ResumeChecked) and body.is_clear:
            self.is_held = False
        super().emit(body)

    def saw(self, link: str, data: bytes) -> None:
        if starts_motion(link, data):
            self.motions += 1
            if self.is_held:
                self.wrong.append(f"{link}: {data!r} while held")


class FaultRig:
    """The cell, its desk, the timetable of faults, and the witness."""

    def __init__(self, seed: int) -> None:
        self.timetable = Timetable(BoundedClock())
        self.witness = Witness(self.timetable.clock)

        def tap(link: str, direction: Direction, data: bytes) -> None:
            if direction == "to_device":
                self.witness.saw(link, data)
            self.timetable(link, direction, data)

        self.cell: TwinCell = assemble_twin(
            PROFILE,
            store_plan(SCRIPT),
            seed=seed,
            clock=self.timetable.clock,
            tap=tap,
            events=self.witness,
        )
        self.desk = Desk(
            self.cell, SCRIPT, PROFILE, events=self.witness, profile_text=TEXT, seed=seed
        )

    @property
    def behind(self) -> Behind:
        return self.cell.behind

    def now_s(self) -> float:
        return self.timetable.clock.now_s()

    def session(self, peer: str) -> Talk:
        return Talk(Session(self.desk, dialect_named("1.5"), peer))

    def off_home_mm(self) -> dict[int, float]:
        """Return how far every block lies from its slot, by slot number."""
        off = {}
        for block in self.cell.world.whereabouts():
            number = int(block.block.removeprefix("slot "))
            home = self.cell.manipulator.slot_place(number)
            off[number] = math.hypot(block.x_mm - home.x_mm, block.y_mm - home.y_mm)
        return off

    def assert_ledger_true(self, loose: frozenset[int]) -> None:
        """Hold the ledger against the twin's truth: every block is where the ledger has it.

        Args:
            loose: Blocks that fell down, which lie where they rolled.
        """
        out, strays = self.cell.ledger.blocks_out(), self.cell.ledger.strays()
        for block in self.cell.world.whereabouts():
            number = int(block.block.removeprefix("slot "))
            if number in strays:
                continue
            place = out.get(number) or self.cell.manipulator.slot_place(number)
            off = math.hypot(block.x_mm - place.x_mm, block.y_mm - place.y_mm)
            within = FALLEN_WITHIN_MM if number in loose else HOME_WITHIN_MM
            assert off < within, f"slot {number}'s block is {off:.1f} mm from where it is noted"

    def put_strays_back(self) -> None:
        """Do what a person is asked to do: put lost blocks into their slots."""
        for number in self.cell.ledger.strays():
            home = self.cell.manipulator.slot_place(number)
            block = next(b for b in self.cell.world.whereabouts() if b.block == f"slot {number}")
            self.cell.world.blocks.put(
                replace(
                    block,
                    x_mm=home.x_mm,
                    y_mm=home.y_mm,
                    z_mm=PROFILE.heights.surface_mm,
                    yaw_deg=home.yaw_deg,
                )
            )


class Talk:
    """One client's session: lines in, the first lines of replies out."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.replies: list[str] = []

    def say(self, line: str) -> str:
        reply = self._session.handle(line.encode()).text.decode()
        first = reply.split("\n", 1)[0]
        self.replies.append(first)
        return first

    def set_up(self) -> str:
        self.say("BEGIN_TASK_SETUP")
        return self.say("END_TASK_SETUP")

    def end(self) -> None:
        self._session.end("closed")


@contextmanager
def deadline(seed: int) -> Iterator[None]:
    """End a session that hangs in real time."""

    def ring(number: int, frame: object) -> None:
        raise Hang(f"seed {seed}: more than {DEADLINE_S} s of real time")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(DEADLINE_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


class Lines(logging.Handler):
    """Keeps the operator's lines."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(record.getMessage())
