"""How exactly blocks are located in 200 cells that are not what their profile says.

Lens, place of the camera, light and screen are hidden. For each cell the lens is calibrated
from 12 views of a ChArUco board, corners found to 0.5 px; then the wizard's four-point
calibration is played, its centres and every later sight of a block with 0.5 px of noise, the
arm's scatter 0.3 mm. Points are projected through the truth; rendering every picture would
take ten minutes. Some cells go through the full chain, with rendered pictures, in the tests.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Result
from calibration.homography.noise import PairNoise
from calibration.homography.place_fit import fit_place
from calibration.homography.plane_fit import fit_plane
from calibration.lens.fit import LensPrior, fit_lens
from cell.geometry import LensModel
from cell.profile import Profile, load_profile
from tests.calibration.hidden_truth import (
    PLAYGROUND_CORNERS_MM,
    block_top_mm,
    hidden,
    playground_grid,
    true_view,
)
from tests.calibration.lens.boards import board_views

CELLS = 200
NOISE = PairNoise(pixel_px=0.5, placement_mm=0.3)
CORNER_NOISE_PX = 0.5

Points = NDArray[np.float64]


def run() -> list[Result]:
    profile = load_profile("mash")
    with_lens, without, map_only = [], [], []
    held = 0
    for seed in range(CELLS):
        lens_off, plain_off, pure, is_held = one_cell(profile, seed)
        with_lens.append(lens_off)
        without.append(plain_off)
        map_only.append(pure)
        held += is_held
    lensed, plain, pure = (np.concatenate(x) for x in (with_lens, without, map_only))
    return [
        Result(
            name=f"block centre, {CELLS} cells, four points and the lens, RMS", unit="mm",
            value=_rms(lensed), peer="four points alone", peer_value=_rms(plain),
            target=0.7,
        ),
        Result(
            name="the same, most anywhere on the playground", unit="mm",
            value=_most(lensed), peer="four points alone", peer_value=_most(plain), target=2.0,
        ),
        Result(
            name="of that the map's own error, RMS", unit="mm", value=_rms(pure),
            peer="with the noise of finding a block", peer_value=_rms(lensed),
        ),
        Result(
            name="stated 95 % regions that hold a random point's truth", unit="%",
            value=100.0 * held / CELLS, peer="stated", peer_value=95.0,
        ),
    ]  # fmt: skip


def one_cell(profile: Profile, seed: int) -> tuple[Points, Points, Points, bool]:
    """Return the errors (n, 2) with and without the lens, of the map alone, and if it held."""
    truth = hidden(profile, seed)
    view = true_view(truth)
    top = block_top_mm(profile)
    random = np.random.default_rng([seed, 0xB0A2])
    lens, covariance = calibrated_lens(view.lens, random)
    corners = np.array(PLAYGROUND_CORNERS_MM)
    lain = corners + random.normal(0.0, NOISE.placement_mm, corners.shape)
    pixels = view.to_picture(lain, top) + random.normal(0.0, NOISE.pixel_px, corners.shape)
    grid = playground_grid()
    exact = view.to_picture(grid, top)
    seen = exact + random.normal(0.0, NOISE.pixel_px, grid.shape)
    place = fit_place(pixels, corners, top, lens, NOISE, covariance)
    plane = fit_plane(pixels, corners, NOISE)
    point = random.uniform((300.0, -350.0), (700.0, 300.0), (1, 2))
    at = view.to_picture(point, top)
    miss = (place.to_robot(at) - point)[0]
    distance = float(miss @ np.linalg.solve(place.covariance_at(at)[0], miss))
    return (
        place.to_robot(seen) - grid,
        plane.to_robot(seen) - grid,
        place.to_robot(exact) - grid,
        distance <= place.region_factor(2),
    )


def calibrated_lens(truth: LensModel, random: np.random.Generator) -> tuple[LensModel, Points]:
    """Return a lens as its procedure fits it to seen boards, with its covariance (9, 9)."""
    board, views = board_views(truth, 12, random, noise_px=CORNER_NOISE_PX)
    fitted = fit_lens(board, views, 1280, 960, LensPrior())
    return fitted.lens, fitted.lens_covariance


def _rms(off: Points) -> float:
    return float(np.sqrt((off**2).sum(axis=1).mean()))


def _most(off: Points) -> float:
    return float(np.hypot(*off.T).max())
