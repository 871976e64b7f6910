"""The whole procedure on a twin whose truth is hidden: patterns, blocks, drift check."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
import pytest

from calibration.applying import calibrated_profile
from calibration.catalogue import Site
from calibration.drift.procedure import check_screen, drift
from calibration.homography.knowledge import knowledge_of
from calibration.playground import playground_grid
from calibration.record import make_record
from calibration.requests import Capture, Request
from calibration.screen.procedure import screen
from calibration.verdict import Grade
from cell.geometry import CameraView
from cell.store import StorePlan
from tests.calibration.hidden_truth import block_top_mm, hidden, true_view
from tests.calibration.playing import codes, played, rms, twin_of
from tests.cell.twin.cameras.stage import PROFILE

SEED = 5


def site_of_object() -> Site:
    return Site(profile=PROFILE, plan=StorePlan(()), current=())


def test_a_cell_of_hidden_truth_is_calibrated_by_its_screen_and_checked_for_drift() -> None:
    truth = hidden(PROFILE, SEED)
    frames: list[str] = []

    def count(request: Request) -> None:
        if isinstance(request, Capture):
            frames.append(request.camera)

    with twin_of(PROFILE, truth, seed=SEED) as cell:
        found = played(
            screen(site_of_object()), {"cameras": "top", "blocks": 5.0}, cell, before=count
        )
        assert found.grade is Grade.OK, found.findings
        record = make_record(
            found, cell=PROFILE.name, measured_at=datetime.now(UTC), versions={}, answers={}
        )
        known = calibrated_profile(PROFILE, [record])
        view = known.cameras["top"].view(block_top_mm(PROFILE))
        assert isinstance(view, CameraView)
        grid, top_mm = playground_grid(), block_top_mm(PROFILE)
        off = view.to_robot(true_view(truth).to_picture(grid, top_mm), top_mm) - grid
        assert found.accuracy.predicted_rms is not None
        assert rms(off) < 2.5 * found.accuracy.predicted_rms
        assert found.accuracy.held_out_count == 5
        first = {(c.first, c.second) for c in found.correlations}
        assert ("top focal", "top z") in first
        frames.clear()
        site = Site(profile=known, plan=StorePlan(()), current=(record,))
        still = played(drift(site), {}, cell, before=count)
        covariance = knowledge_of(site, "top").lens_covariance
        assert covariance is not None
        deviations = np.sqrt(np.diag(covariance))
        focal = next(p for p in found.parameters if p.name == "top focal")
        assert deviations[:2] == pytest.approx([focal.deviation] * 2)
        assert (deviations[2:6] > 0.0).all()
        assert (deviations[6:] == 0.0).all()
        assert frames == ["top", "top"]  # two frames of 1/7.5 s
        assert "camera-or-screen-moved" not in codes(still)
        assert {f.code for f in still.findings} <= {"cannot-tell"}  # oblique has no calibration
        cell.cameras["top"].knock(1.2, 0.6)  # type: ignore[attr-defined]
        moved = played(check_screen(site, record), {}, cell)
        assert "camera-or-screen-moved" in codes(moved)
        assert np.isfinite(moved.accuracy.held_out_rms or np.nan)
