"""The homography wizard: from pictures of a camera above the table to the robot frame.

The arm puts the calibration object down at the playground's corners, then where the map is
known least, steps aside, and the camera finds the object's centre. Fresh places test the
map. Without an arm a person places the object, or points at marks in a picture.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from calibration.catalogue import Site
from calibration.errors import CalibrationError, FitFailed
from calibration.homography.finding import ObjectNotFound
from calibration.homography.judging import judge_pairs
from calibration.homography.knowledge import (
    CameraKnowledge,
    fixed_cameras,
    knowledge_of,
    playground_profile,
)
from calibration.homography.noise import PairNoise
from calibration.homography.planning import (
    IsReached,
    Place,
    corners,
    fresh_places,
    least_known,
    predicted_error,
)
from calibration.homography.result import failed, judged, pairs_of
from calibration.homography.sampling import Pair, Sampler, prepared
from calibration.homography.standing_still import judge_camera
from calibration.procedure import (
    Procedure,
    Steps,
    ask_choice,
    ask_numbers,
    ask_text,
    ask_whole,
    ask_within,
    ask_yes,
    capture,
    point_at,
    read_features,
    read_picture,
    return_block,
    tell,
)
from calibration.reach import TableReach
from calibration.verdict import Finding, Grade, worst
from cell.devices.camera_features import FeatureName
from cell.profile import Profile

_METERED: frozenset[FeatureName] = frozenset(
    {"exposure", "shutter", "gain", "white_balance_red", "white_balance_blue"}
)
_FOUND_PX = 0.2
_UNLIT_PX = 0.5
_CLICKED_PX = 1.0
_BY_HAND_MM = 1.0
_BY_ARM_MM = 0.3
"""A block let go by parallel fingers is pushed by their play and by what sticks to them: a few
tenths of a millimetre; `judge_noise` says so where the residuals tell more."""

_MOST_MM, _MOST_NOISE = 100.0, 100.0
_LEAST, _MOST = 4, 40


def calibrate_homography(site: Site) -> Procedure:
    """Calibrate where a camera's pictures lie in the robot frame."""
    profile = playground_profile(site)
    cameras = fixed_cameras(profile)
    if not cameras:
        raise CalibrationError("the profile has no camera that is fixed in the cell")
    camera = yield from ask_choice("camera", "Which camera?", cameras, default=cameras[0])
    known = knowledge_of(site, camera)
    if known.lens is not None:
        with_lens = yield from ask_yes("lens", "Use the lens that was measured?", default=True)
        known = known if with_lens else known.without_lens()
    has_object = profile.store.calibration is not None
    by_arm = profile.arm.enabled and profile.gripper.enabled and has_object
    ways = (*(("arm",) if by_arm else ()), "placed", "clicked")
    way = yield from ask_choice(
        "way",
        "Who puts the calibration object down: the arm, or a person (placed); or are marks "
        "pointed at in a picture (clicked)?",
        ways,
        default=ways[0],
    )
    quality_mm = yield from ask_within(
        "quality", "Which held-out error is good enough?", low=0.0, high=_MOST_MM, unit="mm",
        default=1.0,
    )  # fmt: skip
    if way == "clicked":
        return (yield from _clicked(known, quality_mm))
    return (yield from _found(profile, known, quality_mm, by_arm=way == "arm"))


def _found(
    profile: Profile, known: CameraKnowledge, quality_mm: float, *, by_arm: bool
) -> Procedure:
    """Calibrate with the object, which the camera finds."""
    findings = yield from automatic_features(known.camera)
    most = yield from ask_whole(
        "points", "At most how many points?", low=_LEAST, high=_MOST, default=4
    )
    fresh = yield from ask_whole(
        "fresh", "How many fresh points to test?", low=0, high=_MOST, default=2
    )
    noise = yield from _noise(
        _FOUND_PX if profile.display.enabled else _UNLIT_PX,
        _BY_ARM_MM if by_arm else _BY_HAND_MM,
    )
    own = profile.store.calibration
    sampler = Sampler(
        known=known,
        radius_mm=profile.blocks[own.kind].width_mm / 2.0 if own else 16.5,
        slot=own.number if own is not None and by_arm else None,
        with_screen=profile.display.enabled,
    )
    fitted: list[Pair] = []
    tests: list[Pair] = []
    try:
        sampler = yield from prepared(sampler)
        yield from _take_fitted(profile, sampler, fitted, most, quality_mm, noise, by_arm=by_arm)
        try:
            for index, place in enumerate(fresh_places(fresh, _why_not(profile, by_arm=by_arm))):
                yield from tell(f"test point {index + 1} of {fresh}", index, fresh)
                tests.append((yield from sampler.take(f"test {index + 1}", place)))
            fit = known.fit(pairs_of(fitted).pixels, pairs_of(fitted).points_mm, noise)
            fitted = [sampler.again(pair, fit) for pair in fitted]
            tests = [sampler.again(pair, fit) for pair in tests]
        except FitFailed:
            # The verdict tells which pairs are to blame.
            pass
    except ObjectNotFound as error:
        yield from _tidy(sampler)
        return failed(known, fitted, [*findings, *error.findings])
    yield from _tidy(sampler)
    taken = [*fitted, *tests]
    moved = judge_camera(taken)
    findings = (*findings, *moved, *_blurred(taken), *_of_pictures(taken))
    if worst(moved) is Grade.BAD:
        return failed(known, taken, findings)
    return judged(
        known, fitted, tests, noise, quality_mm=quality_mm, by_arm=by_arm, findings=findings
    )


