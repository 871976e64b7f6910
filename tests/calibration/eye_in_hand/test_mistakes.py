from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from calibration.eye_in_hand.measurement import measure_eye_in_hand
from calibration.eye_in_hand.samples import Samples
from calibration.verdict import Grade
from cell.geometry.eye_in_hand import EyeInHand
from tests.calibration.eye_in_hand.bench import NOMINAL, Bench

Change = Callable[[float, float], tuple[float, float]]


def with_joints(samples: Samples, change: Change) -> Samples:
    looks, touches = [], []
    for look in samples.looks:
        j1, j2 = change(look.j1_deg, look.j2_deg)
        looks.append(replace(look, j1_deg=j1, j2_deg=j2))
    for touch in samples.touches:
        j1, j2 = change(touch.j1_deg, touch.j2_deg)
        touches.append(replace(touch, j1_deg=j1, j2_deg=j2))
    return replace(samples, looks=tuple(looks), touches=tuple(touches))


def with_pixels(samples: Samples, change: Change) -> Samples:
    looks = []
    for look in samples.looks:
        u, v = change(look.u_px, look.v_px)
        looks.append(replace(look, u_px=u, v_px=v))
    return replace(samples, looks=tuple(looks))


def in_radians(j1: float, j2: float) -> tuple[float, float]:
    return float(np.radians(j1)), float(np.radians(j2))


MISTAKES: dict[str, Callable[[Samples], tuple[Samples, EyeInHand]]] = {
    "radians": lambda s: (with_joints(s, in_radians), NOMINAL),
    "pulses": lambda s: (with_joints(s, lambda a, b: (a * 872.2222, b * 444.4444)), NOMINAL),
    "swapped-joints": lambda s: (with_joints(s, lambda a, b: (b, a)), NOMINAL),
    "joint-2-absolute": lambda s: (with_joints(s, lambda a, b: (a, a + b)), NOMINAL),
    "mirrored-columns": lambda s: (with_pixels(s, lambda u, v: (511 - u, v)), NOMINAL),
    "mirrored-rows": lambda s: (with_pixels(s, lambda u, v: (u, 479 - v)), NOMINAL),
    "swapped-columns-rows": lambda s: (with_pixels(s, lambda u, v: (v, u)), NOMINAL),
    "picture-turned": lambda s: (with_pixels(s, lambda u, v: (511 - u, 479 - v)), NOMINAL),
    "scale-in-cm": lambda s: (s, replace(NOMINAL, scale_u_mm=0.1 / 3.56, scale_v_mm=0.1 / 3.48)),
    "scale-upside-down": lambda s: (s, replace(NOMINAL, scale_u_mm=3.56, scale_v_mm=3.48)),
    "picture-scale": lambda s: (s, replace(NOMINAL, scale_u_mm=1.1 / 3.56, scale_v_mm=1.1 / 3.48)),
    "swapped-links": lambda s: (s, replace(NOMINAL, link_1_mm=250.0, link_2_mm=400.0)),
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("code", MISTAKES)
def test_a_mistake_is_named(code: str, seed: int) -> None:
    samples, eye = MISTAKES[code](Bench(seed).samples())
    measurement = measure_eye_in_hand(samples, [], [], eye)
    assert [f.code for f in measurement.findings if f.grade is Grade.BAD] == [code]
    assert measurement.values == {}


@pytest.mark.parametrize("seed", range(5))
def test_a_wrong_reference_pixel_is_named_with_where_the_point_lay(seed: int) -> None:
    bench = Bench(seed)
    stages = bench.stages(3, reference=(3.0, 427.0))
    measurement = measure_eye_in_hand(bench.samples(), stages, [], NOMINAL)
    (finding,) = (f for f in measurement.findings if f.grade is Grade.BAD)
    assert finding.code == "wrong-reference-pixel"
    assert "427" in finding.text or "426" in finding.text or "428" in finding.text, finding.text


def test_good_samples_are_not_blamed() -> None:
    for seed in range(40):
        bench = Bench(seed)
        measurement = measure_eye_in_hand(bench.samples(14, 3), bench.stages(3), [], NOMINAL)
        assert measurement.grade is not Grade.BAD, (seed, measurement.findings)


def test_a_loose_camera_is_bad_without_a_name_for_it() -> None:
    bench = Bench(11)
    samples = bench.samples()

    def shake(u: float, v: float) -> tuple[float, float]:
        du, dv = bench.generator.normal(0, 6, 2)
        return u + du, v + dv

    shaken = with_pixels(samples, shake)
    measurement = measure_eye_in_hand(shaken, [], [], NOMINAL)
    assert "looks-disagree" in [f.code for f in measurement.findings]
    assert measurement.grade is Grade.BAD
