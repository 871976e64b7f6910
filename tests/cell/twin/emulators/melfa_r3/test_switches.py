"""The switches around the emulated controller, as a cell in the middle of its work meets them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from cell.errors import CellError, ResumeRefused, SafeStop
from cell.twin.emulators.melfa_r3.controller import MelfaController
from cell.twin.emulators.melfa_r3.state import StopButton
from tests.sessions.fault_rig import FaultRig


@pytest.fixture
def rig() -> Iterator[FaultRig]:
    rig = FaultRig(6)
    rig.cell.open()
    rig.cell.move_to(650.0, -165.0, 150.0)
    yield rig
    assert rig.witness.wrong == []
    rig.cell.dispose()


BARS: dict[str, tuple[Callable[[MelfaController, float], None], ...]] = {
    "machine lock": (
        lambda controller, now_s: controller.lock_machine(is_locked=True),
        lambda controller, now_s: controller.lock_machine(is_locked=False),
    ),
    "stop input": (
        lambda controller, now_s: controller.set_stop_input(now_s, is_on=True),
        lambda controller, now_s: controller.set_stop_input(now_s, is_on=False),
    ),
}


@pytest.mark.parametrize("name", BARS)
def test_a_barred_arm_stays_where_it_is_and_the_task_is_stopped(rig: FaultRig, name: str) -> None:
    bar, free = BARS[name]
    controller = rig.behind.controller
    bar(controller, rig.now_s())
    joints_deg = rig.cell.world.joints_deg(rig.now_s())
    with pytest.raises(SafeStop):
        rig.cell.move_to(650.0, -105.0, 150.0)
    assert rig.cell.world.joints_deg(rig.now_s()) == joints_deg
    free(controller, rig.now_s())
    rig.cell.open()
    rig.cell.move_to(650.0, -105.0, 150.0)


def test_an_enabled_pendant_has_the_arm_until_it_is_switched_off(rig: FaultRig) -> None:
    controller = rig.behind.controller
    controller.enable_pendant(rig.now_s(), is_enabled=True)
    with pytest.raises(CellError):
        rig.cell.move_to(650.0, -105.0, 150.0)
    rig.cell.open()
    with pytest.raises(ResumeRefused, match="not at AUTO"):
        rig.cell.move_to(650.0, -105.0, 150.0)
    controller.enable_pendant(rig.now_s(), is_enabled=False)
    rig.cell.move_to(650.0, -105.0, 150.0)


@pytest.mark.parametrize("where", ["panel", "pendant", "external"])
def test_every_emergency_stop_stops_and_its_alarm_stays_while_it_is_pressed(
    rig: FaultRig, where: StopButton
) -> None:
    controller = rig.behind.controller
    controller.press_emergency_stop(rig.now_s(), where)
    with pytest.raises(SafeStop):
        rig.cell.move_to(650.0, -105.0, 150.0)
    rig.cell.open()
    with pytest.raises(ResumeRefused, match="emergency stop"):
        rig.cell.move_to(650.0, -105.0, 150.0)
    controller.release_emergency_stop(rig.now_s())
    rig.cell.move_to(650.0, -105.0, 150.0)


def test_a_dead_output_stays_off(rig: FaultRig) -> None:
    power = rig.cell.profile.outputs.gripper_power
    rig.behind.controller.break_output(power, rig.now_s())
    rig.cell.set_output(power, is_on=True)
    assert not rig.cell.world.is_powered()
