from __future__ import annotations

import numpy as np
import pytest

from cell.errors import ProfileError
from cell.kinematics.servo_map import ArmCorrection, OutsideServoMap, SagModel, ServoMap, basis

SAG = SagModel(shoulder_deg=2.0, elbow_deg=1.2, wrist_deg=0.4, hand_share=0.3)


def random_map(generator: np.random.Generator, joint: str = "J1") -> ServoMap:
    x = np.cumsum(generator.uniform(5, 25, 8)) - 80
    y = np.cumsum(generator.uniform(2, 40, 8)) - 100
    return ServoMap(tuple(zip(x.tolist(), y.tolist(), strict=True)), joint)


def bent(joint: str) -> ServoMap:
    x = np.linspace(-80, 80, 9)
    y = x + 3 * np.sin(np.radians(2.2 * x)) + 1.5
    return ServoMap(tuple(zip(x.tolist(), y.tolist(), strict=True)), joint)


ARM = ArmCorrection(maps=(bent("J1"), bent("J2"), bent("J3"), bent("J4"), bent("J5")), sag=SAG)


@pytest.mark.parametrize("seed", range(20))
def test_any_map_is_monotone_and_there_and_back_is_exact(seed: int) -> None:
    generator = np.random.default_rng(seed)
    servo = random_map(generator)
    low, high = servo.commanded_range_deg
    commanded = np.linspace(low, high, 4001)
    reached = servo.reached_all(commanded)
    assert (np.diff(reached) >= -1e-12).all()
    assert np.abs(servo.reached_all(servo.commanded_all(reached)) - reached).max() < 1e-11


@pytest.mark.parametrize("seed", range(5))
def test_the_map_goes_through_its_knots(seed: int) -> None:
    servo = random_map(np.random.default_rng(seed))
    for commanded, reached in servo.knots_deg:
        assert servo.reached(commanded) == pytest.approx(reached, abs=1e-12)
        assert servo.commanded(reached) == pytest.approx(commanded, abs=1e-10)


def test_a_straight_servo_goes_where_it_is_told_to() -> None:
    assert ServoMap.straight(-90, 90).reached(12.345) == pytest.approx(12.345, abs=1e-12)


def test_a_quadratic_is_met_exactly_so_slopes_are_of_second_order() -> None:
    x = np.array([-60.0, -35.0, 0.0, 20.0, 60.0])
    servo = ServoMap(tuple((float(a), float(a + 0.002 * a * a)) for a in x))
    at = np.linspace(-60, 60, 501)
    assert np.abs(servo.reached_all(at) - (at + 0.002 * at * at)).max() < 1e-10


def test_the_linear_basis_is_the_map_where_no_slope_is_held_back() -> None:
    servo = bent("J1")
    knots = np.array(servo.knots_deg)
    at = np.linspace(-80, 80, 301)
    assert np.abs(basis(knots[:, 0], at) @ knots[:, 1] - servo.reached_all(at)).max() < 1e-10


@pytest.mark.parametrize(
    "knots", [((0.0, 0.0),), ((0.0, 0.0), (0.0, 1.0)), ((0.0, 5.0), (10.0, 5.0), (20.0, 6.0))]
)
def test_knots_that_do_not_grow_are_refused(knots: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(ProfileError, match="both growing"):
        ServoMap(knots, "J2")


def test_a_command_reaches_what_was_wanted_to_a_hundredth_of_a_degree_everywhere() -> None:
    generator = np.random.default_rng(4)
    worst = 0.0
    for _ in range(300):
        wanted = generator.uniform(-70, 70, 5)
        reached = ARM.reached(ARM.command_for(wanted.tolist()))
        worst = max(worst, float(np.abs(np.array(reached) - wanted).max()))
    assert worst < 1e-9


def test_an_arm_sags_most_when_it_is_stretched_and_not_when_it_hangs_upright() -> None:
    level = np.array([[0.0, 0.0, 0.0, 0.0, 0.0]])
    upright = np.array([[0.0, 0.0, -90.0, 0.0, 0.0]])
    assert SAG.turn_all(level)[0] == pytest.approx([0, 2.6, 1.56, 0.4, 0])
    assert np.abs(SAG.turn_all(upright)).max() < 1e-12


def test_reached_is_the_equilibrium_of_spring_and_weight() -> None:
    commanded = np.array([[10.0, 20.0, 15.0, -30.0, 5.0]])
    reached = ARM.reached_all(commanded)
    at_rest = [m.reached(float(c)) for m, c in zip(ARM.maps, commanded[0], strict=True)]
    assert reached[0] - SAG.turn_all(reached)[0] == pytest.approx(at_rest, abs=1e-11)
    assert ARM.reached(commanded[0].tolist()) == pytest.approx(tuple(reached[0]), abs=1e-11)


def test_outside_what_was_measured_joint_value_and_range_are_named() -> None:
    with pytest.raises(
        OutsideServoMap, match=r"J3: the commanded angle 95.00 deg.*-80.00 to 80"
    ) as e:
        ARM.reached((0, 0, 95, 0, 0))
    assert (e.value.joint, e.value.value, e.value.low, e.value.high) == ("J3", 95.0, -80.0, 80.0)
    with pytest.raises(OutsideServoMap, match="J5: the reached angle"):
        ARM.command_for((0, 0, 0, 0, -120))
