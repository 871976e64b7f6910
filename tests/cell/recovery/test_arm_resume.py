"""The check before the arms of avrs and lynx go on: nothing moves them before it is clear."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from importlib import resources

import pytest

from cell.assembly.arms import TwinArmStation, twin_arm
from cell.clock import SimulatedClock
from cell.drivers.ibm7545.registers import Command, Register
from cell.errors import CellError, DeviceError, LinkError, ResumeRefused, SafeStop
from cell.events import EventBus, ResumeChecked, Subscription
from cell.geometry import JointPositions
from cell.profile import CellProfile
from cell.twin.emulators.ibm7545 import RegisterBridge
from cell.twin.emulators.ssc32 import Ssc32Controller
from cell.twin.wire_faults import WireFault


def profile(name: str) -> CellProfile:
    text = (resources.files("cell") / "profiles" / f"{name}.toml").read_text("utf-8")
    return CellProfile.model_validate(tomllib.loads(text))


HERE = {
    "avrs": JointPositions((45.0, 105.0, -20.0, 0.0)),
    "lynx": JointPositions((20.0, -20.0, 40.0, 40.0, 0.0)),
}
THERE = {
    "avrs": JointPositions((60.0, 90.0, -40.0, 0.0)),
    "lynx": JointPositions((-20.0, -30.0, 40.0, 40.0, 0.0)),
}


class Rig:
    """A station on its twin, standing at `HERE`, and where its motors were told to be."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.clock = SimulatedClock()
        self.events = EventBus(self.clock)
        self.heard: Subscription = self.events.subscribe()[0]
        self.station: TwinArmStation = twin_arm(profile(name), clock=self.clock, events=self.events)
        self.station.arm.open()
        self.station.arm.move_joints(HERE[name])

    def move(self) -> None:
        self.station.arm.move_joints(THERE[self.name])

    def hold(self, fault: WireFault = WireFault.SILENT) -> None:
        """Hold the arm by a fault that leaves nothing behind."""
        self.station.wire.inject(fault)
        with pytest.raises((DeviceError, LinkError)):
            self.move()
        self.station.wire.clear()
        assert self.station.arm.is_held

    def motors(self) -> tuple[float, ...]:
        """Return where the motors are told to be, or stand."""
        emulator = self.station.emulator
        if isinstance(emulator, RegisterBridge):
            return tuple(round(p) for p in emulator.slave.mechanics.positions)
        return tuple(emulator.pulse_us(channel, self.clock.now_s()) for channel in range(6))

    def refuses(self, words: str, deed: Callable[[], object] | None = None) -> None:
        """See that a motion is refused in words, and that nothing moved."""
        before = self.motors()
        with pytest.raises(ResumeRefused, match=words):
            (deed or self.move)()
        self.clock.sleep(5.0)
        assert self.motors() == before

    def checks(self) -> list[bool]:
        return [e.body.is_clear for e in self.heard.take() if isinstance(e.body, ResumeChecked)]

    @property
    def slave(self) -> RegisterBridge:
        assert isinstance(self.station.emulator, RegisterBridge)
        return self.station.emulator

    @property
    def servos(self) -> Ssc32Controller:
        assert isinstance(self.station.emulator, Ssc32Controller)
        return self.station.emulator


@pytest.fixture(params=["avrs", "lynx"])
def rig(request: pytest.FixtureRequest) -> Rig:
    return Rig(str(request.param))


def test_after_a_fault_that_is_over_the_check_is_clear_and_the_arm_goes_on(rig: Rig) -> None:
    if rig.name == "avrs":
        assert rig.station.gripper is not None
        rig.station.gripper.move_to(30.0)
    rig.hold()
    rig.move()
    assert rig.checks() == [True]
    assert not rig.station.arm.is_held
    found = rig.station.driver.read_joints().values
    assert found == pytest.approx(THERE[rig.name].values, abs=0.1)


def test_after_a_stop_was_asked_for_the_check_is_made_before_anything_moves(rig: Rig) -> None:
    if rig.name == "avrs":
        assert rig.station.gripper is not None
        rig.station.gripper.move_to(30.0)
    rig.station.stop.stop("a test")
    with pytest.raises(CellError):
        rig.move()
    rig.station.stop.clear()
    rig.station.wire.inject(WireFault.SILENT)
    rig.refuses("not ready|nobody knows")
    rig.station.wire.clear()
    rig.move()
    assert rig.checks() == [False, True]


