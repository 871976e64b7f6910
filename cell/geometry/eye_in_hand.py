"""A camera on the second link of a SCARA arm: from its picture to the table.

Bloch (1994) 4.3-4.14 finds an object with the law of cosines in the triangle of gripper,
reference point and object. The same as vectors, with e(φ) = (cos φ, sin φ), R(φ) the turn by
φ and S = J1 + J2:

    object = l1 e(J1) + l2 e(S) + d_t_c e(S + b_angl - 180°) + R(S + 180° - angl_err) s
    s = (c_x (u - b_x), c_y (b_y - v))

The last two terms are the way from the gripper to the table point under the reference pixel,
and from there to the object. The vectors hold for every pixel; the printed form, with |b_x - i|
and |b_y - j| under an arc tangent and β ≥ 0, only right of and above the reference pixel.

What lies over the table appears too far from the picture's centre by d_ct / (d_ct - h)
(2.2.3); pixels are brought to the table first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.geometry.pose import JointPositions

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class EyeInHand:
    """Where the camera sits on the arm, and what its pixels measure; defaults are Bloch's.

    Attributes:
        scale_u_mm: Width of a pixel on the table (c_x).
        scale_v_mm: Height of a pixel on the table (c_y).
        reference_px: Column and row of the reference pixel (b_x, b_y).
        centre_px: Column and row where the camera looks straight down.
        camera_height_mm: Of the camera over the table (d_ct).
        face_height_mm: Of what is looked at over the table (d_ft).
        d_t_c_mm: From the gripper's axis to the table point under the reference pixel.
        b_angle_deg: Direction of that way: J1 + J2 + b_angle - 180 in the robot frame.
        angle_error_deg: Turn of the picture against link 2.
        link_1_mm: Length of the first link.
        link_2_mm: Length of the second link, to the gripper's axis.
    """

    scale_u_mm: float = 1.0 / 3.56
    scale_v_mm: float = 1.0 / 3.48
    reference_px: tuple[float, float] = (3.0, 457.0)
    centre_px: tuple[float, float] = (255.0, 241.0)
    camera_height_mm: float = 420.0
    face_height_mm: float = 8.0
    d_t_c_mm: float = 81.8
    b_angle_deg: float = 137.7
    angle_error_deg: float = 1.8
    link_1_mm: float = 400.0
    link_2_mm: float = 250.0

    def to_robot(
        self, u_px: float, v_px: float, joints: JointPositions, *, height_mm: float | None = None
    ) -> tuple[float, float]:
        """Return robot x and y in mm of what is seen at a pixel.

        Args:
            u_px: Column.
            v_px: Row, growing downwards.
            joints: Where the arm stood when the picture was taken; J1 and J2 count.
            height_mm: How high over the table the seen point lies; `face_height_mm` unless
                given.
        """
        pixels = np.array([u_px, v_px])
        x, y = self.places(pixels, np.array(joints.values[:2]), height_mm=height_mm)
        return float(x), float(y)

    def to_picture(
        self, x_mm: float, y_mm: float, joints: JointPositions, *, height_mm: float | None = None
    ) -> tuple[float, float]:
        """Return the pixel u, v at which a point of the robot frame is seen."""
        points = np.array([x_mm, y_mm])
        u, v = self.pixels(points, np.array(joints.values[:2]), height_mm=height_mm)
        return float(u), float(v)

    def angle_of(self, alpha_deg: float, joints: JointPositions) -> float:
        """Return the direction of a line in the robot frame, in [-90, 90) degrees (4.3).

        The printed O is its negative, and takes α from the picture's downward direction.

        Args:
            alpha_deg: Its direction in the picture on the table's scale (columns by c_x, rows
                by c_y), counter-clockwise as seen, from the picture's right.
            joints: Where the arm stood.
        """
        turned = alpha_deg + joints.values[0] + joints.values[1] - self.angle_error_deg
        return (turned + 90.0) % 180.0 - 90.0

    def places(
        self, pixels: Points, joints_deg: Points, *, height_mm: float | None = None
    ) -> Points:
        """Return robot points (..., 2) in mm of pixels (..., 2) seen at joints (..., 2)."""
        ahead = self.ahead_mm(pixels, height_mm=height_mm)
        both = joints_deg[..., 0] + joints_deg[..., 1]
        return (
            self.gripper(joints_deg)
            + self.d_t_c_mm * direction(both + self.b_angle_deg - 180.0)
            + turned(ahead, both + 180.0 - self.angle_error_deg)
        )

    def pixels(
        self, points_mm: Points, joints_deg: Points, *, height_mm: float | None = None
    ) -> Points:
        """Return pixels (..., 2) of robot points (..., 2): the inverse of `places`."""
        both = joints_deg[..., 0] + joints_deg[..., 1]
        away = (
            points_mm
            - self.gripper(joints_deg)
            - self.d_t_c_mm * direction(both + self.b_angle_deg - 180.0)
        )
        ahead = turned(away, self.angle_error_deg - 180.0 - both)
        on_table = ahead / self._scale + np.array(self.reference_px)
        seen: Points = self._centre + (on_table - self._centre) / self._shrink(height_mm)
        return seen

    def ahead_mm(self, pixels: Points, *, height_mm: float | None = None) -> Points:
        """Return how far right of and above the reference pixel pixels lie on the table."""
        on_table = self._centre + (np.asarray(pixels) - self._centre) * self._shrink(height_mm)
        ahead: Points = (on_table - np.array(self.reference_px)) * self._scale
        return ahead

    def gripper(self, joints_deg: Points) -> Points:
        """Return the gripper's place (..., 2) in mm at joints (..., 2) (4.11, 4.12)."""
        first, both = joints_deg[..., 0], joints_deg[..., 0] + joints_deg[..., 1]
        return self.link_1_mm * direction(first) + self.link_2_mm * direction(both)

    def _shrink(self, height_mm: float | None) -> float:
        height = self.face_height_mm if height_mm is None else height_mm
        if not height < self.camera_height_mm:
            raise ValueError(
                f"a point {height:g} mm over the table is not below the camera at "
                f"{self.camera_height_mm:g} mm"
            )
        return 1.0 - height / self.camera_height_mm

    @property
    def _scale(self) -> Points:
        return np.array([self.scale_u_mm, -self.scale_v_mm])

    @property
    def _centre(self) -> Points:
        return np.array(self.centre_px)


def direction(angle_deg: float | Points) -> Points:
    """Return unit vectors (..., 2) at angles (...)."""
    angle = np.radians(angle_deg)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def turned(vectors: Points, angle_deg: float | Points) -> Points:
    """Return vectors (..., 2) turned counter-clockwise by angles (...)."""
    ahead = direction(angle_deg)
    x, y = vectors[..., 0], vectors[..., 1]
    c, s = ahead[..., 0], ahead[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)
