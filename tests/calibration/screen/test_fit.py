"""Lens, places and screen come out as they are, and no better than stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calibration.playground import playground_grid
from calibration.screen.held_out import left_out
from calibration.screen.joint_fit import Touch, fit_screen, place_in_robot
from calibration.statistics import chi_square_quantile
from tests.calibration.hidden_truth import hidden
from tests.calibration.screen.synthetic import TOP_MM, screen_place, synthetic_cell
from tests.cell.twin.cameras.stage import PROFILE


def test_block_centres_come_out_within_four_tenths_of_a_millimetre() -> None:
    squares, held = [], []
    for seed in range(5):
        cell = synthetic_cell(PROFILE, seed, cameras=("top",))
        found = fit_screen(cell.given)
        off = cell.errors_mm(found, "top")
        covariance = found.covariance_at("top", playground_grid(), TOP_MM)
        squares.append(np.mean(np.sum(off**2, axis=1)))
        distance = np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariance), off)
        held.append(np.mean(distance < chi_square_quantile(0.95, 2)))
    assert np.sqrt(np.mean(squares)) < 0.4
    assert np.mean(held) > 0.7  # of five cells; the benchmark counts many


def test_two_cameras_share_the_screens_place() -> None:
    cell = synthetic_cell(PROFILE, 3)
    found = fit_screen(cell.given)
    for name in ("top", "oblique"):
        assert np.sqrt(np.mean(np.sum(cell.errors_mm(found, name) ** 2, axis=1))) < 0.8, name
        assert found.rms_px[name] == pytest.approx(0.5, abs=0.02), name


def test_touched_points_tie_the_screen_to_the_robot() -> None:
    cell = synthetic_cell(PROFILE, 4, cameras=("top",), noise_px=0.05, blocks=0)
    truth = screen_place(hidden(PROFILE, 4))
    random = np.random.default_rng(4)
    touches = []
    for place in ((240, 160), (1680, 160), (1680, 920), (240, 920)):
        x, y = place_in_robot(truth, np.array(place)) + random.normal(0, 0.1, 2)
        touches.append(
            Touch(label=f"cross {place}", place_px=place, robot_mm=(x, y), deviation_mm=0.1)
        )
    found = fit_screen(replace(cell.given, touches=touches))
    assert np.abs(np.array(found.place().corner_mm) - truth.corner_mm).max() < 0.4
    assert found.place().angle_deg == pytest.approx(truth.angle_deg, abs=0.03)


def test_a_point_left_out_lies_where_a_fit_without_it_says() -> None:
    cell = synthetic_cell(PROFILE, 5, cameras=("top",))
    found = fit_screen(cell.given)
    last = left_out(found)[-1]
    without = fit_screen(replace(cell.given, blocks=cell.given.blocks[:-1]))
    block = cell.given.blocks[-1]
    seen = without.view("top").to_robot(np.array(block.seen_px["top"]), cell.glass_mm + TOP_MM)
    assert last.held_out_mm == pytest.approx(seen - block.robot_mm, abs=0.02)
    assert last.distance_mm > np.hypot(*last.residual_mm)
