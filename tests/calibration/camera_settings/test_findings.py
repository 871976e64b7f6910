"""What is said of settings that cannot be had, each finding fired by a cell that deserves it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from calibration.camera_settings.procedure import camera_settings
from calibration.requests import Answer, Capture, Picture, ReadFeatures, Request
from tests.calibration.camera_settings.bench import Bench, Pixels, codes, lit


def reference() -> Pixels:
    """The scene in the light that the profile was set for."""
    return Bench().look()


REFERENCE = reference()


def grades(bench: Bench, **given: str | float) -> dict[str, str]:
    found = bench.run(camera_settings(bench.site()), **given)
    assert not found.values or found.grade.value != "BAD"
    return {finding.code: finding.grade.value for finding in found.findings}


def test_a_reference_without_even_patches_is_named() -> None:
    noise = np.random.default_rng(1).integers(0, 200, (960, 1280, 3)).astype(np.uint8)
    assert grades(Bench(files={"noise.png": noise}), reference="noise.png") == {
        "poor-reference": "BAD"
    }
    right = grades(Bench(files={"right.png": REFERENCE}), reference="right.png")
    assert "poor-reference" not in right


@pytest.mark.parametrize(("level", "code"), [(2000.0, "light-too-strong"), (1.0, None)])
def test_light_that_no_setting_makes_dim_enough_is_named(level: float, code: str | None) -> None:
    # Light that is as strong as may be beside what a dim reference was taken in.
    dim = np.asarray(REFERENCE // (3 if code else 1), np.uint8)
    bench = Bench(truth=lit(level), files={"dim.png": dim})
    named = grades(bench, reference="dim.png")
    assert ("light-too-strong" in named) == (code is not None), named


@dataclass
class Restless(Bench):
    """A cell whose light changes from picture to picture."""

    def perform(self, request: Request) -> Answer:
        """Do what is asked; each picture is brighter or darker than it should be."""
        answer = super().perform(request)
        if isinstance(request, Capture):
            assert isinstance(answer, Picture)
            share = np.random.default_rng(self.pictures).uniform(0.7, 1.0, 3)
            return replace(answer, pixels=(answer.pixels * share).astype(np.uint8))
        return answer


def test_light_that_changes_while_it_is_measured_leads_nowhere_and_that_is_said() -> None:
    assert grades(Restless(files={"right.png": REFERENCE}), reference="right.png")[
        "not-reached"
    ] == "BAD"  # fmt: skip


@dataclass
class RawCamera(Bench):
    """A camera that tells raw values of shutter and gain alone, as over FireWire."""

    def perform(self, request: Request) -> Answer:
        """Do what is asked; features come without absolute values."""
        answer = super().perform(request)
        if not isinstance(request, ReadFeatures):
            return answer
        assert isinstance(answer, tuple)
        return tuple(
            replace(one, absolute=None, absolute_range=None, is_absolute=False)
            if not isinstance(one, float) and one.name in ("shutter", "gain")
            else one
            for one in answer
        )  # type: ignore[return-value]


def test_typed_values_of_a_camera_with_raw_registers_are_refused_by_name() -> None:
    bench = RawCamera()
    before = bench.camera().settings()
    assert grades(bench, method="by-hand", shutter=20.0, gain=0.0)["raw-only"] == "BAD"
    assert bench.camera().settings() == before


def test_raw_settings_of_lights_off_are_not_kept() -> None:
    bench = RawCamera(files={"right.png": REFERENCE})
    found = bench.run(camera_settings(bench.site()), lights="off", reference="right.png")
    assert found.values == {}
    assert "raw-only" in codes(found)
