"""Settings found on cells whose lamps and cameras are off, and mistakes by their names."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from calibration.applying import calibrated_profile
from calibration.camera_settings.checking import check_camera_settings
from calibration.camera_settings.procedure import camera_settings
from calibration.player import play
from calibration.record import CalibrationRecord
from calibration.requests import Answer, Ask
from calibration.verdict import Grade
from cell.drivers.iidc.tables import SLOTS
from cell.manipulation import Deployment
from cell.profile import Profile
from cell.stop import StopToken
from cell.twin.cameras import flea2
from cell.vision.picture_measures import patches
from tests.calibration.camera_settings.bench import (
    PROFILE,
    Answers,
    Bench,
    Pixels,
    codes,
    lit,
    recorded,
    turn_at_random,
)


@cache
def reference(name: str = "top") -> Pixels:
    """Return how it looked when it was right."""
    return Bench().look(name)


@cache
def table_record() -> CalibrationRecord:
    bench = Bench()
    return recorded(bench.run(camera_settings(bench.site()), method="table"))


def error(picture: Pixels, wanted: Pixels) -> float:
    """Return the mean difference of all bright patches."""
    a, b = patches(picture).means, patches(wanted).means
    return float(np.abs(a - b)[b.max(axis=2) > 30.0].mean())


@pytest.mark.parametrize("seed", range(6))
def test_a_camera_that_is_off_in_a_changed_light_gets_its_colours_back(seed: int) -> None:
    random = np.random.default_rng(seed)
    light = lit(random.uniform(0.5, 1.5), random.uniform(0.8, 1.25), random.uniform(0.8, 1.25))
    bench = Bench(truth=light, files={"right.png": reference()})
    turn_at_random(bench.camera(), random)
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    shot = bench.look()
    assert found.grade is Grade.OK, (seed, found.findings)
    assert bench.pictures <= 20, seed
    assert error(shot, reference()) < 3.0, seed
    stated = found.accuracy.held_out_rms
    assert stated is not None
    assert stated < 3.0


def test_the_kept_picture_is_the_reference_when_none_is_given() -> None:
    bench = Bench(truth=lit(0.6, 1.1, 0.9))
    found = bench.run(camera_settings(bench.site(table_record())))
    assert found.grade is Grade.OK, found.findings
    assert error(bench.look(), reference()) < 3.0


def test_blocks_that_lie_elsewhere_now_do_not_disturb_the_search() -> None:
    bench = Bench(truth=lit(1.4), files={"right.png": reference()})
    bench.cell.open()
    bench.cell.lay_out(
        [
            Deployment(slot=2, x_mm=450.0, y_mm=60.0),
            Deployment(slot=3, x_mm=520.0, y_mm=-150.0),
        ]
    )
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    assert found.grade is Grade.OK, found.findings


def test_settings_become_those_of_the_profile_and_the_shutter_lets_no_flicker_through() -> None:
    bench = Bench(truth=lit(0.8, flicker=0.3), files={"right.png": reference()})
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    record = recorded(found)
    settings = calibrated_profile(PROFILE, [record]).cameras["top"].settings
    assert settings.shutter_ms % 10.0 == pytest.approx(0.0, abs=1e-6)
    assert settings.gain_db == pytest.approx(bench.camera().settings().gain_db, abs=1e-4)
    assert settings.sharpness == PROFILE.cameras["top"].settings.sharpness
    assert "flicker" not in codes(found)


def test_a_camera_that_is_right_but_lets_flicker_through_gets_another_shutter() -> None:
    bench = Bench(truth=lit(flicker=0.2), files={"right.png": reference()})
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    assert bench.camera().settings().shutter_ms % 10.0 == pytest.approx(0.0, abs=1e-3)
    assert found.grade is Grade.OK, found.findings
    assert error(bench.look(), reference()) < 3.0


def test_a_start_that_is_clipped_all_over_goes_darker_until_something_is_seen() -> None:
    bench = Bench(truth=lit(1.5), files={"right.png": reference()})
    bench.camera().set_absolute("shutter", 470.0)
    bench.camera().set_absolute("gain", 20.0)
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    assert found.grade is Grade.OK, found.findings
    assert error(bench.look(), reference()) < 3.0


def test_flicker_is_told_where_the_shutter_lets_it_through() -> None:
    bench = Bench(truth=lit(flicker=0.3))
    found = bench.run(camera_settings(bench.site()), method="table")
    assert "flicker" in codes(found)
    assert found.grade is Grade.DEGRADED


def test_typed_values_are_set_and_ranges_are_told() -> None:
    bench = Bench()
    found = bench.run(
        camera_settings(bench.site()), method="by-hand", shutter=20.0, gain=-5.0,
        white_balance_red=600.0, white_balance_blue=800.0,
    )  # fmt: skip
    assert found.grade is Grade.OK
    assert bench.camera().settings().shutter_ms == pytest.approx(20.0)
    refused = bench.run(camera_settings(bench.site()), method="by-hand", gain=60.0)
    assert codes(refused) == {"out-of-range"}
    assert "24 dB" in refused.findings[0].hint
    assert bench.camera().settings().gain_db == pytest.approx(-5.0)


def test_a_grey_area_becomes_grey_of_the_level_asked_for() -> None:
    bench = Bench(truth=lit(0.7, 1.2, 0.85))
    area = (1240.0, 0.0, 1280.0, 80.0)
    found = bench.run(
        camera_settings(bench.site()), method="grey", grey_area=area, grey_level=180.0
    )
    paper = bench.look()[0:80, 1240:1280].reshape(-1, 3).mean(axis=0)
    assert found.grade is not Grade.BAD, found.findings
    assert np.abs(paper - 180.0).max() < 4.0


def test_settings_of_lights_off_are_kept_apart_and_used_when_lights_are_off() -> None:
    bench = Bench()
    found = bench.run(
        camera_settings(bench.site()), lights="off", method="by-hand", shutter=100.0, gain=3.0
    )
    assert found.subject == "top lights-off"
    calibrated = calibrated_profile(PROFILE, [recorded(found)])
    cell = Bench(profile=calibrated, truth=PROFILE)
    cell.look()
    assert cell.camera().settings().shutter_ms == pytest.approx(16.02, abs=0.01)
    cell.cell.switch_lights(is_on=False)
    cell.cell.grab("top")
    assert cell.camera().settings().shutter_ms == pytest.approx(100.0, abs=0.01)
    cell.camera().set_absolute("shutter", 50.0)
    cell.cell.grab("top")
    assert cell.camera().settings().shutter_ms == pytest.approx(50.0, abs=0.01)
    cell.cell.switch_lights(is_on=True)
    cell.cell.grab("top")
    assert cell.camera().settings().shutter_ms == pytest.approx(16.02, abs=0.01)


# Mistakes by their names


def test_an_automatic_mode_is_taken_back_and_named() -> None:
    bench = Bench(files={"right.png": reference()})
    bench.camera().leave_auto("shutter")
    bench.camera().leave_auto("white_balance_red")
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    named = next(f for f in found.findings if f.code == "auto-mode-on")
    assert "shutter" in named.text
    assert "white_balance_red" in named.text
    assert all(f.control == "manual" for f in bench.camera().features() if f.name == "shutter")
    assert error(bench.look(), reference()) < 3.0


def test_a_clipped_reference_is_named() -> None:
    bench = Bench()
    bench.look()
    bench.camera().set_absolute("shutter", 120.0)
    clipped = bench.look()
    found = Bench(files={"right.png": clipped})
    result = found.run(camera_settings(found.site()), reference="right.png")
    assert "clipped-reference" in codes(result)


def test_a_reference_of_another_camera_or_size_is_named() -> None:
    small = np.ascontiguousarray(reference()[::2, ::2])
    bench = Bench(files={"oblique.png": reference("oblique"), "small.png": small})
    other = bench.run(camera_settings(bench.site()), reference="oblique.png")
    assert "reference-other-scene" in codes(other), other.findings
    assert not other.values
    cut = bench.run(camera_settings(bench.site()), reference="small.png")
    assert codes(cut) == {"reference-size"}
    assert "640 x 480" in cut.findings[0].text


def test_an_arm_in_the_picture_is_named() -> None:
    bench = Bench(truth=lit(1.3), files={"right.png": reference()})
    bench.cell.open()
    bench.cell.move_to(500.0, -50.0, 250.0)
    stay = bench.cell.arm.rest
    bench.cell.arm.rest = lambda: None  # type: ignore[method-assign]
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    bench.cell.arm.rest = stay  # type: ignore[method-assign]
    assert "arm-in-picture" in codes(found), found.findings


def test_lights_that_are_off_are_named() -> None:
    bench = Bench(files={"right.png": reference()})
    bench.cell.open()
    bench.cell.world.burn_out_lamps()
    before = bench.camera().settings()
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    assert "lights-off" in codes(found), found.findings
    assert not found.values
    assert bench.camera().settings() == before


def test_a_cap_on_the_lens_is_named() -> None:
    bench = Bench(files={"right.png": reference()})
    bench.look()
    bench.camera().cover_lens()
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    assert "lens-cap" in codes(found), found.findings


def test_lamps_that_are_too_weak_are_told_with_what_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(flea2, "SHUTTER_FRAME_PERIODS", 0.15)
    bench = Bench(truth=lit(0.2), files={"right.png": reference()})
    registers = bench.camera().body.registers._registers
    gain = SLOTS["gain"].offset
    registers[gain] = replace(registers[gain], absolute=(-6.0, 0.0))
    found = bench.run(camera_settings(bench.site()), reference="right.png")
    weak = next((f for f in found.findings if f.code == "light-too-weak"), None)
    assert weak is not None, found.findings
    missing = float(weak.text.split()[-5])
    assert missing == pytest.approx(2.5, rel=0.1)


def test_nothing_to_compare_with_is_named() -> None:
    bench = Bench()
    refused = bench.run(camera_settings(bench.site()), method="reference")
    assert codes(refused) == {"no-reference"}
    assert "--set method=table" in refused.findings[0].hint


# Do they still hold?


@pytest.mark.parametrize(
    ("truth", "code", "grade"),
    [
        (lit(), None, Grade.OK),
        (lit(0.85), "light-changed", Grade.DEGRADED),
        (lit(0.6), "light-changed", Grade.BAD),
        (lit(1.0, 1.12), "colour-changed", Grade.DEGRADED),
    ],
)
def test_a_check_tells_what_has_become_of_the_light(
    truth: Profile, code: str | None, grade: Grade
) -> None:
    bench = Bench(truth=truth)
    found = bench.run(check_camera_settings(bench.site(), table_record()))
    assert found.grade is grade, found.findings
    assert codes(found) == (set() if code is None else {code})


def test_a_check_names_automatic_modes_changed_settings_blur_cap_and_dark() -> None:
    def checked(bench: Bench) -> set[str]:
        return codes(bench.run(check_camera_settings(bench.site(), table_record())))

    bench = Bench()
    bench.look()
    bench.camera().leave_auto("gain")
    assert "auto-mode-on" in checked(bench)
    bench.camera().set_absolute("gain", 5.0)
    assert "settings-changed" in checked(bench)
    bench.camera().configure(PROFILE.cameras["top"].settings)
    bench.camera().defocus(1.5)
    assert checked(bench) == {"out-of-focus"}
    bench.camera().cover_lens()
    assert checked(bench) == {"lens-cap"}
    bench.camera().mend()
    bench.camera().configure(PROFILE.cameras["top"].settings)
    bench.cell.world.burn_out_lamps()
    assert "lights-off" in checked(bench)


class Watching(Answers):
    """Takes every default and notes the one of the method."""

    def answer(self, ask: Ask) -> Answer:
        if ask.key == "method":
            self.asked.append(f"method {ask.default}")
        return super().answer(ask)


@pytest.mark.parametrize("is_kept", [False, True])
def test_the_table_is_the_default_until_a_reference_is_kept(is_kept: bool) -> None:
    bench, watching = Bench(), Watching({})
    site = bench.site(table_record()) if is_kept else bench.site()
    play(camera_settings(site), hands=bench, asker=watching, stop=StopToken())
    assert f"method {'reference' if is_kept else 'table'}" in watching.asked
