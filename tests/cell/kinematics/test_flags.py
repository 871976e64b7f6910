from __future__ import annotations

import pytest

from cell.geometry import JointPositions
from cell.kinematics.flags import axis_turns, posture_name, turn_number, turns_flag
from tests.cell.kinematics.arms import MASH


@pytest.mark.parametrize(
    ("joints", "posture"),
    [
        ((0.0, 20.0, 100.0, 0.0, 60.0, 0.0), 7),
        ((0.0, 20.0, 100.0, 180.0, -60.0, 180.0), 6),
        ((0.0, 90.0, -60.0, 0.0, 60.0, 0.0), 5),
        ((0.0, 90.0, -60.0, 0.0, -60.0, 0.0), 4),
        ((0.0, -90.0, 13.0, 0.0, 60.0, 0.0), 3),
        ((0.0, -90.0, -60.0, 0.0, -60.0, 0.0), 2),
        ((0.0, -90.0, 60.0, 0.0, 60.0, 0.0), 1),
        ((0.0, -90.0, 60.0, 0.0, -60.0, 0.0), 0),
        ((0.0, 60.0, 13.25, 0.0, 0.0, 0.0), 7),
        ((0.0, 60.0, 13.23, 0.0, 0.0, 0.0), 5),
    ],
)
def test_posture_is_read_off_the_joint_angles(joints: tuple[float, ...], posture: int) -> None:
    assert MASH.posture(JointPositions(joints)) == posture


@pytest.mark.parametrize(
    ("posture", "name"),
    [(7, "Right-Above-NonFlip"), (6, "Right-Above-Flip"), (0, "Left-Below-Flip")],
)
def test_postures_have_the_controllers_names(posture: int, name: str) -> None:
    assert posture_name(posture) == name


@pytest.mark.parametrize(
    ("angle_deg", "turn"),
    [(0, 0), (180, 0), (-180, 0), (180.01, 1), (540, 1), (540.01, 2), (-180.01, -1), (-541, -2)],
)
def test_turns_change_every_360_deg(angle_deg: float, turn: int) -> None:
    assert turn_number(angle_deg) == turn


@pytest.mark.parametrize(
    ("j6", "flag"), [(0.0, 0), (199.0, 0x00100000), (-199.0, 0x00F00000), (720.0, 0x00200000)]
)
def test_turn_flag_holds_j6_in_its_nibble_and_is_read_back(j6: float, flag: int) -> None:
    assert turns_flag((0.0, 0.0, 0.0, 0.0, 0.0, j6)) == flag
    assert axis_turns(flag, 6) == turn_number(j6)
    assert axis_turns(flag, 5) == 0


def test_turn_flag_holds_several_axes() -> None:
    assert turns_flag((0.0, 0.0, 0.0, 190.0, 0.0, -190.0)) == 0x00F01000
