"""What every arm does, in every way in which a driver can have it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from cell.devices.arm import Arm
from cell.errors import DeviceError, DeviceTimeout
from cell.geometry import JointPositions, Pose
from tests.contracts.arm.arms import ARMS
from tests.contracts.arm.case import ArmCase, Place
from tests.contracts.harness import WAYS, Bench, player


@dataclass
class ArmBench:
    """An arm and whoever stands beside it; at a capture there is nobody."""

    arm: Arm
    case: ArmCase[Any]
    rig: object | None

    def go_above(self) -> None:
        self.arm.open()
        self.arm.move(
            self.case.above.pose,
            interpolation="joint",
            posture=self.case.posture,
            expected_s=1.5,
        )

    def go_beside(self, *, expected_s: float = 0.0) -> None:
        self.go_to(self.case.beside, expected_s=expected_s)

    def go_to(self, place: Place, *, expected_s: float = 0.0) -> None:
        case = self.case
        self.arm.move(
            place.pose,
            interpolation=case.interpolation,
            posture=case.posture,
            expected_s=expected_s,
        )

    def stands_at(self, place: Place) -> bool:
        here = self.arm.read_pose()
        return math.dist(_point(here), _point(place.pose)) <= place.within_mm

    def hand(self, does: Callable[[Any], None] | None) -> None:
        """Have a hand beside the device do something, where there is one."""
        assert does is not None
        if self.rig is not None:
            does(self.rig)


def _point(pose: Pose) -> tuple[float, float, float]:
    return pose.x_mm, pose.y_mm, pose.z_mm


Scenario = Callable[[ArmBench], None]
Play = Callable[[Scenario], None]


@pytest.fixture(params=WAYS)
def way(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def arms_with(has: Callable[[ArmCase[Any]], object]) -> pytest.MarkDecorator:
    """Have a test made for the arms that have something, and for no other."""
    names = [name for name, case in ARMS.items() if has(case) is not None]
    assert names, "no arm has what this test is about"
    return pytest.mark.parametrize("arm_name", names)


every_arm = arms_with(lambda case: case.kind)


@pytest.fixture
def play(arm_name: str, way: str, tmp_path: Path) -> Play:
    case = ARMS[arm_name]
    play_on = player(case.kind, way, tmp_path)

    def play(scenario: Scenario) -> None:
        def on_bench(bench: Bench[Any, Arm]) -> None:
            scenario(ArmBench(bench.device, case, bench.rig))

        play_on(on_bench)

    return play


@every_arm
def test_an_opened_arm_says_who_it_is_and_is_ready(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        assert bench.case.identity in bench.arm.open()
        state = bench.arm.read_state()
        assert state.is_servo_on
        assert state.is_automatic
        assert not state.is_moving
        assert not state.is_emergency_stopped
        assert (state.alarm, state.alarm_text) == (0, "")
        assert state.override_percent == 100

    play(scenario)


@every_arm
def test_opening_twice_and_closing_twice_is_harmless(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        assert bench.arm.open() == bench.arm.open()
        bench.arm.close()
        bench.arm.close()

    play(scenario)


@every_arm
def test_a_closed_arm_can_be_opened_again_and_moves(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.arm.open()
        bench.arm.close()
        bench.go_above()
        assert bench.stands_at(bench.case.above)

    play(scenario)


@every_arm
def test_a_move_returns_when_the_arm_stands_at_its_target(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.go_above()
        bench.go_beside()
        assert bench.stands_at(bench.case.beside)
        assert not bench.arm.read_state().is_moving

    play(scenario)


@every_arm
def test_the_expected_time_changes_nothing_but_the_questions(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.go_above()
        places = (bench.case.beside, bench.case.above, bench.case.beside)
        for expected_s, place in zip((0.0, 0.1, 5.0), places, strict=True):
            bench.go_to(place, expected_s=expected_s)
            assert bench.stands_at(place)

    play(scenario)


@every_arm
def test_a_joint_move_ends_at_its_joints(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.arm.open()
        for place in (bench.case.above, bench.case.beside):
            bench.arm.move_joints(place.joints, expected_s=0.5)
            here = bench.arm.read_joints().values
            assert here == pytest.approx(place.joints.values, abs=max(place.within, 1e-2))

    play(scenario)


@every_arm
def test_a_slower_speed_is_taken(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.go_above()
        bench.arm.set_speed(20.0, 5.0)
        bench.go_beside(expected_s=1.0)
        assert bench.stands_at(bench.case.beside)

    play(scenario)


@every_arm
@pytest.mark.parametrize(("speed", "percent"), [(0.0, 10.0), (-5.0, 10.0), (100.0, 0.0), (1, 101)])
def test_an_impossible_speed_is_refused(play: Play, speed: float, percent: float) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.arm.open()
        with pytest.raises(DeviceError, match="speed"):
            bench.arm.set_speed(speed, percent)

    play(scenario)


@arms_with(lambda case: case.output)
def test_an_output_reads_as_it_was_switched(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.arm.open()
        output = bench.case.output
        assert output is not None
        assert not bench.arm.read_output(output)
        bench.arm.set_output(output, is_on=True)
        assert bench.arm.read_output(output)
        assert not bench.arm.read_output(output + 1)
        bench.arm.set_output(output, is_on=False)
        assert not bench.arm.read_output(output)

    play(scenario)


@arms_with(lambda case: case.out_of_reach)
def test_a_pose_out_of_reach_is_refused_and_the_arm_stays(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        case = bench.case
        assert case.out_of_reach is not None
        bench.go_above()
        with pytest.raises(DeviceError, match=case.refusal):
            bench.arm.move(
                case.out_of_reach, interpolation=case.interpolation, posture=case.posture
            )
        assert bench.stands_at(case.above)
        bench.arm.reset_alarm()
        assert bench.arm.read_state().alarm == 0
        bench.go_beside()

    play(scenario)


@arms_with(lambda case: case.beyond_limits)
def test_joints_beyond_a_limit_are_refused_and_the_arm_stays(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        case = bench.case
        assert case.beyond_limits is not None
        bench.arm.open()
        start = bench.arm.read_joints()
        with pytest.raises(DeviceError, match=case.refusal):
            bench.arm.move_joints(case.beyond_limits)
        assert bench.arm.read_joints() == start

    play(scenario)


@every_arm
def test_a_fresh_arm_stands_where_it_was_left(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.arm.open()
        allowed = max(bench.case.above.within, 1e-2)
        assert bench.arm.read_joints().values == pytest.approx(bench.case.start.values, abs=allowed)

    play(scenario)


@every_arm
def test_a_pose_that_is_no_number_is_refused_before_anything_is_sent(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.arm.open()
        z_mm = bench.case.above.pose.z_mm
        with pytest.raises(DeviceError, match="no position"):
            bench.arm.move(
                Pose(float("nan"), 0.0, z_mm), interpolation="joint", posture=bench.case.posture
            )

    play(scenario)


@arms_with(lambda case: case.press_stop)
def test_an_emergency_stop_holds_the_arm_until_it_is_released_reset_and_opened_again(
    play: Play,
) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.go_above()
        bench.hand(bench.case.press_stop)
        state = bench.arm.read_state()
        assert state.is_emergency_stopped
        assert not state.is_servo_on
        assert state.alarm
        assert "emergency stop" in state.alarm_text
        with pytest.raises(DeviceError, match="emergency stop"):
            bench.go_beside()
        with pytest.raises(DeviceError):
            bench.arm.reset_alarm()
        bench.hand(bench.case.release_stop)
        bench.arm.reset_alarm()
        assert bench.arm.read_state().alarm == 0
        assert not bench.arm.read_state().is_servo_on
        with pytest.raises(DeviceError, match="open the arm again"):
            bench.go_beside()
        bench.arm.open()
        bench.go_beside()
        assert bench.stands_at(bench.case.beside)

    play(scenario)


@every_arm
def test_stop_works_in_every_state(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.arm.stop()
        bench.go_above()
        bench.arm.stop()
        if bench.case.press_stop is not None:
            bench.hand(bench.case.press_stop)
            bench.arm.stop()

    play(scenario)


@arms_with(lambda case: case.teach)
def test_an_arm_in_teach_mode_says_how_to_open_it(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.hand(bench.case.teach)
        with pytest.raises(DeviceError, match="AUTO"):
            bench.arm.open()

    play(scenario)


@every_arm
def test_a_dead_arm_is_a_timeout_everywhere(play: Play) -> None:
    def scenario(bench: ArmBench) -> None:
        bench.go_above()
        bench.hand(bench.case.silence)
        verbs: list[Callable[[], object]] = [
            bench.arm.read_pose,
            bench.arm.read_joints,
            bench.arm.read_state,
            bench.arm.stop,
            bench.arm.reset_alarm,
            bench.go_beside,
            lambda: bench.arm.move_joints(JointPositions(bench.case.above.joints.values)),
            bench.arm.open,
            bench.arm.close,
        ]
        if bench.case.is_speed_sent:
            verbs.insert(0, lambda: bench.arm.set_speed(100.0, 10.0))
        output = bench.case.output
        if output is not None:
            verbs.insert(0, lambda: bench.arm.set_output(output, is_on=True))
            verbs.insert(0, lambda: bench.arm.read_output(output))
        for verb in verbs:
            with pytest.raises(DeviceTimeout, match="arm: .*cable"):
                verb()

    play(scenario)
