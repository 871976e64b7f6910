from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from calibration.errors import AnswerRefused, FitFailed
from calibration.player import play
from calibration.record import Measurement
from calibration.requests import Answer, ReadTool, Request, ToolReading, Value
from calibration.world.fit import fit_lattice, mapped
from calibration.world.procedure import calibrate_world, judged
from cell.geometry import JointPositions, LatticeMap, Pose
from cell.profile import load_profile
from cell.stop import StopToken
from tests.calibration.playing import Answers, codes, site_of

Points = NDArray[np.float64]

CORNERS = np.array([[0.0, 0.0], [11.0, 0.0], [11.0, 11.0], [0.0, 11.0]])


class Touching:
    """Hands whose tool stands where a person brought it, one place after another."""

    def __init__(self, places: Points) -> None:
        self._places = list(places.tolist())

    def perform(self, request: Request) -> Answer:
        assert isinstance(request, ReadTool)
        x, y = self._places.pop(0)
        return ToolReading(pose=Pose(x, y, 98.0), joints=JointPositions((0.0,) * 6))


def touched(
    points: np.ndarray[tuple[int, ...], np.dtype[np.float64]], **answers: Value
) -> Measurement:
    return play(
        calibrate_world(site_of(load_profile("mash"))),
        hands=Touching(points),
        asker=Answers(answers),
        stop=StopToken(),
    )


def typed(**answers: Value) -> Measurement:
    return play(
        calibrate_world(site_of(load_profile("mash"))),
        hands=Touching(np.zeros((0, 2))),
        asker=Answers({"way": "typed", **answers}),
        stop=StopToken(),
    )


def lattice(**changes: float) -> LatticeMap:
    values = {"step_mm": 20.0, "angle_deg": 90.0, "origin_x_mm": 710.0, "origin_y_mm": -265.0}
    values.update(changes)
    return LatticeMap(**values)


def test_the_default_lattice_typed_is_good() -> None:
    found = typed()
    assert codes(found) == []
    assert found.values == {
        "lattice.step_mm": 20.0, "lattice.angle_deg": 90.0, "lattice.origin_mm": [710.0, -265.0],
    }  # fmt: skip


def test_the_origin_of_the_text_is_refused_as_out_of_reach_with_its_distance() -> None:
    found = typed(origin=(711.0, -600.0))
    assert found.grade.value == "BAD"
    assert found.values == {}
    finding = next(f for f in found.findings if f.code == "out-of-reach")
    assert "lattice (0, 0)" in finding.text
    assert "930 mm from the arm's base" in finding.text
    assert "out-of-view" in codes(found)


def test_touched_corners_give_the_lattice_they_lie_on() -> None:
    truth = lattice(angle_deg=89.4, origin_x_mm=706.0, origin_y_mm=-263.0)
    noise = np.random.default_rng(2).normal(0.0, 0.1, (4, 2))
    found = touched(mapped(truth, CORNERS) + noise)
    assert codes(found) == []
    assert found.values["lattice.angle_deg"] == pytest.approx(89.4, abs=0.1)
    assert found.values["lattice.step_mm"] == pytest.approx(20.0)
    assert found.accuracy.held_out_rms is not None
    assert found.accuracy.held_out_rms < 0.5


@pytest.mark.parametrize("step_mm", [None, 20.0])
def test_stated_regions_hold_the_truth_in_95_of_100_lattices(step_mm: float | None) -> None:
    random = np.random.default_rng(31)
    held = {"known": 0, "estimated": 0}
    for _ in range(1000):
        truth = lattice(
            angle_deg=random.uniform(60.0, 120.0), origin_x_mm=random.uniform(600.0, 720.0),
            origin_y_mm=random.uniform(-300.0, -200.0),
        )  # fmt: skip
        cells = np.vstack([CORNERS, random.integers(0, 12, (2, 2))])
        points = mapped(truth, cells) + random.normal(0.0, 0.4, (6, 2))
        free = slice(0, 4) if step_mm is None else slice(1, 4)
        for name, noise in (("known", 0.4), ("estimated", None)):
            fit = fit_lattice(cells, points, step_mm=step_mm, noise_mm=noise)
            own = fit.lattice
            miss = np.array(
                [own.step_mm - truth.step_mm, own.angle_deg - truth.angle_deg,
                 own.origin_x_mm - truth.origin_x_mm, own.origin_y_mm - truth.origin_y_mm]
            )[free]  # fmt: skip
            squared = float(miss @ np.linalg.solve(fit.covariance[free, free], miss))
            held[name] += squared <= fit.region_factor(len(miss))
    assert 930 <= held["known"] <= 970, held
    assert 930 <= held["estimated"] <= 970, held


def test_slopes_agree_with_differences() -> None:
    base = lattice(angle_deg=77.0)
    fit = fit_lattice(CORNERS, mapped(base, CORNERS), noise_mm=1.0)
    ahead = mapped(lattice(angle_deg=77.0 + 1e-4), CORNERS) - mapped(base, CORNERS)
    angle = fit.covariance[1, 1]
    # The angle's deviation is the noise over the root of the summed squared lever arms.
    middle = mapped(base, CORNERS).mean(axis=0)
    arms = ((mapped(base, CORNERS) - middle) ** 2).sum()
    assert math.sqrt(angle) == pytest.approx(math.degrees(1.0 / math.sqrt(arms)), rel=1e-6)
    assert np.abs(ahead).max() > 0


def test_one_lattice_point_touched_wrong_is_named() -> None:
    points = mapped(lattice(), CORNERS)
    points[2] += (20.0, 0.0)
    found = touched(points)
    assert codes(found)[0] == "misplaced-pair"
    assert found.findings[0].samples == ("point 3",)
    assert found.values == {}


@pytest.mark.parametrize(
    ("order", "code"), [((1, 0, 2, 3), "swapped-pairs"), ((0, 3, 2, 1), "mirrored-order")]
)
def test_lattice_points_in_a_wrong_order_are_named(order: tuple[int, ...], code: str) -> None:
    found = touched(mapped(lattice(), CORNERS)[list(order)])
    assert codes(found)[0] == code


def test_points_in_centimetres_are_named() -> None:
    found = touched(mapped(lattice(), CORNERS) / 10.0, fixed_step=False)
    assert "cm-for-mm" in codes(found)


def test_a_single_place_determines_nothing() -> None:
    with pytest.raises(FitFailed, match="far apart"):
        fit_lattice(np.zeros((3, 2)), np.zeros((3, 2)))


def test_a_lattice_over_the_screens_edge_is_told() -> None:
    profile = load_profile("mash")
    shifted = mapped(lattice(origin_x_mm=760.0), CORNERS)
    found = judged(profile, CORNERS, shifted, 20.0, size=(12, 12), camera="top", way="touched")
    assert "off-screen" in codes(found)


@pytest.mark.parametrize("step_mm", [1e-300, 0.99, 201.0])
def test_a_step_that_no_block_can_be_set_by_is_refused(step_mm: float) -> None:
    found = typed(step=step_mm)
    assert codes(found) == ["implausible-step"]
    assert found.grade.value == "BAD"
    assert found.values == {}


@pytest.mark.parametrize("size", [(-3.0, 4.0), (0.0, 0.0), (4.5, 4.0), (1e9, 4.0)])
def test_a_world_of_no_lattice_points_is_refused(size: tuple[float, float]) -> None:
    with pytest.raises(AnswerRefused, match="world: whole numbers from 1"):
        typed(world=size)
