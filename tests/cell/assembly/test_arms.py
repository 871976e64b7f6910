"""The arms of the avrs and lynx cells on their twins: guarded, in memory and over a pty."""

from __future__ import annotations

import tomllib
from importlib import resources

import pytest

from cell.assembly.arms import TwinArmStation, chain_guard, hardware_arm, twin_arm
from cell.assembly.wires import TwinWires
from cell.clock import SimulatedClock
from cell.errors import DeviceTimeout, LinkError, MotionRefused, ProfileError
from cell.geometry import JointPositions, Pose
from cell.profile import CellProfile, load_profile
from cell.twin.emulators.ibm7545 import RegisterBridge


def cell(name: str) -> CellProfile:
    text = (resources.files("cell") / "profiles" / f"{name}.toml").read_text("utf-8")
    return CellProfile.model_validate(tomllib.loads(text))


AVRS, LYNX = cell("avrs"), cell("lynx")
OVER_THE_WINDOW = JointPositions((45.0, 105.0, -20.0, 0.0))


def _scara(wires: TwinWires = "memory") -> TwinArmStation:
    return twin_arm(AVRS, clock=SimulatedClock(), wires=wires)


@pytest.mark.parametrize("wires", ["memory", "pty"])
def test_the_scara_picks_and_places_through_its_guard(wires: TwinWires) -> None:
    station = _scara(wires)
    try:
        station.arm.open()
        station.arm.move_joints(OVER_THE_WINDOW)
        over = station.arm.pose()
        assert station.gripper is not None
        station.arm.move_linear(over.at_height(-227.7))
        assert station.gripper.grip(0.0).is_holding
        station.arm.move_linear(over.at_height(-200.0))
        assert isinstance(station.emulator, RegisterBridge)
        assert station.emulator.slave.is_closed
        assert station.driver.read_pose().z_mm == pytest.approx(-200.0, abs=0.05)
        station.arm.close()
    finally:
        station.dispose()


def test_what_the_guard_refuses_reaches_no_motor() -> None:
    traffic: list[bytes] = []
    station = twin_arm(
        AVRS, clock=SimulatedClock(), tap=lambda link, direction, data: traffic.append(data)
    )
    station.arm.open()
    station.arm.move_joints(OVER_THE_WINDOW)
    before = len(traffic)
    with pytest.raises(MotionRefused, match="into the table"):
        station.arm.move_linear(station.arm.pose().at_height(-240.0))
    assert len(traffic) == before


@pytest.mark.parametrize("wires", ["memory", "pty"])
def test_the_lynx_moves_through_its_guard(wires: TwinWires) -> None:
    station = twin_arm(LYNX, clock=SimulatedClock(), wires=wires)
    try:
        station.arm.open()
        target = JointPositions((20.0, -20.0, 40.0, 40.0, 0.0))
        station.arm.move_joints(target)
        assert station.driver.read_joints().values == pytest.approx(target.values, abs=0.1)
        here = station.arm.pose()
        station.arm.move_linear(here.at_height(here.z_mm + 15.0))
        assert station.driver.read_pose().z_mm == pytest.approx(here.z_mm + 15.0, abs=1.0)
        with pytest.raises(MotionRefused, match="table"):
            station.arm.move_linear(here.at_height(-20.0))
        station.arm.close()
    finally:
        station.dispose()


def test_hardware_is_the_port_of_the_profile_and_opened_only_when_used() -> None:
    profile = AVRS.model_copy(
        update={
            "arm": AVRS.arm.model_copy(
                update={"serial": AVRS.arm.serial.model_copy(update={"port": "/dev/none-such"})}
            )
        }
    )
    warnings: list[str] = []
    station = hardware_arm(profile, clock=SimulatedClock(), on_warning=warnings.append)
    assert warnings == []
    with pytest.raises((DeviceTimeout, LinkError), match="none-such"):
        station.arm.open()
    assert any("never tried on hardware" in text for text in warnings)
    station.dispose()


def test_another_arm_is_a_profile_error_that_says_where_to_go() -> None:
    with pytest.raises(ProfileError, match="melfa-rv6sdl.*assemble_twin"):
        chain_guard(load_profile("mash"))


def test_every_rest_pose_is_allowed_from_home() -> None:
    guard = chain_guard(AVRS)
    move = guard.check_joint(
        JointPositions((0.0, 0.0, 0.0, 0.0)), JointPositions((45.0, 105.0, 0.0, 0.0)), percent=100
    )
    assert move.duration_s == pytest.approx(105.0 / 50.0)
    assert isinstance(move.end_pose, Pose)
