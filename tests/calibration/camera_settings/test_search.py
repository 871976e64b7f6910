"""The search on made-up cameras: raw registers, a bent response, features that are missing."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
import pytest
from numpy.typing import NDArray

from calibration.camera_settings.judge import knob_findings, search_findings
from calibration.camera_settings.knobs import Knobs, knobs_of
from calibration.camera_settings.search import Found, search
from calibration.camera_settings.target import target_of
from calibration.pictures import picture_of
from calibration.procedure import Steps
from calibration.requests import Answer, Capture, Request, SetFeature
from cell.devices.camera_features import UNITS, CameraFeature, FeatureName

T = TypeVar("T")
Pixels = NDArray[np.uint8]
SIDE_PX = 40
SCENE = np.random.default_rng(8).uniform(25.0, 170.0, (24, 32, 3))


def enlarged(levels: NDArray[np.float64]) -> Pixels:
    """Return a picture of 1280 x 960 of patches."""
    small = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    return small.repeat(SIDE_PX, axis=0).repeat(SIDE_PX, axis=1)


@dataclass
class MadeUpCamera:
    """A camera whose registers mean what its maker wanted.

    At `right` its picture is the scene.
    """

    raw: dict[FeatureName, int]
    right: dict[FeatureName, int]
    greatest: dict[FeatureName, int]
    gain_db_per_step: float = 0.05
    gamma: float = 1.0
    light: float = 1.0
    is_deaf: bool = False
    pictures: int = 0
    random: np.random.Generator = field(default_factory=lambda: np.random.default_rng(1))

    def features(self) -> tuple[CameraFeature, ...]:
        return tuple(
            CameraFeature(
                name=name,
                unit=UNITS.get(name, ""),
                raw_range=(0, self.greatest[name]),
                absolute_range=None,
                raw=value,
            )
            for name, value in self.raw.items()
        )

    def take(self) -> Pixels:
        self.pictures += 1
        now = self.right if self.is_deaf else self.raw
        factor = np.full(3, self.light * now["shutter"] / self.right["shutter"])
        if "gain" in now:
            steps = now["gain"] - self.right["gain"]
            factor *= 10.0 ** (self.gain_db_per_step * steps / 20.0)
        channels: tuple[tuple[int, FeatureName], ...] = (
            (0, "white_balance_red"),
            (2, "white_balance_blue"),
        )
        for channel, name in channels:
            if name in now:
                factor[channel] *= now[name] / self.right[name]
        level = SCENE * factor ** (1.0 / self.gamma)
        return enlarged(level + self.random.normal(0.0, 0.3, SCENE.shape))

    def answer(self, request: Request) -> Answer:
        if isinstance(request, Capture):
            return picture_of("made up", self.take())
        if isinstance(request, SetFeature):
            assert request.raw is not None
            self.raw[request.feature] = request.raw
            return next(f for f in self.features() if f.name == request.feature)
        return None


def drive(steps: Steps[T], camera: MadeUpCamera) -> T:
    answer: Answer = None
    try:
        request = next(steps)
        while True:
            answer = camera.answer(request)
            request = steps.send(answer)
    except StopIteration as end:
        found: T = end.value
        return found


def made_up(seed: int, **more: float | bool) -> MadeUpCamera:
    random = np.random.default_rng(seed)
    right: dict[FeatureName, int] = {
        "shutter": 400,
        "gain": 200,
        "white_balance_red": 500,
        "white_balance_blue": 600,
    }
    raw: dict[FeatureName, int] = {
        "shutter": int(random.uniform(60, 4000)),
        "gain": int(random.uniform(0, 500)),
        "white_balance_red": int(random.uniform(300, 900)),
        "white_balance_blue": int(random.uniform(300, 900)),
    }
    greatest: dict[FeatureName, int] = {
        "shutter": 4095,
        "gain": 1023,
        "white_balance_red": 1023,
        "white_balance_blue": 1023,
    }
    camera = MadeUpCamera(raw=raw, right=right, greatest=greatest)
    for name, value in more.items():
        setattr(camera, name, value)
    return camera


def searched(camera: MadeUpCamera) -> Found:
    right = MadeUpCamera(
        raw=dict(camera.right), right=camera.right, greatest=camera.greatest
    ).take()
    target = target_of(right, "the reference")
    return drive(search("made up", target, knobs_of(camera.features())), camera)


@pytest.mark.parametrize("gamma", [1.0, 0.6, 1.8])
@pytest.mark.parametrize("step", [0.03, 0.1])
def test_raw_registers_and_a_bent_response_are_learned_on_the_way(
    gamma: float, step: float
) -> None:
    for seed in range(3):
        camera = made_up(seed, gamma=gamma, gain_db_per_step=step)
        found = searched(camera)
        assert camera.pictures <= 20, f"seed {seed}"
        assert found.best.match.error < 3.0, f"seed {seed}: {found.best.match}"


def test_a_camera_without_white_balance_is_exposed_and_the_lack_is_named() -> None:
    camera = made_up(4)
    for name in ("white_balance_red", "white_balance_blue"):
        del camera.raw[name]
    found = searched(camera)
    assert found.best.match.error < 3.0
    named = [f for f in knob_findings(found.best.knobs) if f.code == "no-such-feature"]
    assert "white balance red" in named[0].text


def test_a_camera_that_does_not_follow_is_named() -> None:
    camera = made_up(5, is_deaf=True, light=0.6)
    found = searched(camera)
    right = target_of(camera.take(), "the reference")
    assert "settings-without-effect" in {f.code for f in search_findings(found, right)}


def test_the_white_balance_at_its_end_is_named_with_what_is_missing() -> None:
    camera = made_up(6)
    camera.greatest["white_balance_red"] = 350
    camera.raw["white_balance_red"] = 300
    found = searched(camera)
    right = target_of(enlarged(SCENE), "the reference")
    named = next(f for f in search_findings(found, right) if f.code == "white-balance-range")
    assert "red 1.4" in named.text


# Where light is taken from


def absolute_knobs(shutter_ms: float, gain_db: float) -> Knobs:
    def feature(name: FeatureName, now: float, span: tuple[float, float]) -> CameraFeature:
        return CameraFeature(
            name=name, unit=UNITS[name], raw_range=None, absolute_range=span, absolute=now
        )

    return knobs_of(
        (
            feature("shutter", shutter_ms, (0.01, 533.0)),
            feature("gain", gain_db, (-6.0, 24.0)),
            feature("frame_rate", 7.5, (1.0, 30.0)),
        )
    )


@pytest.mark.parametrize(
    ("factor", "shutter_ms", "gain_db"),
    [
        (0.1, 3.99, -6.0),  # too bright for one whole swing
        (1.0, 30.0, -3.52),
        (4.0, 130.0, -4.22),
        (20.0, 130.0, 9.76),
        (200.0, 252.4, 24.0),  # longer than a frame only when the gain is at its end
    ],
)
def test_light_comes_from_whole_swings_within_a_frame_before_gain(
    factor: float, shutter_ms: float, gain_db: float
) -> None:
    knobs = absolute_knobs(20.0, 0.0)
    plan = knobs.plan((np.log(factor),) * 3)
    reached = plan.values["shutter"] * 10 ** (plan.values["gain"] / 20.0)
    assert reached == pytest.approx(20.0 * factor, rel=1e-6)
    assert plan.values["shutter"] == pytest.approx(shutter_ms, rel=0.01)
    assert plan.values["gain"] == pytest.approx(gain_db, abs=0.02)
    assert plan.short == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_what_is_out_of_reach_is_told() -> None:
    knobs = absolute_knobs(20.0, 0.0)
    greatest = 533.0 * 10 ** (24.0 / 20.0) / 20.0
    plan = knobs.plan((np.log(2.0 * greatest),) * 3)
    assert plan.short == pytest.approx((np.log(2.0),) * 3)
    least = 0.01 * 10 ** (-6.0 / 20.0) / 20.0
    assert knobs.plan((np.log(least / 3.0),) * 3).short[1] == pytest.approx(-np.log(3.0))
