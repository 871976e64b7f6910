"""The homography wizard on 200 twin cells that are not what their profile says, all rendered.

Unlike `calibrated_cells`, nothing is projected: the arm places the calibration object with the
twin's scatter, and the wizard finds it in rendered pictures. In each placement's pictures the
object's surroundings are shifted by 0.5 px (standard deviation) in each direction, so that it
is found that much beside its place. The lens comes from 12 views of a board, corners found to
0.5 px. `ROBOCELL_CELLS` plays fewer.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.calibrated_cells import calibrated_lens
from benchmarks.measure import Result
from calibration.applying import calibrated_profile
from calibration.hands import CellHands
from calibration.homography.noise import PairNoise
from calibration.homography.plane_fit import fit_plane
from calibration.homography.procedure import calibrate_homography
from calibration.player import play
from calibration.record import Measurement, make_record
from calibration.requests import Answer, Picture, PutBlock, Request
from calibration.verdict import Grade
from cell.geometry import CameraView, LensModel
from cell.profile import LensProfile, Profile, load_profile
from cell.stop import StopToken
from tests.calibration.hidden_truth import block_top_mm, hidden, playground_grid, true_view
from tests.calibration.moment import MOMENT
from tests.calibration.playing import Answers, site_of, twin_of

CELLS = int(os.environ.get("ROBOCELL_CELLS", "200"))
TREMBLE_PX = 0.5
AROUND_PX = 70
"""Half the window that is shifted: the object, its shadow and lit screen around them."""
POINTS = 4

Points = NDArray[np.float64]


class TremblingHands:
    """Hands in whose pictures the object is seen a little beside where it is."""

    def __init__(
        self, hands: CellHands, random: np.random.Generator, view: CameraView, top_mm: float
    ) -> None:
        self._hands, self._random, self._view = hands, random, view
        self._top_mm = top_mm
        self._shift_px, self._at_px = np.zeros(2), np.zeros(2)

    def perform(self, request: Request) -> Answer:
        """Do it; what is around the object is shifted in pictures."""
        if isinstance(request, PutBlock):
            self._shift_px = self._random.normal(0.0, TREMBLE_PX, 2)
            place = np.array([request.place.x_mm, request.place.y_mm])
            self._at_px = self._view.to_picture(place, self._top_mm)
        answer = self._hands.perform(request)
        if isinstance(answer, Picture):
            return replace(answer, pixels=self._shifted(answer.pixels))
        return answer

    def _shifted(self, pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        height, width = pixels.shape[:2]
        u, v = np.rint(self._at_px).astype(int)
        rows = slice(max(v - AROUND_PX, 0), min(v + AROUND_PX, height))
        columns = slice(max(u - AROUND_PX, 0), min(u + AROUND_PX, width))
        window = pixels[rows, columns]
        shift = np.column_stack([np.eye(2), self._shift_px])
        moved = pixels.copy()
        moved[rows, columns] = cv2.warpAffine(
            window, shift, window.shape[1::-1], borderMode=cv2.BORDER_REPLICATE
        )
        return moved


def run() -> list[Result]:
    """Calibrate all cells and compare the maps with the truth over the playground."""
    profile = load_profile("mash")
    lensed: list[Points] = []
    plain: list[Points] = []
    grades: list[Grade] = []
    for seed in range(CELLS):
        with_lens, without, measured = one_cell(profile, seed)
        lensed.append(with_lens)
        plain.append(without)
        grades.append(measured.grade)
        worst = float(np.hypot(*with_lens.T).max())
        if worst > 2.0 or measured.grade is Grade.BAD:
            findings = [finding.text for finding in measured.findings]
            print(f"cell {seed}: {worst:.2f} mm at most; {findings}", file=sys.stderr, flush=True)
    all_lensed, all_plain = np.concatenate(lensed), np.concatenate(plain)
    return [
        Result(
            name=f"block centre, {CELLS} rendered cells, four points and the lens, RMS",
            unit="mm", value=_rms(all_lensed), peer="four points alone",
            peer_value=_rms(all_plain), target=0.7,
        ),
        Result(
            name="the same, most anywhere on the playground", unit="mm",
            value=float(np.hypot(*all_lensed.T).max()), peer="four points alone",
            peer_value=float(np.hypot(*all_plain.T).max()), target=2.0,
        ),
        Result(
            name="of these judged BAD", unit="", value=float(grades.count(Grade.BAD)),
        ),
    ]  # fmt: skip


def one_cell(profile: Profile, seed: int) -> tuple[Points, Points, Measurement]:
    """Return the errors (n, 2) of block centres with and without the lens, and the record."""
    truth = hidden(profile, seed)
    view, top = true_view(truth), block_top_mm(profile)
    random = np.random.default_rng([seed, 0x7E3B])
    lens, _ = calibrated_lens(view.lens, random)
    known = _with_lens(profile, lens)
    answers = {"points": float(POINTS), "fresh": 0.0, "pixel_noise": TREMBLE_PX}
    with twin_of(known, truth, seed) as cell:
        hands = TremblingHands(CellHands(lambda: cell), random, view, top)
        measured = play(
            calibrate_homography(site_of(known)), hands=hands, asker=Answers(answers),
            stop=StopToken(),
        )  # fmt: skip
    record = make_record(measured, cell=profile.name, measured_at=MOMENT, versions={}, answers={})
    found = calibrated_profile(known, [record]).cameras["top"].view(top)
    if found is None:
        raise RuntimeError(f"cell {seed}: the wizard gave no view")
    used = [sample for sample in measured.samples if sample.is_used]
    pixels = np.array([sample.measured for sample in used])
    places = np.array([sample.given for sample in used])
    plane = fit_plane(pixels, places, PairNoise(pixel_px=0.5, placement_mm=0.3))
    grid = playground_grid()
    exact = view.to_picture(grid, top)
    seen = exact + random.normal(0.0, TREMBLE_PX, exact.shape)
    return found.to_robot(seen, top) - grid, plane.to_robot(seen) - grid, measured


def _with_lens(profile: Profile, lens: LensModel) -> Profile:
    kept = LensProfile(
        focal_px=(lens.focal_u_px, lens.focal_v_px),
        centre_px=(lens.centre_u_px, lens.centre_v_px),
        k1=lens.k1, k2=lens.k2, p1=lens.p1, p2=lens.p2, k3=lens.k3,
    )  # fmt: skip
    top = profile.cameras["top"].model_copy(update={"lens": kept})
    return profile.model_copy(update={"cameras": {**profile.cameras, "top": top}})


def _rms(off: Points) -> float:
    return float(np.sqrt((off**2).sum(axis=1).mean()))
