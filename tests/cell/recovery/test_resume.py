"""The check before going on, on a whole twin cell: what it refuses, and that nothing gets by it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from cell.errors import DeviceError, ResumeRefused, SafeStop
from cell.geometry import JointPositions
from cell.manipulation import Deployment
from cell.store import TablePlace
from cell.twin.wire_faults import WireFault
from tests.sessions.fault_rig import FaultRig, starts_motion


@pytest.fixture
def rig() -> Iterator[FaultRig]:
    rig = FaultRig(5)
    rig.cell.open()
    rig.cell.move_to(650.0, -165.0, 150.0)
    yield rig
    assert rig.witness.wrong == []
    rig.cell.dispose()


def hold(rig: FaultRig) -> None:
    """Hold the arm by a fault that leaves nothing behind."""
    rig.behind.wires["arm"].inject(WireFault.SILENT)
    with pytest.raises(DeviceError):
        rig.cell.move_to(650.0, -105.0, 150.0)
    rig.behind.wires["arm"].clear()
    assert rig.cell.arm.is_held


def stop(rig: FaultRig) -> None:
    """Stop the cell by a button in the middle of a motion."""
    press = rig.behind.controller.press_stop_button
    rig.timetable.at_request(
        "arm",
        1,
        lambda now_s: rig.timetable.at_time(now_s + 0.05, press),
        counts=lambda data: starts_motion("arm", data),
    )
    with pytest.raises(SafeStop):
        rig.cell.move_to(650.0, -105.0, 150.0)


MOTIONS: dict[str, Callable[[FaultRig], object]] = {
    "move_to": lambda rig: rig.cell.move_to(670.0, -165.0, 150.0),
    "move_joints": lambda rig: rig.cell.move_joints(JointPositions((10, 20, 100, 0, 60, 0))),
    "lay_out": lambda rig: rig.cell.lay_out([Deployment(slot=7, x_mm=650.0, y_mm=-105.0)]),
    "clean": lambda rig: rig.cell.clean(),
    "deploy": lambda rig: rig.cell.deploy(7, TablePlace(x_mm=650.0, y_mm=-105.0, yaw_deg=0.0)),
    "grip_at": lambda rig: rig.cell.grip_at(rig.cell.manipulator.slot_place(7)),
    "clean_from_picture": lambda rig: rig.cell.clean_from_picture(),
    "gripper.move_to": lambda rig: rig.cell.gripper.move_to(20.0),
    "gripper.grip": lambda rig: rig.cell.gripper.grip(1.0),
    "gripper.reference": lambda rig: rig.cell.gripper.reference(),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_after_a_stop_no_way_of_moving_moves(rig: FaultRig, name: str) -> None:
    stop(rig)
    motions = rig.witness.motions
    with pytest.raises(ResumeRefused, match="the cell was stopped"):
        MOTIONS[name](rig)
    assert rig.witness.motions == motions


@pytest.mark.parametrize("name", MOTIONS)
def test_after_a_hold_every_way_of_moving_is_checked_first(rig: FaultRig, name: str) -> None:
    hold(rig)
    rig.behind.controller.set_key_switch(rig.now_s(), is_automatic=False)
    motions = rig.witness.motions
    with pytest.raises(ResumeRefused, match="TEACH"):
        MOTIONS[name](rig)
    assert rig.witness.motions == motions


def test_opening_again_is_how_somebody_says_that_it_may_go_on(rig: FaultRig) -> None:
    stop(rig)
    rig.cell.open()
    rig.cell.move_to(650.0, -105.0, 150.0)
    assert not rig.cell.arm.is_held


def test_a_pressed_emergency_stop_is_named(rig: FaultRig) -> None:
    hold(rig)
    rig.behind.controller.press_emergency_stop(rig.now_s())
    with pytest.raises(ResumeRefused, match="emergency stop"):
        rig.cell.clean()
    rig.behind.controller.release_emergency_stop(rig.now_s())
    rig.cell.clean()


def test_an_arm_moved_by_hand_is_noticed_until_the_session_ends(rig: FaultRig) -> None:
    hold(rig)
    world = rig.cell.world
    j1, *rest = world.joints_deg(rig.now_s())
    world.restore(
        blocks=world.whereabouts(),
        joints_deg=(j1 + 15.0, *rest),  # type: ignore[arg-type]
        opening_mm=world.opening_mm(rig.now_s()),
        held=None,
        outputs=dict(world.outputs),
        is_gripper_referenced=True,
    )
    with pytest.raises(ResumeRefused, match=r"mm off the line it was on.*moved by hand"):
        rig.cell.move_to(650.0, -105.0, 150.0)
    rig.cell.close()
    rig.cell.open()
    rig.cell.move_to(650.0, -105.0, 150.0)


def test_a_silent_gripper_means_that_nobody_knows_what_it_holds(rig: FaultRig) -> None:
    hold(rig)
    rig.behind.wires["gripper"].inject(WireFault.SILENT)
    with pytest.raises(ResumeRefused, match="nobody knows what the fingers hold"):
        rig.cell.clean()
    rig.behind.wires["gripper"].clear()
    rig.cell.clean()


@pytest.mark.parametrize("device", ["arm", "gripper", "display"])
def test_a_device_whose_power_was_away_has_forgotten_and_is_brought_up_again(
    rig: FaultRig, device: str
) -> None:
    wire = rig.behind.wires[device]
    wire.inject(WireFault.POWER)
    uses: dict[str, Callable[[], None]] = {
        "arm": lambda: rig.cell.move_to(650.0, -105.0, 150.0),
        "gripper": lambda: rig.cell.gripper.move_to(20.0),
        "display": lambda: rig.cell.show("water"),
    }
    use = uses[device]
    with pytest.raises(DeviceError):
        use()
    assert rig.cell.arm.is_held
    if device == "display":
        assert not rig.behind.television.is_on
    else:
        assert not rig.cell.world.is_gripper_referenced
    wire.clear()
    if device == "display":
        # Without permission from before, this set is switched on by hand once.
        rig.behind.television.press_power(rig.now_s())
    use()
    rig.cell.clean()
    assert not rig.cell.arm.is_held
