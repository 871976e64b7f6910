"""The check for drift on rendered pictures: bumps found, false alarms, frames that it takes.

A thousand checks of each camera, blocks over up to 40 % of the screen. Half of them after a
bump: 1 mm at the playground, or 0.1 deg about any axis. There are as many bumps as one in
twenty checks, as setting up a camera elsewhere takes the renderer its time; blocks and noise
are new in every check.
"""

from __future__ import annotations

import os

import numpy as np

from benchmarks.measure import Result, median_s
from calibration.drift.check import Blind, has_moved, motion_seen
from cell.profile import load_profile
from tests.calibration.drift.bumps import bump_of, litter, look, reference, with_camera

FRAMES = 2
"""Pictures of each camera that a check needs."""

_RATE_HZ = 7.5
_CHECKS = int(os.environ.get("ROBOCELL_DRIFT_CHECKS", "1000"))
_SHARE_OF_POSES = 20
_MOST_COVERED = 0.4


def run() -> list[Result]:
    """Return recall, false alarms and the time of a check, camera by camera."""
    results = []
    for name in ("top", "oblique"):
        found, alarms, blind = _count(name, _CHECKS)
        results += [
            Result(
                name=f"{name}: bumps found", value=found, unit="%", target=99.0,
                target_is="at least",
            ),
            Result(name=f"{name}: false alarms", value=alarms, unit="%", target=1.0),
            Result(name=f"{name}: could not tell", value=blind, unit="%"),
        ]  # fmt: skip
    profile = load_profile("mash")
    was = reference("top", profile)
    lit, dark = look("top", profile, litter(np.random.default_rng(1), 0.4, profile), seed=2)
    results += [
        Result(name="camera time of a check", value=FRAMES / _RATE_HZ, unit="s", target=1.0),
        Result(
            name="dots and motion from two pictures",
            value=1e3 * median_s(lambda: motion_seen(was, lit, dark, profile)),
            unit="ms",
        ),
    ]
    return results


def _count(name: str, checks: int) -> tuple[float, float, float]:
    """Return shares (%) of bumps found, of false alarms, and of checks that could not tell."""
    profile = load_profile("mash")
    was = reference(name, profile)
    found = alarms = blind = 0
    for group in range(checks // _SHARE_OF_POSES):
        random = np.random.default_rng([group, 0xD21F7])
        is_bumped = group % 2 == 1
        cell = profile
        if is_bumped:
            bumped = bump_of(profile.twin.cameras[name], random, is_turn=group % 4 == 1)
            cell = with_camera(profile, name, bumped)
        for check in range(_SHARE_OF_POSES):
            blocks = litter(random, float(random.uniform(0.0, _MOST_COVERED)), profile)
            lit, dark = look(name, cell, blocks, seed=1000 * group + check)
            motion = motion_seen(was, lit, dark, profile)
            if isinstance(motion, Blind):
                blind += 1
            elif has_moved(motion):
                found, alarms = found + is_bumped, alarms + (not is_bumped)
    half = 0.005 * checks
    return found / half, alarms / half, blind / (0.01 * checks)
