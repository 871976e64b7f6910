"""Looks of blocks learned in lamps of other colour, where the reference's tables fail."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from calibration.applying import calibrated_profile
from calibration.recognition.judge import sample_findings
from calibration.recognition.procedure import check_recognition, learn_recognition
from calibration.recognition.samples import matched
from calibration.record import Measurement
from calibration.verdict import Grade
from cell.profile import Profile
from cell.vision.blocks import SeenBlock
from cell.vision.learned import kind_ranges, recognition_model
from cell.vision.recognition import TwoPictures, recognise
from cell.vision.sight import TableSight
from cell.vision.tables import KINDS, kind_of
from tests.calibration.camera_settings.bench import PLAN, PROFILE, Bench, codes, lit, recorded

WARM = lit(0.75, 1.3, 0.6)


@cache
def learned_in_warm_light() -> Measurement:
    bench = Bench(truth=WARM)
    return bench.run(learn_recognition(bench.site()))


def test_blocks_are_told_in_warm_light_where_the_tables_fail() -> None:
    found = learned_in_warm_light()
    assert found.grade is Grade.OK, found.findings
    by_tables = found.details["right_by_reference_tables"]
    assert isinstance(by_tables, dict)
    right_by_tables = by_tables["colours"]
    assert isinstance(right_by_tables, int)
    held_out = found.details["held_out"]
    assert isinstance(held_out, dict)
    assert by_tables["of"] == 30
    assert right_by_tables <= 10
    assert held_out["right"] == held_out["of"] == 30


def test_what_was_learned_is_what_the_recogniser_is_given() -> None:
    profile = calibrated_profile(PROFILE, [recorded(learned_in_warm_light())])
    model = recognition_model(profile, "top").colours
    assert set(model.colours) == {slot.colour for slot in PLAN.slots}
    for sample in learned_in_warm_light().samples:
        red, green, blue = sample.measured[:3]
        colour = model.classify((red, green, blue)).colour
        assert colour is not None
        assert colour in sample.label
    assert recognition_model(profile, "oblique").colours != model
    kinds = kind_ranges(profile, "top")
    for sample in learned_in_warm_light().samples:
        known = kind_of(sample.measured[3], sample.measured[4], kinds)
        assert known is not None
        assert known.kind in sample.label
    assert kind_ranges(PROFILE, "top") == KINDS


def test_the_recogniser_sees_in_warm_light_what_the_tables_do_not() -> None:
    bench = Bench(truth=WARM)
    slots = (1, 5, 7, 11, 13)
    surface_mm = PROFILE.heights.surface_mm
    blocks = {b.block: b for b in bench.cell.world.whereabouts()}
    for index, number in enumerate(slots):
        placed = replace(
            blocks[f"slot {number}"],
            x_mm=360.0 + 60.0 * index,
            y_mm=-260.0 + 110.0 * index,
            z_mm=surface_mm,
            yaw_deg=17.0 * index,
        )
        bench.cell.world.blocks.put(placed)
    look = TwoPictures(white=bench.look(screen="white"), black=bench.look())
    profile = calibrated_profile(PROFILE, [recorded(learned_in_warm_light())])
    sight = TableSight.of_profile(profile, "top")
    wanted = sorted((PLAN.slot(n).kind, PLAN.slot(n).colour) for n in slots)

    def told(profile: Profile) -> list[tuple[str, str]]:
        found = recognise(look, sight, recognition_model(profile, "top"))
        return sorted((b.kind, b.colour) for b in found.blocks)

    assert told(profile) == wanted
    assert len(set(told(PROFILE)) & set(wanted)) <= 3


def test_what_was_learned_holds_while_the_light_changes_as_little_as_checks_allow() -> None:
    profile = calibrated_profile(PROFILE, [recorded(learned_in_warm_light())])
    model = recognition_model(profile, "top").colours
    for sample in learned_in_warm_light().samples:
        red, green, blue = sample.measured[:3]
        guess = model.classify((0.93 * 1.04 * red, 0.93 * green, 0.93 * 0.96 * blue))
        assert guess.colour is not None
        assert guess.colour in sample.label


def test_reference_tables_stand_beside_and_margins_are_sorted() -> None:
    details = learned_in_warm_light().details
    colours, margins = details["colours"], details["margins"]
    assert isinstance(colours, dict)
    assert isinstance(margins, list)
    red = colours["red"]
    assert isinstance(red, dict)
    assert red["reference"] == [[155, 220], [45, 75], [35, 60]]
    values = [m[2] for m in margins if isinstance(m, list) and isinstance(m[2], float)]
    assert values == sorted(values)
    assert len(values) == 10
    assert values[0] > 3.0


def test_one_round_with_single_blocks_names_what_is_too_few() -> None:
    bench = Bench()
    found = bench.run(learn_recognition(bench.site()), slots=(1.0, 2.0, 4.0, 5.0, 9.0), rounds=1.0)
    few = [f for f in found.findings if f.code == "too-few-samples"]
    assert {f.text.split()[0] for f in few} == {"red", "green", "blue"}
    assert found.grade is Grade.DEGRADED


def test_two_blocks_in_each_others_slots_are_named() -> None:
    bench = Bench(truth=WARM)
    blocks = {b.block: b for b in bench.cell.world.whereabouts()}
    one, other = blocks["slot 1"], blocks["slot 7"]
    bench.cell.world.blocks.put(replace(one, colour=other.colour))
    bench.cell.world.blocks.put(replace(other, colour=one.colour))
    found = bench.run(learn_recognition(bench.site()), rounds=1.0)
    named = {f.text.split()[4] for f in found.findings if f.code == "block-mixed-up"}
    assert named == {"1", "7"}, found.findings
    assert not found.values


def test_lights_that_are_off_are_named() -> None:
    bench = Bench()
    bench.cell.open()
    bench.cell.world.burn_out_lamps()
    found = bench.run(learn_recognition(bench.site()), slots=(1.0, 4.0, 7.0))
    assert "lights-off" in codes(found), found.findings
    assert not found.values


def test_a_block_that_is_not_where_it_should_be_is_named() -> None:
    seen = SeenBlock(
        kind="cube", colour="red", u_px=300.0, v_px=200.0, yaw_px_deg=0.0, area_px=3000,
        circularity=0.78, mean_rgb=(188.0, 60.0, 47.0),
    )  # fmt: skip
    here, there = PLAN.slot(1), PLAN.slot(4)
    samples, missing = matched([seen], [(here, (310.0, 195.0)), (there, (500.0, 300.0))], "look")
    assert [s.slot for s in samples] == [1]
    assert missing == [there]
    found = next(f for f in sample_findings(samples, missing) if f.code == "block-not-seen")
    assert "slots 4" in found.text


@pytest.mark.parametrize(("truth", "grade"), [(WARM, Grade.OK), (lit(1.3, 0.8, 1.5), Grade.BAD)])
def test_a_check_tells_whether_it_still_holds(truth: Profile, grade: Grade) -> None:
    profile = calibrated_profile(PROFILE, [recorded(learned_in_warm_light())])
    bench = Bench(profile=profile, truth=truth)
    found = bench.run(check_recognition(bench.site(), recorded(learned_in_warm_light())))
    assert found.grade is grade, found.findings
    assert ("looks-changed" in codes(found)) == (grade is Grade.BAD)
