"""One vocabulary of frozen records of what happens, and the bus that carries them.

A body says what happened; the bus stamps it with time and sequence number into
an `Event`. Subscribers read at their own pace from bounded queues: they can
neither block the cell nor change what it does, and what they miss is counted.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from cell.clock import Clock
from cell.geometry import Pose


@dataclass(frozen=True, slots=True)
class DeviceOpened:
    """A device is connected and ready."""

    device: str
    identity: str


@dataclass(frozen=True, slots=True)
class DeviceClosed:
    """A device was let go."""

    device: str


@dataclass(frozen=True, slots=True)
class DeviceFailed:
    """A device refused, failed or fell silent."""

    device: str
    problem: str


@dataclass(frozen=True, slots=True)
class DeviceSkipped:
    """Something was left out because the profile disables the device."""

    device: str
    what: str


@dataclass(frozen=True, slots=True)
class RequestRepeated:
    """A request that may be repeated was sent again, because the answer was lost or broken."""

    device: str
    problem: str


@dataclass(frozen=True, slots=True)
class DeviceRecovered:
    """A device that had failed is in service again."""

    device: str
    how: str


@dataclass(frozen=True, slots=True)
class ArmHeld:
    """The arm was stopped after a fault; it moves again only after a check."""

    reason: str


@dataclass(frozen=True, slots=True)
class ResumeChecked:
    """Pose, grip and clearance were checked before the arm may move again."""

    is_clear: bool
    detail: str


@dataclass(frozen=True, slots=True)
class ComponentTested:
    """The watchdog tested a component."""

    component: str
    is_ok: bool
    detail: str


@dataclass(frozen=True, slots=True)
class MotionFinished:
    """The arm arrived at `pose` (robot frame, tool point)."""

    pose: Pose


@dataclass(frozen=True, slots=True)
class MotionRejected:
    """The guard turned a motion down before anything was sent."""

    reason: str


@dataclass(frozen=True, slots=True)
class BlockGripped:
    """The fingers closed on a block."""

    block: str
    width_mm: float


@dataclass(frozen=True, slots=True)
class BlockReleased:
    """The fingers let a block go at `x_mm`, `y_mm` (robot frame)."""

    block: str
    x_mm: float
    y_mm: float
    yaw_deg: float


@dataclass(frozen=True, slots=True)
class PictureShown:
    """The screen under the playground shows another picture."""

    picture: str


@dataclass(frozen=True, slots=True)
class LightsSwitched:
    """The cell's lights went on or off."""

    is_on: bool


@dataclass(frozen=True, slots=True)
class FrameTaken:
    """A camera took a frame; the frame itself travels beside the event."""

    camera: str
    number: int
    width_px: int
    height_px: int


@dataclass(frozen=True, slots=True)
class TaskStarted:
    """A task was laid out and is ready for actions."""

    goal: str
    environment: str
    seed: int
    blocks: int


@dataclass(frozen=True, slots=True)
class StepTaken:
    """One action was carried out and rewarded."""

    step: int
    action: str
    x: int
    y: int
    reward: float
    event: str
    status: str


@dataclass(frozen=True, slots=True)
class TaskEnded:
    """The table is clean again."""

    reason: str


Body: TypeAlias = (
    DeviceOpened
    | DeviceClosed
    | DeviceFailed
    | DeviceSkipped
    | RequestRepeated
    | DeviceRecovered
    | ArmHeld
    | ResumeChecked
    | ComponentTested
    | MotionFinished
    | MotionRejected
    | BlockGripped
    | BlockReleased
    | PictureShown
    | LightsSwitched
    | FrameTaken
    | TaskStarted
    | StepTaken
    | TaskEnded
)


@dataclass(frozen=True, slots=True)
class Event:
    """What happened, when (seconds on the cell's clock), and in what order."""

    sequence: int
    time_s: float
    body: Body


class Subscription:
    """A bounded queue of events for one subscriber."""

    def __init__(self, capacity: int) -> None:
        self._queue: deque[Event] = deque(maxlen=capacity)
        self._lock = threading.Lock()
        self._dropped = 0

    @property
    def dropped(self) -> int:
        """How many events were lost because the queue was full."""
        return self._dropped

    def offer(self, event: Event) -> None:
        """Queue an event; when full, the oldest one is dropped and counted."""
        with self._lock:
            if len(self._queue) == self._queue.maxlen:
                self._dropped += 1
            self._queue.append(event)

    def take(self) -> list[Event]:
        """Return all queued events, oldest first, and empty the queue."""
        with self._lock:
            events = list(self._queue)
            self._queue.clear()
        return events


class EventBus:
    """Stamps bodies and hands them to every subscription."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._sequence = 0
        self._lock = threading.Lock()
        self._subscriptions: tuple[Subscription, ...] = ()

    def emit(self, body: Body) -> None:
        """Stamp a body with time and sequence number and hand it out."""
        with self._lock:
            self._sequence += 1
            event = Event(self._sequence, self._clock.now_s(), body)
            for subscription in self._subscriptions:
                subscription.offer(event)

    def subscribe(self, capacity: int = 10_000) -> tuple[Subscription, Callable[[], None]]:
        """Return a new subscription and the function that ends it."""
        subscription = Subscription(capacity)
        with self._lock:
            self._subscriptions = (*self._subscriptions, subscription)

        def unsubscribe() -> None:
            with self._lock:
                self._subscriptions = tuple(s for s in self._subscriptions if s is not subscription)

        return subscription, unsubscribe
