import threading
import time

import pytest

from cell.clock import Clock, SimulatedClock, SystemClock


def test_simulated_time_passes_only_where_somebody_sleeps() -> None:
    clock = SimulatedClock(5.0)
    assert clock.now_s() == 5.0
    assert clock.now_s() == 5.0
    clock.sleep(0.25)
    assert clock.now_s() == 5.25


@pytest.mark.parametrize("duration_s", [0.0, -1.0, -1e-12])
def test_simulated_time_never_runs_backwards(duration_s: float) -> None:
    clock = SimulatedClock(5.0)
    clock.sleep(duration_s)
    assert clock.now_s() == 5.0


def test_simulated_hours_are_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    waited: list[float] = []
    monkeypatch.setattr(time, "sleep", waited.append)
    clock = SimulatedClock()
    clock.sleep(36_000.0)
    assert clock.now_s() == 36_000.0
    assert waited == []


def test_sleeps_of_several_threads_add_up() -> None:
    clock = SimulatedClock()

    def sleep_often() -> None:
        for _ in range(2000):
            clock.sleep(0.5)

    threads = [threading.Thread(target=sleep_often) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert clock.now_s() == 4000.0


def test_system_time_starts_at_zero_and_follows_the_machine(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    moments = iter([1000.0, 1000.0, 1002.5])
    monkeypatch.setattr(time, "monotonic", lambda: next(moments))
    clock = SystemClock()
    assert clock.now_s() == 0.0
    assert clock.now_s() == 2.5


def test_a_system_sleep_is_a_real_one_and_only_if_it_is_ahead(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    slept: list[float] = []
    monkeypatch.setattr(time, "sleep", slept.append)
    clock: Clock = SystemClock()
    for duration_s in (0.5, 0.0, -3.0):
        clock.sleep(duration_s)
    assert slept == [0.5]
