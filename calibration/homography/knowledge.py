"""What is known of a camera before its map is measured: lens, map before, who it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.applying import setters
from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.homography.finding import Expected
from calibration.homography.noise import PairNoise
from calibration.homography.place_fit import PlaceFit, fit_place
from calibration.homography.plane_fit import PlaneFit, fit_plane
from calibration.record import CalibrationRecord, Support
from cell.geometry import CameraView, LensModel, TableView
from cell.profile import Profile

Points = NDArray[np.float64]
Matrix = NDArray[np.float64]

TableFit = PlaneFit | PlaceFit


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraKnowledge:
    """A camera and what is known of it.

    Attributes:
        camera: Its name.
        guid: Its own identity in the profile.
        height_mm: Height of the block tops, where the pairs lie.
        before: The map that holds now; None if there is none, or it is of another camera.
        lens: Its lens; None if it was not measured.
        lens_covariance: Of the lens's nine parameters; None if it is not known.
        stands_on: The lens as the profile has it, and the record it comes from; empty without.
    """

    camera: str
    guid: str
    height_mm: float
    before: TableView | None
    lens: LensModel | None
    lens_covariance: Matrix | None
    stands_on: tuple[Support, ...]

    def without_lens(self) -> CameraKnowledge:
        """Return the same for a fit that uses no lens."""
        return CameraKnowledge(
            camera=self.camera,
            guid=self.guid,
            height_mm=self.height_mm,
            before=self.before,
            lens=None,
            lens_covariance=None,
            stands_on=(),
        )

    def fit(self, pixels: Points, points_mm: Points, noise: PairNoise) -> TableFit:
        """Fit the camera's place if its lens is known, else a homography.

        Raises:
            FitFailed: The pairs do not determine it.
        """
        if self.lens is None:
            return fit_plane(pixels, points_mm, noise)
        return fit_place(pixels, points_mm, self.height_mm, self.lens, noise, self.lens_covariance)

    def to_robot_before(self, pixels: Points) -> Points:
        """Return robot points (n, 2) of pixels by the map before.

        Raises:
            ValueError: There is none, or a pixel is over its horizon.
        """
        if self.before is None:
            raise ValueError("there is no map from before")
        return self.before.to_robot(pixels, self.height_mm)


def playground_profile(site: Site) -> Profile:
    """Return the profile of a cell with a playground.

    Raises:
        CalibrationError: The cell has none.
    """
    if not isinstance(site.profile, Profile):
        raise CalibrationError(
            f"the cell {site.profile.name} has no playground; this calibration is for cells that "
            "have one"
        )
    return site.profile


def fixed_cameras(profile: Profile) -> tuple[str, ...]:
    """Return the cameras whose pictures can be mapped to the table: not those on the arm.

    Those that have a map come first, then `top`.
    """
    fixed = [name for name, camera in profile.cameras.items() if camera.stands_still]
    ranked = sorted(fixed, key=lambda n: (profile.cameras[n].view(0.0) is None, n != "top"))
    return tuple(ranked)


def knowledge_of(site: Site, camera: str) -> CameraKnowledge:
    """Return what is known of a camera.

    Raises:
        CalibrationError: The cell has no playground, or no such camera.
    """
    profile = playground_profile(site)
    if camera not in profile.cameras:
        raise CalibrationError(
            f"the profile has no camera {camera}; it has {', '.join(profile.cameras)}"
        )
    known = profile.cameras[camera]
    height_mm = profile.block_top_mm
    is_another = bool(known.plane_map_guid) and known.plane_map_guid != known.guid
    path = f"cameras.{camera}.lens"
    record = setters(site.current).get(path)
    covariance = None if record is None else _lens_covariance(record, camera)
    return CameraKnowledge(
        camera=camera,
        guid=known.guid,
        height_mm=height_mm,
        before=None if is_another else known.view(height_mm),
        lens=None if known.lens is None else known.lens.model(),
        lens_covariance=covariance,
        stands_on=()
        if known.lens is None
        else (
            Support(
                path=path,
                value=known.lens.model_dump(mode="json"),
                record="" if record is None else record.identity,
            ),
        ),
    )


def _lens_covariance(record: CalibrationRecord, camera: str) -> Matrix | None:
    """Return what a record tells of its lens's covariance: of one camera, or by camera."""
    told = record.details.get("lens_covariance")
    rows = told.get(camera) if isinstance(told, dict) else told
    return np.array(rows, np.float64) if isinstance(rows, list) else None


def expected_of(
    view: TableView | None, point_mm: tuple[float, float] | None, height_mm: float, radius_mm: float
) -> Expected:
    """Return how the object's face should look at a point, as far as a view tells."""
    if view is None or point_mm is None:
        return Expected()
    at = np.array([point_mm])
    centre = view.to_picture(at, height_mm)[0]
    columns = []
    for step in (np.array([1.0, 0.0]), np.array([0.0, 1.0])):
        up, down = view.to_picture(at + step, height_mm), view.to_picture(at - step, height_mm)
        columns.append((up - down)[0] / 2.0)
    slope = np.stack(columns, axis=1)
    below = (639.5, 479.5)
    if isinstance(view, CameraView):
        eye = view.robot_from_camera.translation_mm[:2]
        u, v = view.to_picture(eye[None, :], height_mm)[0]
        below = (float(u), float(v))
    return Expected(
        centre_px=(float(centre[0]), float(centre[1])),
        radius_px=radius_mm * float(np.sqrt(abs(np.linalg.det(slope)))),
        below_px=below,
        stretch=(
            (float(slope[0, 0]), float(slope[0, 1])),
            (float(slope[1, 0]), float(slope[1, 1])),
        ),
    )


def view_of(fit: TableFit, height_mm: float) -> TableView | None:
    """Return a fit as a view, None for a homography, which does not know the lens."""
    return fit.view if isinstance(fit, PlaceFit) else None
