"""The flat part of a picture: the ground as a camera sees it, lens included.

A fixed camera's backdrop is worked out exactly once for each picture on the screen
and kept. The camera on the flange sees another one at every pose: its backdrop is
taken from one drawing of the whole ground through a map that is exact on a coarse
grid of rays and interpolated between.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.geometry import Transform
from cell.profile import TwinCameraProfile
from cell.twin.cameras.ground import Ground, floor_light, is_on_table
from cell.twin.cameras.light import Lamps, PanelPicture, ScreenGlow, screen_light, screen_table
from cell.twin.cameras.optics import GridSpreader, Lens, brightness_map, coarse_rays, pixel_rays
from cell.twin.cameras.sensor import Exposure
from cell.twin.cameras.shadows import cast_shadows
from cell.twin.scene import SceneBlock

HEADROOM = 2.0
"""How far beyond white the moving backdrop keeps light, so that vignetting and glare
act before it clips."""

LENS_BLUR = (3, 3)
"""Kernel of what every lens blurs."""

_FLOOR_DROP_MM = 840.0
_FARTHEST_MM = 6000.0
_WALL = np.array([96.0, 99.0, 104.0], np.float32)
_TEXTURE_PX_MM = 0.8
_TEXTURE_MARGIN_MM = 150.0

Light = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class View:
    """A camera that stands still.

    Attributes:
        ground: What it looks at.
        lens: Its lens in the mode in use.
        placing: Where it stands; tells two cameras with the same lens apart.
    """

    ground: Ground
    lens: Lens
    placing: TwinCameraProfile


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """What a fixed camera sees of the ground.

    Attributes:
        lamplight: Light under the lamps, (h, w, 3).
        panel_u: Panel column seen by each pixel.
        panel_v: Panel row seen by each pixel.
        cover: How much of each pixel the panel covers.
    """

    lamplight: Light
    panel_u: Light
    panel_v: Light
    cover: Light


def fixed_backdrop(
    view: View, robot_from_camera: Transform, panel: PanelPicture | None, lamps: Lamps
) -> Light:
    """Return the light (h, w, 3) that a fixed camera receives from the ground, unclipped."""
    seen = _seen(view, robot_from_camera)
    light = seen.lamplight * np.array(lamps, np.float32)
    lit = screen_light(panel)
    if lit is not None:
        shown = cv2.remap(
            lit, seen.panel_u, seen.panel_v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        light += np.asarray(shown) * seen.cover[..., None]
    light *= brightness_map(view.lens)[..., None]
    return light


def pattern_levels(
    view: View,
    robot_from_camera: Transform,
    panel: PanelPicture | None,
    lamps: Lamps,
    exposure: Exposure,
) -> NDArray[np.uint8] | None:
    """Return levels (h, w, 3) of the ground under a grey picture, None for any other picture.

    Patterns to measure with come by the dozen and are grey: one channel is warped and
    blurred instead of three, and the lamps' part is kept.
    """
    settings = exposure.settings
    is_mixed = settings.saturation_percent != 100.0 or settings.hue_deg != 0.0
    if panel is None or panel.pixels is None or is_mixed or exposure.is_bent():
        return None
    grey = _grey(panel.pixels)
    if grey is None:
        return None
    seen = _seen(view, robot_from_camera)
    planes = _blurred_lamplight(view, robot_from_camera.matrix.tobytes())
    shown = cv2.remap(
        screen_table()[grey], seen.panel_u, seen.panel_v, cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
    shown = cv2.multiply(shown, seen.cover, dst=shown)
    shown = cv2.multiply(shown, brightness_map(view.lens), dst=shown)
    shown = cv2.GaussianBlur(shown, LENS_BLUR, 0)
    gains = exposure.linear(np.ones(3)).tolist()
    channels = [
        cv2.addWeighted(plane, gain * lamp, shown, gain, 0.0, dtype=cv2.CV_8U)
        for plane, gain, lamp in zip(planes, gains, lamps, strict=True)
    ]
    return np.asarray(cv2.merge(channels), np.uint8)


def _grey(pixels: NDArray[np.uint8]) -> NDArray[np.uint8] | None:
    """Return the one channel of a picture (h, w) whose three are the same, None otherwise."""
    red, green, blue = cv2.split(pixels)
    is_grey = np.array_equal(red, green) and np.array_equal(red, blue)
    return np.asarray(red, np.uint8) if is_grey else None


@lru_cache(maxsize=4)
def _blurred_lamplight(view: View, matrix: bytes) -> tuple[Light, ...]:
    """Return the planes (h, w) of R, G and B of what nominal lamps send to the sensor."""
    light = _seen_of(view, matrix).lamplight * brightness_map(view.lens)[..., None]
    return tuple(
        np.asarray(k, np.float32) for k in cv2.split(cv2.GaussianBlur(light, LENS_BLUR, 0))
    )


@lru_cache(maxsize=4)
def _seen_of(view: View, matrix: bytes) -> _Seen:
    robot_from_camera = Transform(np.frombuffer(matrix).reshape(4, 4))
    ground, lens = view.ground, view.lens
    rays = pixel_rays(lens) @ robot_from_camera.rotation.T.astype(np.float32)
    eye = robot_from_camera.translation_mm
    x_mm, y_mm, share = _hit(rays, eye, ground.surface_mm)
    px_mm = np.maximum(share / lens.focal_px, 1e-3)
    light = ground.lamplight(x_mm, y_mm, px_mm)
    beyond = ~is_on_table(x_mm, y_mm)
    if beyond.any():
        floor_x, floor_y, far = _hit(rays, eye, ground.surface_mm - _FLOOR_DROP_MM)
        haze = np.clip(far / _FARTHEST_MM, 0.0, 1.0)[..., None]
        room = floor_light(floor_x, floor_y) * (1.0 - haze) + _WALL * haze
        light[beyond] = room[beyond]
    along, below = ground.panel_mm(x_mm, y_mm)
    pixel_mm = np.float32(ground.display.pixel_mm)
    return _Seen(
        lamplight=light,
        panel_u=np.asarray(along / pixel_mm - 0.5, np.float32),
        panel_v=np.asarray(below / pixel_mm - 0.5, np.float32),
        cover=ground.panel_cover(x_mm, y_mm, px_mm),
    )


def _seen(view: View, robot_from_camera: Transform) -> _Seen:
    return _seen_of(view, robot_from_camera.matrix.tobytes())


def _hit(
    rays: NDArray[np.float32], eye: NDArray[np.float64], height_mm: float
) -> tuple[Light, Light, Light]:
    """Return x, y and distance where rays hit a level; rays that miss end far away."""
    fall = np.minimum(rays[..., 2], np.float32(-1e-3))
    share = np.minimum(np.float32(height_mm - eye[2]) / fall, np.float32(4 * _FARTHEST_MM))
    return (
        np.asarray(eye[0] + share * rays[..., 0], np.float32),
        np.asarray(eye[1] + share * rays[..., 1], np.float32),
        np.asarray(share, np.float32),
    )


class MovingBackdrop:
    """The ground for a camera that moves.

    Drawn with half the picture's resolution and enlarged: so near to the ground, a pixel
    of the drawing of it covers several of the picture's, and the ground lies behind
    what the lens is focused on.
    """

    def __init__(self, ground: Ground, lens: Lens) -> None:
        """Prepare for a lens whose picture has even sides."""
        self._ground = ground
        half = lens.resized(lens.width_px // 2)
        self._rays = coarse_rays(half).reshape(-1, 3)
        self._shape = coarse_rays(half).shape[:2]
        self._spreader = GridSpreader(half)
        share = np.rint(255 * brightness_map(half)).astype(np.uint8)
        self._vignette = np.asarray(cv2.merge([share] * 4), np.uint8)
        self._shaded_key: tuple[object, ...] | None = None
        self._shaded = np.empty((0, 0, 4), np.uint8)
        self._seen = np.empty((half.height_px, half.width_px, 4), np.uint8)
        self._small = np.empty((half.height_px, half.width_px, 3), np.uint8)
        self._canvas = np.empty((lens.height_px, lens.width_px, 3), np.uint8)

    def draw(
        self,
        robot_from_camera: Transform,
        panel: PanelPicture | None,
        exposure: Exposure,
        *,
        lamps: Lamps,
        blocks: tuple[SceneBlock, ...],
        glow: ScreenGlow,
    ) -> NDArray[np.uint8]:
        """Return levels (h, w, 3) of the ground with the shadows of blocks that stand on it.

        The array is drawn into again by the next call.
        """
        key = (panel, exposure, lamps, blocks)
        if key != self._shaded_key:
            self._shaded_key = key
            plain = _texture(self._ground, panel, exposure, lamps)
            self._shaded = self._with_shadows(plain, blocks, glow)
        texture = self._shaded
        where = self._spreader.spread(self._texture_places(robot_from_camera))
        beyond = texture[0, 0].tolist()
        # Four channels run through OpenCV's vectorised path, three do not.
        cv2.remap(  # type: ignore[call-overload]
            texture, where, None, cv2.INTER_LINEAR, dst=self._seen, borderValue=beyond
        )
        cv2.multiply(self._seen, self._vignette, dst=self._seen, scale=HEADROOM / 255.0)
        cv2.cvtColor(self._seen, cv2.COLOR_BGRA2BGR, dst=self._small)
        if exposure.is_bent():
            cv2.LUT(self._small, exposure.bend_table(), dst=self._small)
        height, width = self._canvas.shape[:2]
        cv2.resize(self._small, (width, height), dst=self._canvas)
        return self._canvas

    def _texture_places(self, robot_from_camera: Transform) -> NDArray[np.float32]:
        """Return where on the texture the rays of the coarse grid meet the ground."""
        rays = self._rays @ robot_from_camera.rotation.T
        eye = robot_from_camera.translation_mm
        share = (self._ground.surface_mm - eye[2]) / np.minimum(rays[:, 2], -1e-2)
        left, low, _, _ = _window_mm(self._ground)
        place = np.empty((len(rays), 2), np.float32)
        place[:, 0] = (eye[0] + share * rays[:, 0] - left) / _TEXTURE_PX_MM - 0.5
        place[:, 1] = (eye[1] + share * rays[:, 1] - low) / _TEXTURE_PX_MM - 0.5
        return place.reshape(*self._shape, 2)

    def _with_shadows(
        self, plain: NDArray[np.uint8], blocks: tuple[SceneBlock, ...], glow: ScreenGlow
    ) -> NDArray[np.uint8]:
        left, low, _, _ = _window_mm(self._ground)

        def to_pixels(points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.asarray((points_mm[:, :2] - (left, low)) / _TEXTURE_PX_MM - 0.5)

        shaded = plain.copy()
        sizes = dict(self._ground.blocks)
        cast_shadows(shaded, blocks, sizes, self._ground.surface_mm, to_pixels, glow)
        return shaded


@lru_cache(maxsize=4)
def _window_mm(ground: Ground) -> tuple[float, float, float, float]:
    """Return left, low, right, high of the part of the plane that the texture holds."""
    corners = ground.corners_mm()
    left, low = (corners.min(axis=0) - _TEXTURE_MARGIN_MM).tolist()
    right, high = (corners.max(axis=0) + _TEXTURE_MARGIN_MM).tolist()
    return left, low, right, high


@lru_cache(maxsize=1)
def _texture_light(ground: Ground) -> tuple[Light, Light, Light, Light]:
    """Return lamplight, panel coordinates and panel cover of the texture's points."""
    left, low, right, high = _window_mm(ground)
    x = np.arange(left + _TEXTURE_PX_MM / 2, right, _TEXTURE_PX_MM, dtype=np.float32)
    y = np.arange(low + _TEXTURE_PX_MM / 2, high, _TEXTURE_PX_MM, dtype=np.float32)
    x_mm, y_mm = np.meshgrid(x, y)
    light = ground.lamplight(x_mm, y_mm, _TEXTURE_PX_MM)
    along, below = ground.panel_mm(x_mm, y_mm)
    pixel_mm = np.float32(ground.display.pixel_mm)
    cover = ground.panel_cover(x_mm, y_mm, _TEXTURE_PX_MM)
    return light, along / pixel_mm - 0.5, below / pixel_mm - 0.5, cover


@lru_cache(maxsize=4)
def _texture(
    ground: Ground, panel: PanelPicture | None, exposure: Exposure, lamps: Lamps
) -> NDArray[np.uint8]:
    """Return the ground's exposed light over `HEADROOM`, seen from above, four channels."""
    lamplight, panel_u, panel_v, cover = _texture_light(ground)
    light = lamplight * np.array(lamps, np.float32)
    lit = screen_light(panel)
    if lit is not None:
        rows, columns = (slice(int(k.min()), int(k.max()) + 1) for k in np.nonzero(cover))
        part = np.s_[rows, columns]
        shown = cv2.remap(
            cv2.blur(lit, (3, 3)),
            panel_u[part],
            panel_v[part],
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        light[part] += np.asarray(shown) * cover[part][..., None]
    exposed = exposure.linear(light)
    half = np.clip(np.rint(exposed / np.float32(HEADROOM)), 0, 255).astype(np.uint8)
    return np.asarray(cv2.cvtColor(half, cv2.COLOR_BGR2BGRA), np.uint8)
