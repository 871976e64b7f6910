"""Where what a camera sees lies in the robot frame, for a chosen height above the base plane.

`CameraView` knows the lens and where the camera stands: it maps any height. `PlaneView`
is a bare homography that was measured at one height and holds there alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cell.geometry.lens import LensModel
from cell.geometry.plane import PlaneMap
from cell.geometry.transform import Transform

Points = NDArray[np.float64]

_HEIGHT_TOLERANCE_MM = 0.5


class TableView(Protocol):
    """A camera's picture (1280 x 960 pixels) mapped to horizontal planes of the robot frame."""

    def to_robot(self, pixels: Points, height_mm: float) -> Points:
        """Return robot x, y in mm (..., 2) of what pixels (..., 2) show at a height.

        Raises:
            ValueError: The view does not know that height, or a pixel sees over the horizon.
        """

    def to_picture(self, points_mm: Points, height_mm: float) -> Points:
        """Return pixels (..., 2) of robot x, y (..., 2) at a height.

        Raises:
            ValueError: The view does not know that height, or a point is behind the camera.
        """


@dataclass(frozen=True, slots=True)
class PlaneView:
    """A homography, good at the height it was measured at.

    Attributes:
        plane_map: Picture to robot.
        height_mm: Height of the plane above the robot's base plane.
    """

    plane_map: PlaneMap
    height_mm: float

    def to_robot(self, pixels: Points, height_mm: float) -> Points:
        """Return robot x, y of pixels at the measured height; see `TableView`."""
        self._check(height_mm)
        return _map(np.array(self.plane_map.rows), pixels)

    def to_picture(self, points_mm: Points, height_mm: float) -> Points:
        """Return pixels of robot x, y at the measured height; see `TableView`."""
        self._check(height_mm)
        return _map(np.linalg.inv(np.array(self.plane_map.rows)), points_mm)

    def _check(self, height_mm: float) -> None:
        if abs(height_mm - self.height_mm) > _HEIGHT_TOLERANCE_MM:
            raise ValueError(
                f"the plane map holds at {self.height_mm:g} mm, not at {height_mm:g} mm; "
                "a lens calibration tells how to go to another height"
            )


@dataclass(frozen=True, slots=True)
class CameraView:
    """A camera whose lens and place are known.

    Attributes:
        lens: Its lens.
        robot_from_camera: Where it stands; camera x to the picture's right, y down, z along
            the view.
    """

    lens: LensModel
    robot_from_camera: Transform

    def to_robot(self, pixels: Points, height_mm: float) -> Points:
        """Return robot x, y where the pixels' rays meet a height; see `TableView`."""
        directions = self.lens.to_directions(pixels)
        rays = np.concatenate([directions, np.ones((*directions.shape[:-1], 1))], axis=-1)
        rays = rays @ self.robot_from_camera.rotation.T
        eye = self.robot_from_camera.translation_mm
        share = np.divide(
            height_mm - eye[2], rays[..., 2], out=np.full(rays.shape[:-1], -1.0),
            where=rays[..., 2] != 0,
        )  # fmt: skip
        if (share <= 0).any():
            raise ValueError("a pixel looks over the horizon of the table")
        return np.asarray(eye[:2] + share[..., None] * rays[..., :2])

    def to_picture(self, points_mm: Points, height_mm: float) -> Points:
        """Return pixels of robot x, y at a height; see `TableView`."""
        points = np.asarray(points_mm, np.float64)
        height = np.full((*points.shape[:-1], 1), float(height_mm))
        return self.project(np.concatenate([points, height], axis=-1))

    def project(self, points_mm: Points) -> Points:
        """Return pixels (..., 2) of robot points (..., 3).

        Raises:
            ValueError: A point is behind the camera.
        """
        eye = self.robot_from_camera.translation_mm
        in_camera = (np.asarray(points_mm, np.float64) - eye) @ self.robot_from_camera.rotation
        if (in_camera[..., 2] <= 0).any():
            raise ValueError("a point is behind the camera")
        return self.lens.to_picture(in_camera[..., :2] / in_camera[..., 2:])

    def plane_map(self, height_mm: float) -> PlaneMap:
        """Return the homography from ideal (undistorted) pixels to a height.

        H⁻¹ ~ K [r1 r2 t], the columns of camera-from-robot on the plane z = height.
        """
        camera_from_robot = self.robot_from_camera.inverse()
        rotation, shift = camera_from_robot.rotation, camera_from_robot.translation_mm
        columns = [rotation[:, 0], rotation[:, 1], rotation[:, 2] * height_mm + shift]
        inverse = np.linalg.inv(self.lens.matrix @ np.stack(columns, axis=1))
        a, b, c = (tuple(float(v) for v in row) for row in inverse / inverse[2, 2])
        return PlaneMap(((a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2])))


def _map(matrix: Points, points: Points) -> Points:
    points = np.asarray(points, np.float64)
    mapped = points @ matrix[:, :2].T + matrix[:, 2]
    if (np.abs(mapped[..., 2]) < 1e-12).any():
        raise ValueError("a point lies on the horizon of the plane map")
    return np.asarray(mapped[..., :2] / mapped[..., 2:])
