"""Calibrations by the screen without pictures: places projected through the truth, with noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.playground import PLAYGROUND_MM, playground_grid
from calibration.screen.decode import Correspondences
from calibration.screen.joint_fit import Observations, PlacedBlock, ScreenFit, ScreenPlace
from cell.geometry import CameraView
from cell.profile import Profile
from tests.calibration.hidden_truth import hidden, true_view

Points = NDArray[np.float64]

TOP_MM = 33.0
PLACING_MM = 0.3
_CELLS_PX = {"top": 16, "oblique": 8}
_MIDDLES = ((700.0, -25.0), (300.0, -25.0), (500.0, 300.0), (500.0, -350.0), (500.0, -25.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class SyntheticCell:
    """A cell that is not what its profile says, and what was measured in it.

    Attributes:
        views: How its cameras really are.
        glass_mm: Height of the glass.
        given: What was measured.
    """

    views: dict[str, CameraView]
    glass_mm: float
    given: Observations

    def errors_mm(self, found: ScreenFit, camera: str) -> Points:
        """Return how far block centres (n, 2) all over the playground come out."""
        grid, height_mm = playground_grid(), self.glass_mm + TOP_MM
        pixels = self.views[camera].to_picture(grid, height_mm)
        return np.asarray(found.view(camera).to_robot(pixels, height_mm) - grid)


def screen_place(profile: Profile) -> ScreenPlace:
    """Return where a profile has its screen."""
    display = profile.display
    return ScreenPlace(
        corner_mm=(display.corner_x_mm, display.corner_y_mm),
        angle_deg=display.angle_deg,
        height_mm=profile.heights.surface_mm,
        pixel_mm=display.pixel_mm,
    )


def places_of(view: CameraView, screen: ScreenPlace, cell_px: int) -> Correspondences:
    """Return which places of the screen the middles of a picture's cells really see."""
    middle = 0.5 * (cell_px - 1)
    u, v = np.meshgrid(np.arange(middle, 1280, cell_px), np.arange(middle, 960, cell_px))
    pixels = np.stack([u.ravel(), v.ravel()], axis=1)
    rays = np.column_stack([view.lens.to_directions(pixels), np.ones(len(pixels))])
    pixels = pixels[(rays @ view.robot_from_camera.rotation.T)[:, 2] < -0.05]
    robot_mm = view.to_robot(pixels, screen.height_mm)
    inverse = screen.robot_from_screen().inverse()
    solid = np.column_stack([robot_mm, np.full(len(robot_mm), screen.height_mm)])
    flat = (solid @ inverse.rotation.T + inverse.translation_mm)[:, :2] / screen.pixel_mm
    seen = ((flat >= 0.0) & (flat <= (1919.0, 1079.0))).all(axis=1)
    return Correspondences(pixels=pixels[seen], places=flat[seen])


def synthetic_cell(
    profile: Profile,
    seed: int,
    *,
    cameras: Sequence[str] = ("top", "oblique"),
    noise_px: float = 0.5,
    blocks: int = 6,
    finding_px: float = 0.5,
) -> SyntheticCell:
    """Return a cell of hidden truth; every place and every block is seen with noise.

    Blocks come to lie with a scatter of 0.3 mm along each axis; the top camera alone sees
    them.
    """
    truth = hidden(profile, seed)
    random = np.random.default_rng([seed, 0x5C12])
    screen = screen_place(truth)
    views = {name: true_view(truth, name) for name in cameras}
    seen = {}
    for name, view in views.items():
        exact = places_of(view, screen, _CELLS_PX[name])
        noise = random.normal(0.0, noise_px, exact.pixels.shape)
        seen[name] = Correspondences(pixels=exact.pixels + noise, places=exact.places)
    placed = []
    for index, place in enumerate((*PLAYGROUND_MM, *_MIDDLES)[:blocks]):
        lies = np.array(place) + random.normal(0.0, PLACING_MM, 2)
        u, v = views["top"].to_picture(lies, screen.height_mm + TOP_MM)
        off_u, off_v = random.normal(0.0, finding_px, 2)
        placed.append(
            PlacedBlock(
                label=f"block {index + 1}",
                robot_mm=place,
                height_mm=TOP_MM,
                deviation_mm=PLACING_MM,
                seen_px={"top": (float(u + off_u), float(v + off_v))},
                finding_px=finding_px,
            )
        )
    given = Observations(seen=seen, screen=screen_place(profile), blocks=placed)
    return SyntheticCell(views=views, glass_mm=screen.height_mm, given=given)
