"""What a camera on a moving flange sees of a target that stays where it is.

A point t of the target goes through robot, flange and camera to a pixel:

    q = robot_from_target · t,   f = flange_from_robot · q,   c = camera_from_flange · f

and c through Brown's lens. Small turns multiply from the right, R exp(w), so that their
derivatives are cross products (Sola, Deray and Atchuthan 2018, "A micro Lie theory for state
estimation in robotics", 4.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.geometry import LensModel, Transform

Points = NDArray[np.float64]
Matrix = NDArray[np.float64]

WIDTH_PX, HEIGHT_PX = 1280, 960
LENS_NAMES = ("focal_px", "centre_u_px", "centre_v_px", "k1", "k2")
LENS = slice(0, 5)
MOUNT = slice(5, 11)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MountView:
    """The target seen from one pose of the arm.

    Attributes:
        label: Name of the view.
        robot_from_flange: Where the flange was.
        points_mm: Points of the target in its own frame, (n, 3).
        pixels: Where they were seen, (n, 2).
        group: Which of the target's places it belongs to; 0 unless the target was moved.
    """

    label: str
    robot_from_flange: Transform
    points_mm: Points
    pixels: Points
    group: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MountState:
    """Everything that is fitted.

    Attributes:
        lens: focal length, centre u and v, k1 and k2, (5,); pixels are square.
        flange_from_camera: Where the camera hangs.
        targets: robot_from_target, one a group.
        scale: True millimetres for each given one of the target.
    """

    lens: Points
    flange_from_camera: Transform
    targets: tuple[Transform, ...]
    scale: float = 1.0

    def model(self) -> LensModel:
        """Return the lens as a value, for pictures of 1280 x 960."""
        focal, centre_u, centre_v, k1, k2 = (float(value) for value in self.lens)
        return LensModel(
            width_px=WIDTH_PX, height_px=HEIGHT_PX, focal_u_px=focal, focal_v_px=focal,
            centre_u_px=centre_u, centre_v_px=centre_v, k1=k1, k2=k2,
        )  # fmt: skip

    def moved(self, change: Points) -> MountState:
        """Return the state after a change of its parameters, in their order.

        Lens (5), the camera's turn in rad and shift in mm (6), the same of each target's
        place (6 each), then the scale if the change has one more.
        """
        count = 11 + 6 * len(self.targets)
        return MountState(
            lens=self.lens + change[LENS],
            flange_from_camera=_moved(self.flange_from_camera, change[MOUNT]),
            targets=tuple(
                _moved(one, change[11 + 6 * i : 17 + 6 * i]) for i, one in enumerate(self.targets)
            ),
            scale=self.scale + (float(change[count]) if len(change) > count else 0.0),
        )


class Scene:
    """All views together, point by point, so that they are projected at once.

    Args:
        views: The views.
    """

    def __init__(self, views: Sequence[MountView]) -> None:
        self.counts = [len(view.pixels) for view in views]
        self.view_of = np.repeat(np.arange(len(views)), self.counts)
        self.group_of = np.array([view.group for view in views])[self.view_of]
        self.points = np.concatenate([view.points_mm for view in views])
        self.pixels = np.concatenate([view.pixels for view in views])
        self._turn = np.stack([view.robot_from_flange.rotation for view in views])
        self._shift = np.stack([view.robot_from_flange.translation_mm for view in views])
        self.ends = np.cumsum([0, *self.counts])

    def residuals(self, state: MountState) -> Points:
        """Return seen less expected pixels, (2 n,)."""
        lens, _, _, camera, _ = self._chain(state)
        return (self.pixels - _pixels(lens, camera)).ravel()

    def inside(self, state: MountState, margin_px: float) -> NDArray[np.bool_]:
        """Return which points are seen so far or farther from the picture's edges, (n,).

        Brown's polynomial folds directions far outside of the picture back into it; they count
        as outside.
        """
        lens, _, _, camera, _ = self._chain(state)
        pixels = _pixels(lens, camera)
        size = np.array([WIDTH_PX, HEIGHT_PX]) - 1.0
        flat = camera[:, :2] / camera[:, 2:]
        corners = np.array([(0.0, 0.0), (size[0], 0.0), (0.0, size[1]), size])
        widest = np.linalg.norm(state.model().to_directions(corners), axis=1).max()
        seen = ((pixels >= margin_px) & (pixels <= size - margin_px)).all(axis=1)
        return np.asarray(seen & (np.linalg.norm(flat, axis=1) <= widest) & (camera[:, 2] > 1.0))

    def slopes(self, state: MountState, *, with_scale: bool = False) -> tuple[Matrix, Matrix]:
        """Return derivatives of the expected pixels: by the parameters, and by the arm's pose.

        The arm's pose changes by a shift (mm) and a turn (rad) in the flange's frame.

        Returns:
            Shapes (2 n, p) and (2 n, 6).
        """
        lens, target, flange, camera, turn = self._chain(state)
        by_camera, by_lens = _lens_slopes(lens, camera)
        mount = state.flange_from_camera.rotation
        by_flange = by_camera @ mount.T
        by_robot = by_flange @ np.swapaxes(self._turn[self.view_of], 1, 2)
        count = 11 + 6 * len(state.targets)
        slopes = np.zeros((len(self.points), 2, count + int(with_scale)))
        slopes[:, :, LENS] = by_lens
        slopes[:, :, 5:8] = by_camera @ _cross(camera)
        slopes[:, :, 8:11] = -by_flange
        in_target = by_robot @ turn
        for group in range(len(state.targets)):
            those = self.group_of == group
            at = 11 + 6 * group
            slopes[those, :, at : at + 3] = -in_target[those] @ _cross(target[those])
            slopes[those, :, at + 3 : at + 6] = by_robot[those]
        if with_scale:
            slopes[:, :, count] = np.einsum("nij,nj->ni", in_target, self.points)
        by_arm = np.concatenate([-by_flange, by_flange @ _cross(flange)], axis=2)
        return slopes.reshape(-1, slopes.shape[2]), by_arm.reshape(-1, 6)

    def _chain(self, state: MountState) -> tuple[Points, Points, Points, Points, Matrix]:
        turn = np.stack([one.rotation for one in state.targets])[self.group_of]
        shift = np.stack([one.translation_mm for one in state.targets])[self.group_of]
        target = self.points * state.scale
        robot = np.einsum("nij,nj->ni", turn, target) + shift
        off = robot - self._shift[self.view_of]
        flange = np.einsum("nji,nj->ni", self._turn[self.view_of], off)
        mount = state.flange_from_camera
        camera = (flange - mount.translation_mm) @ mount.rotation
        # Behind the camera there is no picture; held in front, the miss stays finite and large.
        camera[:, 2] = np.maximum(camera[:, 2], 1.0)
        return state.lens, target, flange, camera, turn


def turned(vector: Points) -> Matrix:
    """Return the rotation (3, 3) of a rotation vector (rad)."""
    return np.asarray(cv2.Rodrigues(np.asarray(vector, np.float64))[0], np.float64)


def turn_vector(rotation: Matrix) -> Points:
    """Return the rotation vector (3,), rad, of a rotation."""
    return np.asarray(cv2.Rodrigues(np.ascontiguousarray(rotation))[0], np.float64).ravel()


def transform(rotation: Matrix, shift_mm: Points) -> Transform:
    """Return a transform of its parts."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, shift_mm
    return Transform(matrix)


