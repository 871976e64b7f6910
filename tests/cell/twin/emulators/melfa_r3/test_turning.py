from __future__ import annotations

import numpy as np
import pytest

from cell.geometry import Pose, Transform
from cell.twin.emulators.melfa_r3.turning import EvenTurn

PAIRS = [
    (Pose(0, 0, 0, 180.0, 0.0, 180.0), Pose(0, 0, 0, 180.0, 0.0, 90.0)),
    (Pose(0, 0, 0, 10.0, 20.0, 30.0), Pose(0, 0, 0, -40.0, 60.0, 170.0)),
    (Pose(0, 0, 0, 0.0, 90.0, 0.0), Pose(0, 0, 0, 0.0, 0.0, 0.0)),
    (Pose(0, 0, 0, 0.0, 0.0, 0.0), Pose(0, 0, 0, 0.0, 0.0, 179.9)),
]


def _rotation(
    angles: tuple[float, float, float],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return Transform.from_pose(Pose(0.0, 0.0, 0.0, *angles)).rotation


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_a_turn_begins_and_ends_at_its_orientations(first: Pose, second: Pose) -> None:
    turn = EvenTurn(first, second)
    for pose, share in ((first, 0.0), (second, 1.0)):
        expected = Transform.from_pose(pose).rotation
        np.testing.assert_allclose(_rotation(turn.at(share)), expected, atol=1e-9)


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_a_turn_is_even_about_one_axis(first: Pose, second: Pose) -> None:
    turn = EvenTurn(first, second)
    rotations = [_rotation(turn.at(i / 10)) for i in range(11)]
    steps = [a.T @ b for a, b in zip(rotations, rotations[1:], strict=False)]
    for step in steps:
        np.testing.assert_allclose(step, steps[0], atol=1e-9)
    cosine = (np.trace(steps[0]) - 1) / 2
    assert np.degrees(np.arccos(cosine)) * 10 == pytest.approx(turn.angle_deg, abs=1e-5)


def test_the_same_orientation_written_in_two_ways_is_no_turn() -> None:
    turn = EvenTurn(Pose(0, 0, 0, 180.0, 0.0, 180.0), Pose(0, 0, 0, -180.0, 0.0, -180.0))
    assert turn.angle_deg == pytest.approx(0.0, abs=1e-5)
    np.testing.assert_allclose(_rotation(turn.at(0.5)), _rotation((180.0, 0.0, 180.0)), atol=1e-9)
