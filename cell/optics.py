"""Light, picture and cameras of a cell, and the other outputs of the arm's controller."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import MODES, Camera, CameraMode, CameraSettings, Frame
from cell.devices.display import Screen
from cell.errors import DeviceError
from cell.events import EventBus, FrameTaken, LightsSwitched, PictureShown
from cell.motion.guarded import GuardedArm
from cell.profile import OutputsProfile
from cell.recovery.watch import FaultWatch
from cell.recovery.watched_camera import CameraKeeper
from cell.recovery.watched_display import DisplayKeeper
from cell.recovery.watched_screen import ScreenKeeper
from cell.reporting import FaultReporter


class CellOptics:
    """What of a cell is seen, and what sees it.

    Args:
        arm: The arm, whose controller has the outputs; it is held when something fails.
        outputs: Numbers of the outputs.
        screen: The picture on the television.
        keeper: Sees to it that the television shows the picture.
        cameras: The cameras by name.
        settings_by_light: Settings of cameras that differ with the lights: on, off.
        reporter: Told what was brought back.
        events: Told what is switched, shown and taken.

    Attributes:
        is_display_up: Whether the television was brought up, so that it can be looked after.
    """

    def __init__(
        self,
        arm: GuardedArm,
        outputs: OutputsProfile,
        *,
        screen: Screen,
        keeper: DisplayKeeper,
        cameras: Mapping[str, Camera],
        reporter: FaultReporter,
        events: EventBus,
        settings_by_light: Mapping[str, tuple[CameraSettings, CameraSettings]] | None = None,
    ) -> None:
        self._arm = arm
        self._outputs = outputs
        self._watch = FaultWatch(arm)
        self._screen = ScreenKeeper(screen, reporter)
        self._keeper = keeper
        self._cameras = cameras
        self._pictures = CameraKeeper(reporter)
        self._events = events
        self._last_frames: dict[str, Frame] = {}
        self._settings_by_light = dict(settings_by_light or {})
        self._are_lights_on = True
        self._set_for_light: dict[str, bool] = dict.fromkeys(self._settings_by_light, True)
        self.is_display_up = False

    def set_output(self, bit: int, *, is_on: bool) -> None:
        """Switch one output of the arm controller."""
        with self._watch.over("lights"):
            self._arm.arm.set_output(bit, is_on=is_on)

    def switch_lights(self, *, is_on: bool) -> None:
        """Switch the cell's lights."""
        self.set_output(self._outputs.lights, is_on=is_on)
        self._are_lights_on = is_on
        self._events.emit(LightsSwitched(is_on))

    def shown(self) -> str:
        """Return the name of the picture on the screen."""
        return self._screen.shown()

    def show(self, picture: str) -> None:
        """Show a picture on the screen; with the television up, see to it that it is seen.

        Raises:
            DeviceError: Television or picture fail; the arm is held.
        """
        with self._seen():
            self._screen.show(picture)
        self._events.emit(PictureShown(picture))

    def show_pixels(self, pixels: NDArray[np.uint8], name: str) -> None:
        """Show any picture of the panel's size, and see to it that it is seen.

        Raises:
            DeviceError: Television or picture fail; the arm is held.
        """
        with self._seen():
            self._screen.show_pixels(pixels, name)
        self._events.emit(PictureShown(name))

    @contextmanager
    def _seen(self) -> Iterator[None]:
        if self.is_display_up:
            with self._watch.over("display"):
                self._keeper.ensure_shown()
        with self._watch.over("screen"):
            yield

    def grab(
        self, camera: str, width_px: int = 1280, height_px: int = 960, *, is_fresh: bool = False
    ) -> Frame:
        """Return a picture of a camera in the mode of that size.

        Args:
            camera: Name of the camera.
            width_px: Width of the picture.
            height_px: Height of the picture.
            is_fresh: Whether it must be a new one, even if nothing that it shows has changed.

        Raises:
            DeviceError: There is no such camera or mode, or no picture.
        """
        device = self._cameras.get(camera)
        if device is None:
            known = ", ".join(sorted(self._cameras))
            raise DeviceError(f"camera {camera}", f"is not in the profile; known are {known}")
        mode = camera_mode(camera, width_px, height_px)
        with self._watch.over("camera"):
            self._set_for_lights(device)
            frame = self._pictures.grab(device, mode, is_fresh=is_fresh)
        if self._last_frames.get(camera) is not frame:
            self._last_frames[camera] = frame
            self._events.emit(
                FrameTaken(camera, frame.number, frame.pixels.shape[1], frame.pixels.shape[0])
            )
        return frame

    def _set_for_lights(self, camera: Camera) -> None:
        """Give a camera the settings of the lights' state when that has changed.

        Only then: what somebody sets by hand in between stays.
        """
        pair = self._settings_by_light.get(camera.name)
        if pair is None or self._set_for_light[camera.name] == self._are_lights_on:
            return
        camera.configure(pair[0] if self._are_lights_on else pair[1]).require()
        self._set_for_light[camera.name] = self._are_lights_on

    def close_cameras(self) -> None:
        """Stop all cameras."""
        for camera in self._cameras.values():
            camera.close()
        self._pictures.forget()
        self._last_frames.clear()


def camera_mode(camera: str, width_px: int, height_px: int) -> CameraMode:
    """Return the camera mode of a picture size.

    Raises:
        DeviceError: There is none of that size.
    """
    for mode in MODES:
        if (mode.width_px, mode.height_px) == (width_px, height_px):
            return mode
    sizes = ", ".join(f"{m.width_px}x{m.height_px}" for m in MODES)
    raise DeviceError(
        f"camera {camera}", f"has no mode of {width_px}x{height_px} pixels; it has {sizes}"
    )
