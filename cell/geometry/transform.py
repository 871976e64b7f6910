"""Rigid transforms, named so that chains cancel (`world_from_camera`)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.geometry.pose import Pose


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """A rigid transform of points in millimetres.

    Attributes:
        matrix: Shape (4, 4), float64, read-only; the last row is 0 0 0 1.
    """

    matrix: NDArray[np.float64]

    def __post_init__(self) -> None:
        matrix = np.array(self.matrix, dtype=np.float64)
        if matrix.shape != (4, 4):
            raise ValueError(f"a transform is a 4 x 4 matrix, not {matrix.shape}")
        matrix.setflags(write=False)
        object.__setattr__(self, "matrix", matrix)

    @staticmethod
    def identity() -> Transform:
        """Return the transform that changes nothing."""
        return Transform(np.eye(4))

    @staticmethod
    def from_pose(pose: Pose) -> Transform:
        """Return robot-from-tool for a pose, R = Rz(c) · Ry(b) · Rx(a)."""
        a, b, c = (math.radians(v) for v in (pose.a_deg, pose.b_deg, pose.c_deg))
        ca, sa, cb, sb, cc, sc = (
            math.cos(a), math.sin(a), math.cos(b), math.sin(b), math.cos(c), math.sin(c),
        )  # fmt: skip
        return Transform(
            np.array(
                [
                    [cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa, pose.x_mm],
                    [sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa, pose.y_mm],
                    [-sb, cb * sa, cb * ca, pose.z_mm],
                    [0.0, 0.0, 0.0, 1.0],
                ]
            )
        )

    def to_pose(self) -> Pose:
        """Return the pose of the transformed frame.

        At b = ±90 deg, where a and c turn about the same axis, a is set to 0.
        """
        m = self.matrix
        horizontal = math.hypot(m[0, 0], m[1, 0])
        b = math.atan2(-m[2, 0], horizontal)
        if horizontal > 1e-9:
            a = math.atan2(m[2, 1], m[2, 2])
            c = math.atan2(m[1, 0], m[0, 0])
        else:
            a = 0.0
            c = math.atan2(-m[0, 1], m[1, 1])
        x, y, z = (float(v) for v in m[:3, 3])
        return Pose(x, y, z, math.degrees(a), math.degrees(b), math.degrees(c))

    @property
    def rotation(self) -> NDArray[np.float64]:
        """The rotation part, shape (3, 3)."""
        return self.matrix[:3, :3]

    @property
    def translation_mm(self) -> NDArray[np.float64]:
        """The translation part, shape (3,)."""
        return self.matrix[:3, 3]

    def __matmul__(self, other: Transform) -> Transform:
        """Chain two transforms: `a_from_b @ b_from_c` is a-from-c."""
        return Transform(self.matrix @ other.matrix)

    def inverse(self) -> Transform:
        """Return the transform the other way round."""
        rotation = self.rotation.T
        matrix = np.eye(4)
        matrix[:3, :3] = rotation
        matrix[:3, 3] = -rotation @ self.translation_mm
        return Transform(matrix)

    def apply(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Transform points of shape (..., 3)."""
        return points_mm @ self.rotation.T + self.translation_mm
