from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from cell.drivers.ssc32.servo_map import LinearServoMap, MeasuredServoMap, servo_map
from cell.drivers.ssc32.settings import FingerSettings, Ssc32Settings
from cell.errors import ProfileError
from cell.profile.lynx import LynxProfile, ServoProfile
from tests.cell.drivers.ssc32.bench import PROFILE

POINTS = ((-90.0, 620.0), (-40.0, 1050.0), (0.0, 1490.0), (50.0, 2010.0), (90.0, 2390.0))
FALLING = tuple((-position, pulse) for position, pulse in reversed(POINTS))


@pytest.mark.parametrize("points", [POINTS, FALLING])
def test_a_measured_map_goes_through_its_points(points: tuple[tuple[float, float], ...]) -> None:
    measured = MeasuredServoMap(points)
    for position, pulse in points:
        assert measured.pulse_us(position) == pytest.approx(pulse)
        assert measured.position(pulse) == pytest.approx(position)


@pytest.mark.parametrize("points", [POINTS, FALLING])
@given(position=st.floats(-120.0, 120.0))
def test_there_and_back_is_where_it_started(
    points: tuple[tuple[float, float], ...], position: float
) -> None:
    measured = MeasuredServoMap(points)
    assert measured.position(measured.pulse_us(position)) == pytest.approx(position, abs=1e-6)
    line = LinearServoMap(centre_us=1527.0, us_per_unit=-9.5)
    assert line.position(line.pulse_us(position)) == pytest.approx(position, abs=1e-6)


@pytest.mark.parametrize(
    "points",
    [(), ((0.0, 1500.0),), ((0.0, 1.0), (0.0, 2.0)), ((0.0, 1.0), (1.0, 1.0)),
     ((0.0, 1.0), (1.0, 2.0), (2.0, 1.5)), ((1.0, 1.0), (0.0, 2.0))],
)  # fmt: skip
def test_points_that_are_no_monotone_map_are_refused(
    points: tuple[tuple[float, float], ...],
) -> None:
    with pytest.raises(ProfileError, match="map needs"):
        MeasuredServoMap(points)
    if points:
        with pytest.raises(ValidationError, match="map needs"):
            ServoProfile(channel=0, us_per_unit=10.0, map=points)


def test_a_profile_with_a_map_uses_it_instead_of_the_line() -> None:
    assert isinstance(servo_map(ServoProfile(channel=0, us_per_unit=10.0)), LinearServoMap)
    measured = servo_map(ServoProfile(channel=0, us_per_unit=10.0, map=POINTS))
    assert measured.pulse_us(50.0) == pytest.approx(2010.0)


def test_a_servo_whose_pulses_do_not_reach_a_limit_is_a_profile_error() -> None:
    servo = PROFILE.servos[2].model_copy(update={"centre_us": 1500.0, "us_per_unit": 11.1})
    servos = (*PROFILE.servos[:2], servo, *PROFILE.servos[3:])
    with pytest.raises(ProfileError, match=r"J3 on channel 2: .*pulse of 355 us.*500 to 2500"):
        Ssc32Settings.from_profile(PROFILE.model_copy(update={"servos": servos}))


def test_fingers_whose_pulses_do_not_reach_are_a_profile_error() -> None:
    servo = PROFILE.fingers.servo.model_copy(update={"us_per_unit": -40.0})
    fingers = PROFILE.fingers.model_copy(update={"servo": servo})
    with pytest.raises(ProfileError, match="the fingers on channel 4"):
        FingerSettings.from_profile(PROFILE.model_copy(update={"fingers": fingers}))


@pytest.mark.parametrize("field", ["open_mm", "grip_mm"])
def test_an_opening_of_the_profile_out_of_range_is_a_profile_error(field: str) -> None:
    fingers = PROFILE.fingers.model_copy(update={field: 31.0})
    with pytest.raises(ProfileError, match=f"arm.fingers.{field}.*-15 to 30 mm"):
        FingerSettings.from_profile(PROFILE.model_copy(update={"fingers": fingers}))


def test_a_line_too_slow_for_the_segments_is_a_profile_error() -> None:
    serial = PROFILE.serial.model_copy(update={"baud": 9600})
    with pytest.raises(ProfileError, match="segment_s.*too short at 9600 baud"):
        Ssc32Settings.from_profile(PROFILE.model_copy(update={"serial": serial}))


def test_two_servos_on_one_channel_are_refused() -> None:
    data = PROFILE.model_dump()
    data["fingers"]["servo"]["channel"] = 2
    with pytest.raises(ValidationError, match="share a channel"):
        LynxProfile.model_validate(data)