def _moved(one: Transform, change: Points) -> Transform:
    return transform(one.rotation @ turned(change[:3]), one.translation_mm + change[3:])


def _pixels(lens: Points, camera: Points) -> Points:
    flat = camera[:, :2] / camera[:, 2:]
    squared = np.einsum("ni,ni->n", flat, flat)
    radial = 1.0 + squared * (lens[3] + squared * lens[4])
    return np.asarray(flat * radial[:, None] * lens[0] + lens[1:3])


def _lens_slopes(lens: Points, camera: Points) -> tuple[Matrix, Matrix]:
    """Return derivatives of pixels by points of the camera frame and by the lens."""
    flat = camera[:, :2] / camera[:, 2:]
    squared = np.einsum("ni,ni->n", flat, flat)
    radial = 1.0 + squared * (lens[3] + squared * lens[4])
    steeper = 2.0 * lens[3] + 4.0 * lens[4] * squared
    by_flat = lens[0] * (
        radial[:, None, None] * np.eye(2)
        + steeper[:, None, None] * flat[:, :, None] * flat[:, None]
    )
    to_flat = np.zeros((len(camera), 2, 3))
    to_flat[:, 0, 0] = to_flat[:, 1, 1] = 1.0
    to_flat[:, :, 2] = -flat
    by_lens = np.zeros((len(camera), 2, 5))
    by_lens[:, :, 0] = flat * radial[:, None]
    by_lens[:, 0, 1] = by_lens[:, 1, 2] = 1.0
    by_lens[:, :, 3] = lens[0] * flat * squared[:, None]
    by_lens[:, :, 4] = lens[0] * flat * (squared**2)[:, None]
    return by_flat @ (to_flat / camera[:, 2, None, None]), by_lens


def _cross(vectors: Points) -> Matrix:
    """Return the matrices (n, 3, 3) of cross products with vectors (n, 3)."""
    matrix = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    matrix[:, 0, 1], matrix[:, 0, 2] = -z, y
    matrix[:, 1, 0], matrix[:, 1, 2] = z, -x
    matrix[:, 2, 0], matrix[:, 2, 1] = -y, x
    return matrix