def _take_fitted(
    profile: Profile,
    sampler: Sampler,
    fitted: list[Pair],
    most: int,
    quality_mm: float,
    noise: PairNoise,
    *,
    by_arm: bool,
) -> Steps[None]:
    """Take the corners, then more until the predicted error is small enough."""
    why_not = _why_not(profile, by_arm=by_arm)
    for index, corner in enumerate(corners(why_not)):
        yield from tell(f"corner {index + 1} of 4", index, most)
        place = corner
        if not by_arm:
            place = yield from _typed(index + 1, corner)
        fitted.append((yield from sampler.take(f"pair {index + 1}", place)))
    while len(fitted) < most:
        pairs = pairs_of(fitted)
        if judge_pairs(pairs):
            return
        fit = sampler.known.fit(pairs.pixels, pairs.points_mm, noise)
        if predicted_error(fit)[1] <= quality_mm:
            return
        place_next = least_known(fit, [pair.point_mm for pair in fitted], why_not)
        if place_next is None:
            return
        yield from tell(
            f"one more at ({place_next[0]:g}, {place_next[1]:g}) mm, where the map is known least",
            len(fitted),
            most,
        )
        fitted.append((yield from sampler.take(f"pair {len(fitted) + 1}", place_next)))


def _clicked(known: CameraKnowledge, quality_mm: float) -> Procedure:
    """Calibrate with marks in one picture that a person points at."""
    count = yield from ask_whole("points", "How many marks?", low=_LEAST, high=_MOST, default=4)
    noise = yield from _noise(_CLICKED_PX, _BY_HAND_MM)
    path = yield from ask_text(
        "file", "Picture from a file (empty: take one with the camera)", default=""
    )
    if path:
        picture = yield from read_picture(path)
    else:
        picture = yield from capture(known.camera, "marks at the height of the block tops")
    pairs: list[Pair] = []
    standard = corners(lambda x, y: "")
    for number in range(1, count + 1):
        corner = standard[number - 1] if number <= len(standard) else None
        place = yield from _typed(number, corner)
        guess = None
        if known.before is not None:
            u, v = _guess(known, place)
            guess = (u, v)
        pixel = yield from point_at(
            f"pixel {number}", f"Where is the mark at ({place[0]:g}, {place[1]:g}) mm?",
            picture, guess,
        )  # fmt: skip
        pairs.append(
            Pair(
                label=f"pair {number}", point_mm=place, pixel=pixel, seen=None,
                picture=picture.digest, levels=None,
            )
        )  # fmt: skip
    return judged(known, pairs, (), noise, quality_mm=quality_mm, by_arm=False)


def _guess(known: CameraKnowledge, place: Place) -> tuple[float, float]:
    if known.before is None:
        raise ValueError("there is no map from before")
    u, v = known.before.to_picture(np.array([place]), known.height_mm)[0]
    return float(u), float(v)


def _typed(number: int, default: Place | None) -> Steps[Place]:
    x, y = yield from ask_numbers(
        f"point {number}", f"Robot x, y of point {number}?", count=2, unit="mm", default=default
    )
    return x, y


def _noise(pixel_px: float, placement_mm: float) -> Steps[PairNoise]:
    pixel = yield from ask_within(
        "pixel_noise", "How exactly are points found (standard deviation)?", low=0.0,
        high=_MOST_NOISE, unit="px", default=pixel_px,
    )  # fmt: skip
    placement = yield from ask_within(
        "placement_noise", "How exactly is the object placed (standard deviation)?", low=0.0,
        high=_MOST_NOISE, unit="mm", default=placement_mm,
    )  # fmt: skip
    return PairNoise(pixel_px=pixel, placement_mm=placement)


def automatic_features(camera: str) -> Steps[tuple[Finding, ...]]:
    """Return which automatic modes of a camera are on, as findings."""
    features = yield from read_features(camera)
    on = [feature.name for feature in features if feature.control == "auto"]
    metered = [name for name in on if name in _METERED]
    if not metered:
        return ()
    return (
        Finding(
            code="auto-on",
            grade=Grade.DEGRADED,
            text=f"camera {camera} sets {', '.join(metered)} by itself: pictures taken for "
            "comparison are not exposed alike",
            hint="set them by hand, or run `cell calibrate camera-settings`",
        ),
    )


def _tidy(sampler: Sampler) -> Steps[None]:
    if sampler.slot is not None:
        yield from return_block(sampler.slot)


def _blurred(pairs: Sequence[Pair]) -> tuple[Finding, ...]:
    for pair in pairs:
        if pair.seen is not None and pair.seen.findings:
            return pair.seen.findings
    return ()


def _of_pictures(pairs: Sequence[Pair]) -> tuple[Finding, ...]:
    """Return what is wrong with the pictures, each thing once."""
    found = {finding.code: finding for pair in pairs for finding in pair.findings}
    return tuple(found.values())


def _why_not(profile: Profile, *, by_arm: bool) -> IsReached:
    return TableReach(profile).why_not_lay if by_arm else (lambda x, y: "")