def test_a_silent_arm_stays_held(rig: Rig) -> None:
    rig.hold()
    rig.station.wire.inject(WireFault.SILENT)
    rig.refuses("not ready|nobody knows")
    assert rig.checks()[-1] is False


def test_an_arm_that_was_moved_by_hand_is_noticed_until_it_was_opened_again(rig: Rig) -> None:
    rig.hold()
    if rig.name == "avrs":
        rig.slave.slave.push_joint(0, 60_000.0, rig.clock.now_s())
    else:
        rig.servos.receive(b"#2P1500T500\r", rig.clock.now_s())
        rig.clock.sleep(1.0)
    rig.refuses("moved by hand")
    rig.station.arm.close()
    rig.station.arm.open()
    if rig.name == "avrs":
        rig.station.confirm_grip()
    rig.move()


def test_an_arm_that_was_restarted_is_not_moved_to_find_its_place(rig: Rig) -> None:
    rig.hold()
    if rig.name == "avrs":
        rig.slave.slave.switch(rig.clock.now_s(), is_on=False)
        rig.slave.slave.switch(rig.clock.now_s(), is_on=True)
    else:
        rig.servos.cut_power(rig.clock.now_s())
        rig.servos.restore_power(rig.clock.now_s())
        rig.clock.sleep(1.0)
    rig.refuses("nobody knows where the arm stands")
    rig.station.arm.close()
    rig.station.arm.open()
    if rig.name == "avrs":
        rig.station.confirm_grip()
    rig.move()


def test_fingers_that_measure_nothing_have_to_be_looked_at(rig: Rig) -> None:
    gripper = rig.station.gripper
    assert gripper is not None
    gripper.open()
    gripper.grip(1.0)
    rig.hold()
    rig.refuses("nobody knows what the fingers hold.*look, and confirm")
    rig.refuses("nobody knows what the fingers hold", lambda: gripper.move_to(20.0))
    rig.station.confirm_grip()
    rig.move()


def test_a_confirmed_grip_counts_for_one_check(rig: Rig) -> None:
    gripper = rig.station.gripper
    assert gripper is not None
    gripper.open()
    gripper.grip(1.0)
    rig.hold()
    rig.station.confirm_grip()
    rig.station.arm.ensure_clear()
    rig.hold()
    rig.refuses("look, and confirm the grip")


def test_an_emergency_stop_is_named_and_after_it_the_arm_is_taken_into_service_again() -> None:
    rig = Rig("avrs")
    assert rig.station.gripper is not None
    rig.station.gripper.move_to(30.0)
    rig.slave.press_emergency_stop(rig.clock.now_s())
    with pytest.raises(SafeStop):
        rig.move()
    rig.station.arm.allow_resume()
    rig.refuses("emergency stop is pressed")
    rig.slave.release_emergency_stop(rig.clock.now_s())
    rig.move()


def test_a_joint_past_its_limit_is_named() -> None:
    rig = Rig("avrs")
    rig.hold()
    rig.station.arm.close()
    rig.station.arm.open()
    rig.slave.slave.push_joint(1, 61_000.0, rig.clock.now_s())
    rig.refuses("J2 stands at|alarm|not ready")


@pytest.mark.parametrize("fault", [WireFault.SILENT, WireFault.UNPLUGGED])
def test_no_servo_command_is_on_the_wire_before_the_check_is_clear(fault: WireFault) -> None:
    rig = Rig("avrs")
    rig.hold(fault)
    written: list[int] = []
    slave = rig.slave.slave
    write = slave.write

    def watch(offset: int, words: tuple[int, ...]) -> None:
        if offset == Register.COMMAND:
            written.append(words[0])
        write(offset, words)

    slave.write = watch  # type: ignore[method-assign]
    rig.refuses("nobody knows what the fingers hold")
    assert not any(word & (Command.SERVO | Command.FIND_HOME) for word in written)
    rig.station.confirm_grip()
    rig.move()
    assert any(word & Command.SERVO for word in written)
