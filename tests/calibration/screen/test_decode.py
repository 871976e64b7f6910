"""Places of the screen are read from pictures of phase and Gray code."""

from __future__ import annotations

import numpy as np
import pytest

from calibration.screen.decode import correspondences
from calibration.screen.patterns import AXES, PERIOD_PX, STEPS
from tests.calibration.hidden_truth import hidden, true_view
from tests.calibration.screen.cell_on_stage import PANEL, Watched, true_places_mm
from tests.cell.twin.cameras.stage import PROFILE, SURFACE_MM, block
from tests.cell.twin.cameras.test_patterns import PatternStage


@pytest.mark.parametrize("camera", ["top", "oblique"])
def test_places_are_read_to_a_fiftieth_of_a_pixel_around_blocks(camera: str) -> None:
    truth = hidden(PROFILE, 3)
    stage = PatternStage()
    stage.put(block("cube", "red", 500, 0), block("cylinder", "green", 400, -200))
    seen = Watched(stage, stage.camera(camera, profile=truth)).map()
    found = correspondences(seen)
    robot_mm = true_places_mm(truth, found.places)
    off_px = true_view(truth, camera).to_picture(robot_mm, SURFACE_MM) - found.pixels
    assert len(found) > 2500
    assert np.sqrt(np.mean(np.sum(off_px**2, axis=1))) < 0.02
    assert np.abs(off_px).max() < 0.1
    # Nothing is read where blocks stand.
    tops = true_view(truth, camera).to_picture(np.array([[500.0, 0.0], [400.0, -200.0]]), 71.5)
    for u, v in np.rint(tops).astype(int):
        assert not seen.is_sure[v - 5 : v + 6, u - 5 : u + 6].any()


def test_neighbouring_half_periods_differ_in_one_bit() -> None:
    for axis in AXES:
        bits = [PANEL.code(axis, bit)[..., 0] > 0 for bit in range(PANEL.bits(axis))]
        line = np.array([b[0] if axis == "columns" else b[:, 0] for b in bits])
        changes = (line[:, 1:] != line[:, :-1]).sum(axis=0)
        assert changes.max() == 1
        assert (np.flatnonzero(changes) + 1).tolist() == list(
            range(PERIOD_PX // 2, PANEL.size_px(axis), PERIOD_PX // 2)
        )


def test_the_shifts_of_a_sine_add_up_to_even_light() -> None:
    light = sum(
        (PANEL.sine("columns", step)[0, :, 0] / PANEL.bright) ** PANEL.gamma
        for step in range(STEPS)
    )
    assert np.ptp(light) < 0.05
