"""Drawing a camera's picture of a scene: backdrop, shadows, solids, sensor."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import CameraMode, CameraSettings
from cell.geometry import Pose, Transform
from cell.kinematics import Matrix34
from cell.profile import BlockProfile, Profile, TwinCameraProfile
from cell.store import StoreSlot
from cell.twin.cameras.arm_shape import ArmSkeleton, GripperLook, arm_figures, box_figures
from cell.twin.cameras.backdrop import (
    LENS_BLUR,
    MovingBackdrop,
    View,
    fixed_backdrop,
    pattern_levels,
)
from cell.twin.cameras.figures import Figure
from cell.twin.cameras.ground import PAINT, Ground
from cell.twin.cameras.light import (
    Lamps,
    PanelPicture,
    ScreenGlow,
    flicker_share,
    lamps,
    screen_glow,
)
from cell.twin.cameras.optics import FULL_WIDTH_PX, Lens, lens_for_mode
from cell.twin.cameras.painter import Brush, Eye, Sketch, paint, sketch
from cell.twin.cameras.sensor import Exposure, SensorNoise
from cell.twin.cameras.shadows import cast_shadows, standing
from cell.twin.cameras.shapes import Colour, Solid, box, bridge, frustum
from cell.twin.scene import Scene, SceneBlock

_BLOCK_GLOSS = 1.0
_KEPT_BACKDROPS = 8
_KEPT_SKETCHES = 200
_UNKNOWN_PAINT: Colour = (0.4, 0.4, 0.4)


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """How one picture is taken.

    Attributes:
        settings: The settings in force.
        defaults: The settings at which levels are nominal.
        number: Number of the frame; decides its noise.
        is_covered: Whether the lens is covered.
        defocus_px: Standard deviation of the blur at 1280 pixels across; 0 for a sharp lens.
    """

    settings: CameraSettings
    defaults: CameraSettings
    number: int
    is_covered: bool = False
    defocus_px: float = 0.0


@dataclass(frozen=True, slots=True)
class _Light:
    """Everything that shines."""

    panel: PanelPicture | None
    lamps: Lamps
    glow: ScreenGlow


class Renderer:
    """Draws what a camera at one place, in one mode, sees."""

    def __init__(
        self,
        name: str,
        profile: Profile,
        placing: TwinCameraProfile,
        mode: CameraMode,
        *,
        arm: ArmSkeleton,
        seed: int,
        slots: Sequence[StoreSlot],
    ) -> None:
        """Set up a camera.

        Args:
            name: Its name in the profile; another one on the flange is drawn, itself not.
            profile: The cell's profile.
            placing: Where it stands and what its lens does.
            mode: Its picture size.
            arm: Kinematics of the arm that is drawn.
            seed: Decides the sensor's noise.
            slots: The places printed on the store's sheet.
        """
        self._profile = profile
        self._placing = placing
        self._arm = arm
        self._seed = seed
        self._rate_hz = mode.rate_hz
        self._ground = Ground(
            display=profile.display,
            store=profile.store,
            surface_mm=profile.heights.surface_mm,
            slots=tuple(slots),
            blocks=tuple(profile.blocks.items()),
        )
        self._mount_from_camera = Transform.from_pose(
            Pose(*placing.position_mm, *placing.rotation_deg)
        )
        self._is_fixed = placing.mount == "world"
        self._gripper = GripperLook(
            profile.gripper, profile.arm.tool_mm[2], _flange_camera(profile, name)
        )
        self._boxes = box_figures(profile.boxes, profile.heights.surface_mm)
        self._lens = lens_for_mode(placing, mode)
        self._moving = None if self._is_fixed else MovingBackdrop(self._ground, self._lens)
        self._canvas = np.empty((mode.height_px, mode.width_px, 3), np.uint8)
        self._backdrops: dict[tuple[object, ...], NDArray[np.uint8]] = {}
        self._figures: dict[SceneBlock, Figure] = {}
        self._sketches: dict[Figure, Sketch] = {}
        self._sketch_key: tuple[object, ...] | None = None

    def take(self, scene: Scene, shot: Shot) -> NDArray[np.uint8]:
        """Return a new picture (height, width, 3) of a scene."""
        exposure = Exposure(shot.settings, shot.defaults)
        if shot.is_covered:
            self._canvas[:] = 0
            return self._develop(self._canvas, exposure, shot)
        points, tool = self._arm.chain(scene.joints_deg)
        rotation, tool_point = _split(tool)
        eye = Eye(self._lens, self._robot_from_camera(rotation, tool_point))
        panel = None if scene.picture is None else PanelPicture(scene.picture, scene.pixels)
        lamplight = self._lamplight(scene, shot)
        light = _Light(panel, lamplight, screen_glow(panel, self._profile.display))
        ground_blocks = standing(scene.blocks, self._ground.surface_mm)
        if self._moving is None:
            canvas = self._fixed_canvas(ground_blocks, eye, exposure, light)
        else:
            canvas = self._moving.draw(
                eye.robot_from_camera,
                panel,
                exposure,
                lamps=lamplight,
                blocks=ground_blocks,
                glow=light.glow,
            )
        brush = Brush(
            expose=_levels(exposure, self._lens),
            glare=exposure.linear,
            glow=light.glow,
            lamps=lamplight,
        )
        held, free = self._split_blocks(scene, rotation, tool_point)
        hand = self._hand(scene, eye, rotation, tool_point, held)
        moving = [*hand, *arm_figures(points, self._ground.surface_mm)]
        still = [*self._boxes, *(self._block(block) for block in free)]
        if self._is_fixed:
            key = (panel, lamplight, exposure)
            sketches = sketch(moving, eye, brush) + self._sketch_still(still, eye, brush, key)
        else:
            sketches = sketch(moving + still, eye, brush)
        groups: list[Sequence[Sketch]] = [sketches[: len(hand)]]
        groups += [(one,) for one in sketches[len(hand) :]]
        paint(canvas, groups)
        return self._develop(canvas, exposure, shot)

    def _lamplight(self, scene: Scene, shot: Shot) -> Lamps:
        """Return what the lamps give a frame; daylight does not flicker."""
        light = self._profile.twin.light
        given = lamps(light, are_lights_on=scene.are_lights_on)
        if not scene.are_lights_on:
            return given
        share = flicker_share(
            light,
            shutter_ms=shot.settings.shutter_ms,
            number=shot.number,
            rate_hz=self._rate_hz,
        )
        return given[0] * share, given[1] * share, given[2] * share

    def _sketch_still(
        self, figures: list[Figure], eye: Eye, brush: Brush, key: tuple[object, ...]
    ) -> list[Sketch]:
        """Sketch what does not move, for a fixed camera: once for each light."""
        if key != self._sketch_key or len(self._sketches) > _KEPT_SKETCHES:
            self._sketches.clear()
            self._sketch_key = key
        new = [figure for figure in figures if figure not in self._sketches]
        self._sketches.update(zip(new, sketch(new, eye, brush), strict=True))
        return [self._sketches[figure] for figure in figures]

    def _robot_from_camera(
        self, rotation: NDArray[np.float64], tool_point: NDArray[np.float64]
    ) -> Transform:
        if self._is_fixed:
            return self._mount_from_camera
        matrix = np.eye(4)
        matrix[:3, :3] = rotation
        matrix[:3, 3] = tool_point - rotation @ np.array(self._profile.arm.tool_mm)
        return Transform(matrix) @ self._mount_from_camera

    def _fixed_canvas(
        self,
        blocks: tuple[SceneBlock, ...],
        eye: Eye,
        exposure: Exposure,
        light: _Light,
    ) -> NDArray[np.uint8]:
        """Return a copy of the kept backdrop with the shadows of standing blocks on it."""
        base_key = (light.panel, light.lamps, exposure)
        key = (*base_key, blocks)
        kept = self._backdrops.get(key)
        if kept is None:
            base = self._backdrops.get(base_key)
            if base is None:
                base = self._developed_backdrop(light, eye, exposure)
                self._keep(base_key, base)
            kept = base.copy()

            def to_pixels(points_mm: NDArray[np.float64]) -> NDArray[np.float64] | None:
                camera = eye.to_camera(points_mm)
                return None if camera[:, 2].min() < 50.0 else eye.lens.project(camera)

            surface_mm = self._ground.surface_mm
            cast_shadows(kept, blocks, self._profile.blocks, surface_mm, to_pixels, light.glow)
            self._keep(key, kept)
        np.copyto(self._canvas, kept)
        return self._canvas

    def _developed_backdrop(self, light: _Light, eye: Eye, exposure: Exposure) -> NDArray[np.uint8]:
        view = View(self._ground, eye.lens, self._placing)
        place = eye.robot_from_camera
        pattern = pattern_levels(view, place, light.panel, light.lamps, exposure)
        if pattern is not None:
            return pattern
        received = fixed_backdrop(view, place, light.panel, light.lamps)
        blurred = np.asarray(cv2.GaussianBlur(received, LENS_BLUR, 0), np.float32)
        return exposure.levels(exposure.linear(blurred))

    def _keep(self, key: tuple[object, ...], backdrop: NDArray[np.uint8]) -> None:
        while len(self._backdrops) >= _KEPT_BACKDROPS:
            self._backdrops.pop(next(iter(self._backdrops)))
        self._backdrops[key] = backdrop

    def _block(self, block: SceneBlock) -> Figure:
        figure = self._figures.get(block)
        if figure is None:
            if len(self._figures) > _KEPT_SKETCHES:
                self._figures.clear()
            figure = _block_figure(block, self._profile.blocks[block.kind])
            self._figures[block] = figure
        return figure

    def _split_blocks(
        self, scene: Scene, rotation: NDArray[np.float64], tool_point: NDArray[np.float64]
    ) -> tuple[list[SceneBlock], list[SceneBlock]]:
        """Return the blocks between the fingers, and all others."""
        held, free = [], []
        x, y, z = tool_point
        for block in scene.blocks:
            is_near = abs(block.x_mm - x) < 80 and abs(block.y_mm - y) < 80
            if is_near and abs(block.z_mm - z) < 80:
                size = self._profile.blocks[block.kind]
                middle = (block.x_mm, block.y_mm, block.z_mm + size.height_mm / 2)
                in_tool = (np.array(middle) - tool_point) @ rotation
                half = scene.opening_mm / 2
                is_between = abs(in_tool[1]) < half and abs(in_tool[0]) < size.length_mm / 2
                if is_between and abs(in_tool[2]) < size.height_mm:
                    held.append(block)
                    continue
            free.append(block)
        return held, free

    def _hand(
        self,
        scene: Scene,
        eye: Eye,
        rotation: NDArray[np.float64],
        tool_point: NDArray[np.float64],
        held: Sequence[SceneBlock],
    ) -> list[Figure]:
        """Return the gripper with what it holds, in the order to draw it.

        Planes of the tool frame part its pieces, so their order follows from the side of
        each plane on which the camera is.
        """
        camera = (eye.robot_from_camera.translation_mm - tool_point) @ rotation
        body = self._gripper.body(rotation, tool_point)
        near = 1.0 if camera[1] > 0 else -1.0
        opening = scene.opening_mm
        far_finger = self._gripper.finger(rotation, tool_point, opening, -near)
        near_finger = self._gripper.finger(rotation, tool_point, opening, near)
        is_above = camera[2] < -self._profile.arm.tool_mm[2] / 2
        if is_above:
            far_finger, near_finger = far_finger[::-1], near_finger[::-1]
        fingers = [*far_finger, *(self._block(block) for block in held), *near_finger]
        return [*fingers, *body[::-1]] if is_above else [*body, *fingers]

    def _develop(
        self, canvas: NDArray[np.uint8], exposure: Exposure, shot: Shot
    ) -> NDArray[np.uint8]:
        """Return the finished picture: as sharp as lens and setting make it, with noise."""
        picture = canvas
        if shot.defocus_px > 0.0:
            sigma_px = shot.defocus_px * canvas.shape[1] / FULL_WIDTH_PX
            picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), sigma_px), np.uint8)
        weight = exposure.sharpening()
        if weight != 0.0:
            soft = cv2.GaussianBlur(picture, (0, 0), 1.5)
            picture = np.asarray(cv2.addWeighted(picture, 1.0 + weight, soft, -weight, 0), np.uint8)
        noise = SensorNoise(self._seed, self._placing.noise * exposure.amplification)
        return noise.apply(picture, shot.number)


def _split(tool: Matrix34) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    rows = np.array(tool).reshape(3, 4)
    return rows[:, :3], rows[:, 3]


def _flange_camera(profile: Profile, itself: str) -> tuple[float, float, float] | None:
    """Return where another camera hangs on the flange, None without one."""
    for name, placing in profile.twin.cameras.items():
        if placing.mount == "flange" and name != itself:
            return placing.position_mm
    return None


def _levels(
    exposure: Exposure, lens: Lens
) -> Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.uint8]]:
    def levels(light: NDArray[np.float64], pixels: NDArray[np.float64]) -> NDArray[np.uint8]:
        share = np.maximum(lens.brightness(pixels), 0.5)
        return exposure.levels(exposure.linear(light * share[:, None]))

    return levels


def _block_figure(block: SceneBlock, size: BlockProfile) -> Figure:
    turn = math.radians(block.yaw_deg)
    cos, sin = math.cos(turn), math.sin(turn)
    return Figure(
        _block_solid(size),
        np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]),
        np.array([block.x_mm, block.y_mm, block.z_mm]),
        PAINT.get(block.colour, _UNKNOWN_PAINT),
        _BLOCK_GLOSS,
        takes_glare=True,
    )


def _block_solid(size: BlockProfile) -> Solid:
    if size.shape == "cylinder":
        return frustum(size.length_mm / 2, size.length_mm / 2, size.height_mm, 32)
    if size.arch_radius_mm > 0:
        return bridge(size.length_mm, size.width_mm, size.height_mm, size.arch_radius_mm)
    return box(size.length_mm, size.width_mm, size.height_mm)
