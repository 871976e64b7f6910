import dataclasses
import threading

import pytest

from cell.clock import SimulatedClock
from cell.events import (
    DeviceClosed,
    DeviceFailed,
    DeviceOpened,
    Event,
    EventBus,
    LightsSwitched,
    PictureShown,
    Subscription,
)


def test_events_are_stamped_with_order_and_time() -> None:
    clock = SimulatedClock(2.0)
    bus = EventBus(clock)
    subscription, _ = bus.subscribe()
    bus.emit(LightsSwitched(True))
    clock.sleep(0.5)
    bus.emit(PictureShown("black"))
    assert subscription.take() == [
        Event(1, 2.0, LightsSwitched(True)),
        Event(2, 2.5, PictureShown("black")),
    ]


def test_taking_empties_the_queue() -> None:
    bus = EventBus(SimulatedClock())
    subscription, _ = bus.subscribe()
    bus.emit(DeviceClosed("arm"))
    assert len(subscription.take()) == 1
    assert subscription.take() == []


def test_every_subscriber_gets_every_event() -> None:
    bus = EventBus(SimulatedClock())
    subscriptions = [bus.subscribe()[0] for _ in range(3)]
    bus.emit(DeviceOpened("arm", "RV-6SDL"))
    bus.emit(DeviceFailed("arm", "silent"))
    taken = [subscription.take() for subscription in subscriptions]
    assert taken[0] == taken[1] == taken[2]
    assert [event.sequence for event in taken[0]] == [1, 2]


def test_who_comes_later_gets_only_what_comes_later_with_its_true_number() -> None:
    bus = EventBus(SimulatedClock())
    bus.emit(DeviceClosed("arm"))
    subscription, _ = bus.subscribe()
    bus.emit(DeviceClosed("gripper"))
    assert [event.sequence for event in subscription.take()] == [2]


def test_a_full_queue_drops_the_oldest_and_counts_them() -> None:
    bus = EventBus(SimulatedClock())
    small, _ = bus.subscribe(capacity=3)
    large, _ = bus.subscribe(capacity=10)
    for number in range(8):
        bus.emit(PictureShown(str(number)))
    assert small.dropped == 5
    assert [event.sequence for event in small.take()] == [6, 7, 8]
    assert large.dropped == 0
    assert len(large.take()) == 8


def test_room_made_by_taking_is_used_before_anything_is_dropped() -> None:
    subscription = Subscription(2)
    event = Event(1, 0.0, LightsSwitched(False))
    for _ in range(5):
        subscription.offer(event)
        subscription.offer(event)
        subscription.take()
    assert subscription.dropped == 0


def test_after_unsubscribing_nothing_more_arrives_but_what_is_queued_stays() -> None:
    bus = EventBus(SimulatedClock())
    gone, unsubscribe = bus.subscribe()
    stays, _ = bus.subscribe()
    bus.emit(LightsSwitched(True))
    unsubscribe()
    unsubscribe()
    bus.emit(LightsSwitched(False))
    assert [event.sequence for event in gone.take()] == [1]
    assert [event.sequence for event in stays.take()] == [1, 2]


def test_events_cannot_be_changed() -> None:
    event = Event(1, 0.0, LightsSwitched(True))
    with pytest.raises(dataclasses.FrozenInstanceError):
        event.sequence = 2  # type: ignore[misc]


def test_numbers_are_in_order_for_everybody_when_several_threads_emit() -> None:
    bus = EventBus(SimulatedClock())
    subscription, _ = bus.subscribe()

    def emit_often() -> None:
        for _ in range(500):
            bus.emit(LightsSwitched(True))

    threads = [threading.Thread(target=emit_often) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [event.sequence for event in subscription.take()] == list(range(1, 2001))
