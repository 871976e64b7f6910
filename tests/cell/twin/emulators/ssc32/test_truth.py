"""The twin's servos are not linear and its arm sags; only the twin knows by how much."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cell.drivers.ssc32.servo_map import LinearServoMap
from cell.geometry import JointPositions
from cell.twin.emulators.ssc32 import Sag, ServoErrors, TwinServo
from tests.cell.drivers.ssc32.bench import ABOVE, KINEMATICS, PROFILE, LynxRig

STRETCHED = JointPositions((0.0, 60.0, -60.0, 0.0, 0.0))
FOLDED = JointPositions((0.0, -60.0, 90.0, 0.0, 0.0))


def _stood(joints: JointPositions, *, scale: float, sag: Sag, seed: int = 1) -> LynxRig:
    rig = LynxRig(error_scale=scale, sag=sag, seed=seed)
    rig.arm.open()
    rig.arm.move_joints(joints)
    rig.clock.sleep(1.0)
    return rig


def test_with_all_knobs_off_the_arm_stands_where_it_is_told() -> None:
    rig = _stood(ABOVE, scale=0.0, sag=Sag.none())
    truth = rig.mechanics.joints(rig.clock.now_s())
    assert truth.values == pytest.approx(rig.arm.read_joints().values, abs=1e-9)
    assert truth.values == pytest.approx(ABOVE.values, abs=0.06)


def test_by_default_the_arm_is_off_by_millimetres_and_the_controller_does_not_know() -> None:
    rig = _stood(ABOVE, scale=1.0, sag=Sag())
    told, truth = rig.arm.read_pose(), rig.mechanics.pose(rig.clock.now_s())
    off_mm = math.dist((told.x_mm, told.y_mm, told.z_mm), (truth.x_mm, truth.y_mm, truth.z_mm))
    assert 2.0 < off_mm < 60.0
    assert rig.arm.read_joints().values == pytest.approx(ABOVE.values, abs=0.06)


def test_the_same_seed_has_the_same_servos_and_another_has_others() -> None:
    stands = [
        _stood(ABOVE, scale=1.0, sag=Sag(), seed=seed).mechanics.joints(1e3).values
        for seed in (4, 4, 5)
    ]
    assert stands[0] == stands[1]
    assert stands[0] != stands[2]


def test_the_arm_sags_further_stretched_than_folded_and_further_with_a_load() -> None:
    def drop_mm(joints: JointPositions, sag: Sag) -> float:
        rig = _stood(joints, scale=0.0, sag=sag)
        now_s = rig.clock.now_s()
        return rig.arm.read_pose().z_mm - rig.mechanics.pose(now_s).z_mm

    stretched, folded = drop_mm(STRETCHED, Sag()), drop_mm(FOLDED, Sag())
    assert 3.0 < stretched < 30.0
    assert abs(folded) < 0.5 * stretched
    assert drop_mm(STRETCHED, Sag(load_g=60.0)) > stretched + 1.0


def test_sag_does_not_depend_on_where_the_base_is_turned() -> None:
    one = _stood(STRETCHED, scale=0.0, sag=Sag()).mechanics.joints(1e3).values
    turned = JointPositions((45.0, *STRETCHED.values[1:]))
    other = _stood(turned, scale=0.0, sag=Sag()).mechanics.joints(1e3).values
    assert one[1:] == pytest.approx(other[1:])


@given(st.integers(0, 10_000))
def test_servos_as_drawn_stay_monotone_so_that_a_map_can_be_measured(seed: int) -> None:
    errors = ServoErrors.draw(random.Random(seed))
    line = LinearServoMap(centre_us=1500.0, us_per_unit=9.5)
    stands = [errors.bent(line.position(pulse), pulse) for pulse in range(500, 2501, 20)]
    assert all(b > a for a, b in zip(stands, stands[1:], strict=False)), f"seed {seed}"


@given(
    st.lists(
        st.tuples(st.floats(500.0, 2500.0), st.floats(0.0, 2.0), st.floats(0.0, 2.0)),
        min_size=1,
        max_size=12,
    ),
    st.integers(1, 40),
)
def test_a_shaft_is_where_it_is_however_often_it_is_looked_at(
    commands: list[tuple[float, float, float]], looks: int
) -> None:
    line = LinearServoMap(centre_us=1500.0, us_per_unit=10.0)
    seldom = TwinServo(line, ServoErrors(), full_speed_us_s=1500.0)
    often = TwinServo(line, ServoErrors(), full_speed_us_s=1500.0)
    now_s = 0.0
    for target_us, duration_s, pause_s in commands:
        for servo in (seldom, often):
            servo.command(target_us, duration_s, now_s)
        for look in range(1, looks):
            often.truth(now_s + pause_s * look / looks)
        now_s += pause_s
    assert often.truth(now_s) == pytest.approx(seldom.truth(now_s), abs=1e-6)
    end_s = now_s + 10.0
    assert seldom.truth(end_s) == pytest.approx(line.position(seldom.pulse_us(end_s)))


def test_a_shaft_never_turns_faster_than_its_servo_can() -> None:
    source = random.Random(7)
    line = LinearServoMap(centre_us=1500.0, us_per_unit=10.0)
    servo = TwinServo(line, ServoErrors(), full_speed_us_s=1500.0)
    now_s, before = 0.0, servo.truth(0.0)
    for step in range(3000):
        if step % 50 == 0:
            servo.command(source.uniform(500.0, 2500.0), source.uniform(0.0, 1.0), now_s)
        now_s += 0.01
        here = servo.truth(now_s)
        assert abs(here - before) <= 1.5 + 1e-6, "seed 7"
        before = here


def test_a_limp_arm_put_by_hand_elsewhere_jumps_at_its_first_pose() -> None:
    rig = LynxRig(error_scale=0.0)
    shoulder = rig.bank.servos[PROFILE.servos[1].channel]
    shoulder.put_by_hand(20.0, 0.0)
    rig.arm.open()
    assert shoulder.jumps_us == [pytest.approx(800.0)]
    assert KINEMATICS.posture(rig.arm.read_joints()) == 0
