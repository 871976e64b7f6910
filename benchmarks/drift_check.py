"""The check for drift on rendered pictures: bumps found, false alarms, frames that it takes.

Cells of hidden truth are calibrated by their screen first, as a technician would; the record
is all that a check knows. Then each camera is bumped, every bump another one: exactly 1 mm at
the playground, or 0.1 deg about any axis, which is what has to be found. Blocks cover up to
40 % of the screen, others in every check; half of the checks follow no bump.
"""

from __future__ import annotations

import os
from collections import Counter
from datetime import UTC, datetime

import numpy as np

from benchmarks.measure import Result, median_s
from calibration.applying import calibrated_profile
from calibration.catalogue import Site
from calibration.drift.check import Blind, DotReference, has_moved, motion_seen, references
from calibration.record import make_record
from calibration.screen.procedure import screen
from cell.profile import Profile, load_profile
from cell.store import StorePlan
from tests.calibration.drift.bumps import bump_of, litter, look, with_camera
from tests.calibration.hidden_truth import hidden
from tests.calibration.playing import played, twin_of

FRAMES = 2
"""Pictures of each camera that a check needs."""

CAMERAS = ("top", "oblique")
_RATE_HZ = 7.5
_TRUTHS = int(os.environ.get("ROBOCELL_DRIFT_TRUTHS", "10"))
_BUMPS = int(os.environ.get("ROBOCELL_DRIFT_BUMPS", "10"))
_CHECKS = int(os.environ.get("ROBOCELL_DRIFT_CHECKS", "5"))
_MOST_COVERED = 0.4


def run() -> list[Result]:
    """Return recall, false alarms and the time of a check, camera by camera."""
    profile = load_profile("mash")
    counted: Counter[str] = Counter()
    was: DotReference | None = None
    for seed in range(_TRUTHS):
        truth = hidden(profile, seed)
        for was in calibrated_references(profile, truth, seed):
            counted += _count(was, truth, seed)
    results = [result for name in CAMERAS for result in _results(name, counted)]
    results.append(
        Result(name="camera time of a check", value=FRAMES / _RATE_HZ, unit="s", target=1.0)
    )
    if was is not None:
        results.append(_time(was, truth))
    return results


def calibrated_references(profile: Profile, truth: Profile, seed: int) -> tuple[DotReference, ...]:
    """Return where cameras saw the dots when a cell was calibrated by its screen."""
    site = Site(profile=profile, plan=StorePlan(()), current=())
    with twin_of(profile, truth, seed=seed) as cell:
        found = played(screen(site), {"cameras": ", ".join(CAMERAS)}, cell)
    record = make_record(
        found, cell=profile.name, measured_at=datetime.now(UTC), versions={}, answers={}
    )
    seen, blind = references(calibrated_profile(profile, [record]), record)
    if blind or len(seen) != len(CAMERAS):
        raise RuntimeError(f"seed {seed}: the calibration failed: {found.findings}")
    return seen


def _count(was: DotReference, truth: Profile, seed: int) -> Counter[str]:
    """Return how many checks told what, of a camera with bumps and without."""
    counted: Counter[str] = Counter()
    name = was.camera
    for bump in range(2 * _BUMPS):
        random = np.random.default_rng([seed, bump, 0xD21F7])
        kind, cell = "still", truth
        if bump % 2:
            is_turn = bump % 4 == 1
            kind = "turned" if is_turn else "shifted"
            bumped = bump_of(truth.twin.cameras[name], random, is_turn=is_turn)
            cell = with_camera(truth, name, bumped)
        for check in range(_CHECKS):
            blocks = litter(random, float(random.uniform(0.0, _MOST_COVERED)), truth)
            lit, dark = look(name, cell, blocks, seed=10_000 * seed + 100 * bump + check)
            motion = motion_seen(was, lit, dark, truth)
            told = "blind" if isinstance(motion, Blind) else "quiet"
            if not isinstance(motion, Blind) and has_moved(motion):
                told = "alarm"
            counted[f"{name} {kind}"] += 1
            counted[f"{name} {kind} {told}"] += 1
    return counted


def _results(name: str, counted: Counter[str]) -> list[Result]:
    def share(kinds: tuple[str, ...], told: str) -> float:
        total = sum(counted[f"{name} {kind}"] for kind in kinds)
        return 100.0 * sum(counted[f"{name} {kind} {told}"] for kind in kinds) / max(total, 1)

    poses = f"{_TRUTHS * _BUMPS // 2} poses"
    return [
        Result(
            name=f"{name}: bumps of 1 mm found, {poses}", value=share(("shifted",), "alarm"),
            unit="%", target=99.0, target_is="at least",
        ),
        Result(
            name=f"{name}: bumps of 0.1 deg found, {poses}", value=share(("turned",), "alarm"),
            unit="%", target=99.0, target_is="at least",
        ),
        Result(
            name=f"{name}: false alarms", value=share(("still",), "alarm"), unit="%", target=1.0
        ),
        Result(
            name=f"{name}: could not tell", value=share(("still", "shifted", "turned"), "blind"),
            unit="%",
        ),
    ]  # fmt: skip


def _time(was: DotReference, truth: Profile) -> Result:
    blocks = litter(np.random.default_rng(1), 0.4, truth)
    lit, dark = look(was.camera, truth, blocks, seed=2)
    return Result(
        name="dots and motion from two pictures",
        value=1e3 * median_s(lambda: motion_seen(was, lit, dark, truth)),
        unit="ms",
    )
