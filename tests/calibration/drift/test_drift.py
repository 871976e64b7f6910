"""Bumps of cameras and screen are found by dots, with blocks on them or without."""

from __future__ import annotations

import numpy as np
import pytest

from calibration.drift.check import (
    Blind,
    DotReference,
    has_moved,
    judge,
    motion_seen,
    references,
)
from calibration.drift.motion import Motion
from calibration.verdict import Grade, worst
from cell.profile import PlaceProfile, Profile
from cell.profile.cameras import LensProfile
from tests.calibration.drift.bumps import (
    apparent_mm,
    bump_of,
    litter,
    look,
    moved_camera,
    reference,
    with_camera,
)
from tests.calibration.hidden_truth import view_of
from tests.cell.twin.cameras.stage import PROFILE


@pytest.fixture(scope="module")
def top() -> DotReference:
    return reference("top", PROFILE)


@pytest.fixture(scope="module")
def oblique() -> DotReference:
    return reference("oblique", PROFILE)


def seen_by(was: DotReference, cell: Profile, seed: int, covered: float = 0.4) -> Motion | Blind:
    blocks = litter(np.random.default_rng(seed), covered, PROFILE)
    lit, dark = look(was.camera, cell, blocks, seed=seed)
    return motion_seen(was, lit, dark, PROFILE)


def test_nothing_is_said_where_nothing_moved(top: DotReference) -> None:
    for seed in range(6):
        motion = seen_by(top, PROFILE, seed)
        assert isinstance(motion, Motion), seed
        assert not has_moved(motion), (seed, motion)
        assert judge([motion]) == (), seed


@pytest.mark.parametrize("is_turn", [False, True])
def test_a_bump_of_a_millimetre_or_a_tenth_of_a_degree_is_found(
    top: DotReference, is_turn: bool
) -> None:
    camera = PROFILE.twin.cameras["top"]
    bumped = bump_of(camera, np.random.default_rng(5), is_turn=is_turn)
    for seed in range(4):
        motion = seen_by(top, with_camera(PROFILE, "top", bumped), seed)
        assert isinstance(motion, Motion), seed
        assert has_moved(motion), (seed, motion)
        told = apparent_mm(view_of(camera), view_of(bumped))
        assert motion.rms_mm == pytest.approx(told, rel=0.1, abs=0.05), seed


def test_the_weakest_turn_about_the_view_is_found(top: DotReference) -> None:
    rolled = moved_camera(PROFILE.twin.cameras["top"], np.zeros(3), np.array([0, 0, 0.1]))
    motion = seen_by(top, with_camera(PROFILE, "top", rolled), 3)
    assert isinstance(motion, Motion)
    assert has_moved(motion)


def test_a_moved_screen_is_told_from_moved_cameras(
    top: DotReference, oblique: DotReference
) -> None:
    display = PROFILE.display.model_copy(
        update={"corner_x_mm": PROFILE.display.corner_x_mm + 1.2,
                "corner_y_mm": PROFILE.display.corner_y_mm - 0.6}
    )  # fmt: skip
    pushed = PROFILE.model_copy(update={"display": display})
    found = judge([seen_by(top, pushed, 1, 0.2), seen_by(oblique, pushed, 1, 0.2)])
    assert [f.code for f in found] == ["screen-moved"]
    assert "(+1.2" in found[0].text
    knocked = with_camera(
        PROFILE,
        "top",
        moved_camera(PROFILE.twin.cameras["top"], np.array([1.5, 0, 0]), np.zeros(3)),
    )
    found = judge([seen_by(top, knocked, 2, 0.2), seen_by(oblique, knocked, 2, 0.2)])
    assert [f.code for f in found] == ["camera-moved"]
    assert "camera top moved" in found[0].text
    alone = judge([seen_by(top, knocked, 2, 0.2)])
    assert [f.code for f in alone] == ["camera-or-screen-moved"]


def test_a_hidden_screen_cannot_tell_and_is_not_ok(top: DotReference) -> None:
    lit, dark = look("top", PROFILE, (), seed=1)
    few = lit.copy()
    few[:, 90:] = dark[:, 90:]
    blind = motion_seen(top, few, dark, PROFILE)
    assert isinstance(blind, Blind)
    unlit = motion_seen(top, dark, dark, PROFILE)
    assert isinstance(unlit, Blind)
    for one in (blind, unlit):
        findings = judge([one])
        assert [f.code for f in findings] == ["cannot-tell"]
        assert worst(findings) is Grade.BAD


def test_a_hard_knock_is_found_though_all_dots_are_far_from_their_places(
    top: DotReference,
) -> None:
    knocked = moved_camera(
        PROFILE.twin.cameras["top"], np.array([12.0, -8.0, 0]), np.array([0, 0.4, 0.5])
    )
    motion = seen_by(top, with_camera(PROFILE, "top", knocked), 4, 0.3)
    assert isinstance(motion, Motion)
    assert motion.rms_mm > 5.0
    assert worst(judge([motion])) is Grade.BAD


def test_a_camera_without_lens_and_place_is_named() -> None:
    found, blind = references(PROFILE, None)
    assert found == ()
    assert {one.camera for one in blind} == {"top", "oblique"}


def test_dots_never_seen_before_are_reckoned_from_lens_and_place() -> None:
    true = PROFILE.twin.cameras["top"]
    lens = LensProfile(
        focal_px=(true.focal_px, true.focal_px), centre_px=true.centre_px, k1=true.k1
    )
    place = PlaceProfile(position_mm=true.position_mm, rotation_deg=true.rotation_deg)
    camera = PROFILE.cameras["top"].model_copy(update={"lens": lens, "place": place})
    known = PROFILE.model_copy(update={"cameras": {**PROFILE.cameras, "top": camera}})
    (was,), _ = references(known, None)
    assert not was.is_measured
    motion = seen_by(was, PROFILE, 1)
    assert isinstance(motion, Motion)
    assert motion.rms_mm < 0.1
    assert not has_moved(motion)


def test_a_check_in_which_no_camera_can_tell_is_bad_for_nothing_was_learned(
    top: DotReference,
) -> None:
    blind = [Blind(camera=name, reason="only 3 of 40 dots are seen") for name in ("top", "oblique")]
    assert worst(judge(blind)) is Grade.BAD
    told = seen_by(top, PROFILE, 3)
    assert worst(judge([told, blind[1]])) is Grade.DEGRADED
