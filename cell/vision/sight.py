"""What a recogniser must know of the table before it looks: view, heights, sizes, screen.

Everything comes from the profile; nothing here is counted in pixels of one camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.errors import VisionError
from cell.geometry import CameraView, TableView
from cell.profile import Profile

Points = NDArray[np.float64]

PICTURE_PX = (960, 1280)
"""Rows and columns of the pictures that views are known for."""

_SIDES_PER_CIRCLE = 24
_HALF_LOCAL_MM = 40.0


@dataclass(frozen=True, slots=True, kw_only=True)
class KindShape:
    """The top face of one kind of block.

    Attributes:
        kind: Its name in the profile.
        is_round: Whether it is a disc.
        length_mm: Along its own x; the diameter of a disc.
        width_mm: Along its own y.
        height_mm: Height of the top face above the glass.
    """

    kind: str
    is_round: bool
    length_mm: float
    width_mm: float
    height_mm: float

    @property
    def area_mm2(self) -> float:
        """Area of the top face."""
        area = self.length_mm * self.width_mm
        return area * math.pi / 4.0 if self.is_round else area

    @property
    def symmetry_deg(self) -> float:
        """Turn after which it looks the same, 0 for every turn."""
        if self.is_round:
            return 0.0
        return 90.0 if abs(self.length_mm - self.width_mm) < 0.5 else 180.0

    @property
    def outline_mm(self) -> Points:
        """Corners about its middle, (n, 2), counter-clockwise seen from above."""
        if self.is_round:
            turn = 2.0 * np.pi * np.arange(_SIDES_PER_CIRCLE) / _SIDES_PER_CIRCLE
            return self.length_mm / 2.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        x, y = self.length_mm / 2.0, self.width_mm / 2.0
        return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])


@dataclass(frozen=True, kw_only=True)
class TableSight:
    """How a fixed camera sees the playground.

    Attributes:
        view: Picture to robot and back.
        surface_mm: Height of the glass.
        kinds: The blocks' top faces.
        panel_mm: Corners of the screen's picture in robot x, y, (4, 2) in turn.
        pixel_mm: Pitch of the screen's pixels.
        display_angle_deg: Direction of the screen picture's right, from robot x.
    """

    view: TableView
    surface_mm: float
    kinds: tuple[KindShape, ...]
    panel_mm: tuple[tuple[float, float], ...]
    pixel_mm: float
    display_angle_deg: float

    @staticmethod
    def of_profile(profile: Profile, camera: str, view: TableView | None = None) -> TableSight:
        """Return what the profile knows of a camera.

        Args:
            profile: The cell's profile.
            camera: Name of the camera.
            view: Its view, if it is known better than the profile has it.

        Raises:
            VisionError: There is no such camera, or nobody measured where its picture lies.
        """
        surface = profile.heights.surface_mm
        if camera not in profile.cameras:
            raise VisionError(f"the profile has no camera {camera!r}")
        known = view or profile.cameras[camera].view(profile.block_top_mm)
        if known is None:
            raise VisionError(
                f"camera {camera}: its picture is not mapped to the table; calibrate it first"
            )
        display = profile.display
        wide, high = display.size_mm
        corners = ((0.0, 0.0), (wide, 0.0), (wide, high), (0.0, high))
        return TableSight(
            view=known,
            surface_mm=surface,
            kinds=tuple(
                KindShape(
                    kind=name,
                    is_round=block.shape == "cylinder",
                    length_mm=block.length_mm,
                    width_mm=block.width_mm,
                    height_mm=block.height_mm,
                )
                for name, block in profile.blocks.items()
            ),
            panel_mm=tuple(display.to_robot(right, down) for right, down in corners),
            pixel_mm=display.pixel_mm,
            display_angle_deg=display.angle_deg,
        )

    @property
    def top_mm(self) -> float:
        """Height of the block tops above the base plane."""
        return self.surface_mm + self.kinds[0].height_mm

    @property
    def knows_heights(self) -> bool:
        """Whether the view holds at any height, not at that of the block tops alone."""
        return isinstance(self.view, CameraView)

    def panel_px(self, beyond_mm: float = 0.0) -> Points:
        """Return the screen's corners in the picture, (4, 2), moved outwards by a width.

        Without a view of all heights they are those of block tops that stand on them.
        """
        height = self.surface_mm if self.knows_heights else self.top_mm
        panel = np.array(self.panel_mm)
        along, across = panel[1] - panel[0], panel[3] - panel[0]
        out = beyond_mm * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
        panel = panel + out[:, :1] * along / np.linalg.norm(along)
        panel = panel + out[:, 1:] * across / np.linalg.norm(across)
        return self.view.to_picture(panel, height)

    def panel_mask(self, beyond_mm: float, shape: tuple[int, int]) -> NDArray[np.uint8]:
        """Return 255 on the screen and up to a width beyond it, read-only; see `panel_px`.

        Args:
            beyond_mm: Width, below 0 for the inner part alone.
            shape: Rows and columns of the mask: the picture's, or a whole fraction of them.
        """
        key = (beyond_mm, *shape)
        if key not in self._masks:
            scale = PICTURE_PX[0] / shape[0]
            mask = np.zeros(shape, np.uint8)
            corners = (self.panel_px(beyond_mm) + 0.5) / scale - 0.5
            line = np.rint(corners * 16.0).astype(np.int32)
            cv2.fillConvexPoly(mask, line, 255, cv2.LINE_8, 4)
            mask.setflags(write=False)
            self._masks[key] = mask
        return self._masks[key]

    @cached_property
    def _masks(self) -> dict[tuple[float, int, int], NDArray[np.uint8]]:
        return {}

    @cached_property
    def mm_per_px(self) -> float:
        """Length of a pixel at the block tops in the picture's middle."""
        middle = np.array([[PICTURE_PX[1] / 2.0, PICTURE_PX[0] / 2.0]])
        maps, _ = self.local_maps(middle)
        return math.sqrt(abs(float(np.linalg.det(maps[0, :, :2]))))

    def local_maps(self, middles_px: Points) -> tuple[Points, Points]:
        """Return affine maps from pixels to mm at the block tops, and back.

        Over the length of a block the view differs from its slope by less than 0.1 mm.

        Args:
            middles_px: Pixels around which they are good, (n, 2).

        Returns:
            Robot mm from pixels, (n, 2, 3), and pixels from robot mm, (n, 2, 3).
        """
        at_mm = self.view.to_robot(middles_px, self.top_mm)
        steps = _HALF_LOCAL_MM * np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
        around = self.view.to_picture(at_mm[:, None] + steps, self.top_mm)
        px_per_mm = np.stack([around[:, 0] - around[:, 1], around[:, 2] - around[:, 3]], axis=2) / (
            2.0 * _HALF_LOCAL_MM
        )
        mm_per_px = np.linalg.inv(px_per_mm)
        to_mm = at_mm[..., None] - mm_per_px @ middles_px[..., None]
        to_px = middles_px[..., None] - px_per_mm @ at_mm[..., None]
        return (
            np.concatenate([mm_per_px, to_mm], axis=2),
            np.concatenate([px_per_mm, to_px], axis=2),
        )


def turned(points: Points, angle_rad: float) -> Points:
    """Return points (n, 2) turned about the origin."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]))
