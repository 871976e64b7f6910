from __future__ import annotations

import threading

import pytest

from cell.clock import SimulatedClock, SystemClock
from cell.errors import DeviceError
from cell.recovery.opening import OpeningFailed, Step, bring_up


def meet(meeting: threading.Barrier) -> None:
    meeting.wait()


def failing(device: str) -> Step:
    def run() -> None:
        raise DeviceError(device, "is silent", hint="look at its cable")

    return Step(device, run)


def noting(device: str, notes: list[str]) -> Step:
    return Step(device, lambda: notes.append(device))


def test_on_a_simulated_clock_devices_come_up_in_order() -> None:
    notes: list[str] = []
    bring_up(([noting("arm", notes), noting("gripper", notes)], [noting("display", notes)]),
             SimulatedClock())  # fmt: skip
    assert notes == ["arm", "gripper", "display"]


def test_on_the_systems_clock_they_come_up_at_the_same_time() -> None:
    meeting = threading.Barrier(2, timeout=10)
    bring_up(([Step("arm", lambda: meet(meeting))],
              [Step("display", lambda: meet(meeting))]), SystemClock())  # fmt: skip
    assert not meeting.broken


@pytest.mark.parametrize("clock", [SimulatedClock(), SystemClock()])
def test_one_failure_is_told_as_it_is_and_the_other_chain_goes_on(
    clock: SimulatedClock | SystemClock,
) -> None:
    notes: list[str] = []
    with pytest.raises(DeviceError, match="^arm: is silent; look at its cable$"):
        bring_up(([failing("arm"), noting("gripper", notes)], [noting("display", notes)]), clock)
    assert notes == ["display"]


def test_all_failures_are_told_in_one_report() -> None:
    with pytest.raises(OpeningFailed, match="2 devices.*1. arm: .*2. display: ") as caught:
        bring_up(([failing("arm")], [failing("display")]), SimulatedClock())
    assert [failure.device for failure in caught.value.failures] == ["arm", "display"]
