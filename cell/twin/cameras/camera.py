"""`TwinCamera`: a rendered sibling of the cell's cameras, with an emulated body behind it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence

from cell.clock import Clock
from cell.devices.camera import CameraMode, CameraSettings, Frame
from cell.devices.camera_configure import apply_settings, settings_of
from cell.devices.camera_features import (
    CameraFeature,
    CameraIdentity,
    FeatureName,
    SettingsReport,
)
from cell.drivers.iidc.features import IidcFeatures
from cell.errors import DeviceError, DeviceTimeout
from cell.profile import Profile
from cell.store import StoreSlot
from cell.twin.cameras.arm_shape import ArmSkeleton
from cell.twin.cameras.body import CameraBody, CameraFaults
from cell.twin.cameras.metering import is_metering, meter
from cell.twin.cameras.rendering import Renderer, Shot
from cell.twin.scene import Scene


class TwinCamera:
    """A camera of the twin, fixed in the cell or on the arm's flange.

    Its features live in the register file of an emulated Flea2. The methods from
    `freeze` on are its faults, for tests and demonstrations.
    """

    def __init__(
        self,
        name: str,
        profile: Profile,
        *,
        scene: Callable[[], Scene],
        arm: ArmSkeleton,
        clock: Clock,
        seed: int,
        slots: Sequence[StoreSlot] = (),
    ) -> None:
        """Make a camera, closed and at its default settings.

        Args:
            name: Its name in the profile, under `cameras` and `twin.cameras`.
            profile: The cell's profile.
            scene: Says what there is to see.
            arm: Kinematics of the arm that is drawn.
            clock: Tells when pictures are taken.
            seed: Decides the sensor's noise, together with the name.
            slots: The places printed on the store's sheet.
        """
        self._name = name
        self._profile = profile
        self._device = profile.cameras[name]
        self._placed_as = name
        self._placing = profile.twin.cameras[name]
        self._scene = scene
        self._arm = arm
        self._clock = clock
        self._slots = tuple(slots)
        digest = hashlib.sha256(f"{seed} {name}".encode()).digest()
        self._seed = int.from_bytes(digest[:4], "big")
        self._body = CameraBody(name, self._device)
        self._wanted = self._device.settings
        self._faults = CameraFaults()
        self._mode: CameraMode | None = None
        self._renderer: Renderer | None = None
        self._number = 0
        self._last: tuple[int, CameraSettings, Frame] | None = None
        self._settings: tuple[int, CameraSettings] | None = None
        self.configure(self._wanted)

    @property
    def name(self) -> str:
        """Name of the camera in the profile."""
        return self._name

    @property
    def identity(self) -> CameraIdentity:
        """Who the camera at the end of this cable is.

        Raises:
            DeviceError: Its cable is pulled.
        """
        self._body.registers.check_power()
        return self._body.identity

    @property
    def body(self) -> CameraBody:
        """The emulated body, with the registers that IIDC drivers read and write."""
        return self._body

    def open(self, mode: CameraMode) -> str:
        """Start in a mode, the frames counted from 1 again; return the identity.

        A body that has lost its settings gets them back.

        Raises:
            DeviceError: The cable is pulled, or another camera is at its end.
            FeatureError: A setting did not take.
        """
        self.close()
        self._check_identity()
        if self._body.registers.is_reset:
            self.configure(self._wanted).require()
        self._body.registers.set_frame_rate(mode.rate_hz)
        self._mode = mode
        self._number = 0
        self._point()
        return str(self.identity)

    def close(self) -> None:
        """Stop; closing twice does nothing."""
        self._mode = None
        self._renderer = None
        self._last = None

    def settings(self) -> CameraSettings:
        """Return the settings in force, as the registers say."""
        registers = self._body.registers
        if self._settings is None or self._settings[0] != registers.revision:
            if not registers.is_powered:
                return self._wanted
            self._settings = (registers.revision, settings_of(self.features(), self._wanted))
        return self._settings[1]

    def configure(self, settings: CameraSettings) -> SettingsReport:
        """Put settings in force for the next frame; return which features did not take.

        Raises:
            DeviceError: No camera can have such a setting, or the cable is pulled.
        """
        report = apply_settings(self._name, self._access(), settings)
        self._wanted = settings
        self._body.registers.is_reset = False
        return report

    def features(self) -> tuple[CameraFeature, ...]:
        """Return every feature of the body, as its registers say."""
        return self._access().all()

    def set_raw(self, name: FeatureName, value: int) -> CameraFeature:
        """Set a feature's raw value by hand."""
        return self._access().set_raw(name, value)

    def set_absolute(self, name: FeatureName, value: float) -> CameraFeature:
        """Set a feature's absolute value by hand."""
        return self._access().set_absolute(name, value)

    def set_auto(self, name: FeatureName, *, is_auto: bool) -> CameraFeature:
        """Leave a feature to the body, or take it back."""
        self._last = None
        return self._access().set_auto(name, is_auto=is_auto)

    def grab(self) -> Frame:
        """Return a picture of the scene as it is now.

        The same `Frame` comes back as long as scene and settings are the same.

        Raises:
            DeviceTimeout: It has fallen silent.
            DeviceError: It is not open, not on the bus, or gives half a picture.
        """
        renderer = self._ready()
        scene = self._scene()
        if self._last is not None:
            revision, settings, frame = self._last
            if revision == scene.revision and settings == self.settings():
                return frame
        return self._grab_new(renderer, scene)

    def grab_fresh(self) -> Frame:
        """Return a new picture of the scene, even if it has not changed.

        Raises:
            DeviceTimeout: It has fallen silent.
            DeviceError: It is not open, not on the bus, or gives half a picture.
        """
        return self._grab_new(self._ready(), self._scene())

    def _grab_new(self, renderer: Renderer, scene: Scene) -> Frame:
        faults = self._faults
        settings = self.settings()
        self._number += 1
        if faults.is_frozen and self._last is not None:
            pixels = self._last[2].pixels
        else:
            pixels = renderer.take(
                scene,
                Shot(
                    settings=settings,
                    defaults=self._body.defaults,
                    number=self._number,
                    is_covered=faults.is_covered,
                    defocus_px=faults.defocus_px,
                ),
            )
            pixels.setflags(write=False)
        frame = Frame(
            camera=self._name,
            number=self._number,
            time_s=self._clock.now_s(),
            pixels=pixels,
            settings=settings,
        )
        self._last = (scene.revision, settings, frame)
        if is_metering(self._body.registers):
            meter(self._body.registers, pixels)
        return frame

    def _ready(self) -> Renderer:
        """Return what draws pictures, if the camera is there to give one."""
        self._body.registers.check_power()
        if self._renderer is None or self._mode is None:
            raise DeviceError(f"camera {self._name}", "is not open", hint="open it in a mode first")
        if self._faults.is_silent:
            self._clock.sleep(self._device.timeout_s)
            raise DeviceTimeout(
                f"camera {self._name}",
                f"gave no picture within {self._device.timeout_s:g} s",
                hint="check its cable and power, then open it again",
            )
        if self._faults.half_frames > 0:
            self._faults.half_frames -= 1
            size = 3 * self._mode.width_px * self._mode.height_px
            raise DeviceError(
                f"camera {self._name}",
                f"gave half a picture: {size // 2} of {size} bytes arrived",
                hint="grab again; if it repeats, check the cable",
            )
        return self._renderer

    def _access(self) -> IidcFeatures:
        return IidcFeatures(self._name, self._body.registers)

    def _check_identity(self) -> None:
        found = self.identity
        if found.guid != self._device.guid:
            owner = next(
                (n for n, c in self._profile.cameras.items() if c.guid == found.guid), "unknown"
            )
            raise DeviceError(
                f"camera {self._name}",
                f"has GUID {self._device.guid} in the profile, but {found.guid} ({owner}) answers",
                hint="put the cables back into their own ports",
            )

    def _point(self) -> None:
        """Make the picture anew from where the camera stands and looks now."""
        self._last = None
        if self._mode is None:
            return
        dx_px, dy_px = self._faults.knock_px
        u_px, v_px = self._placing.centre_px
        placing = self._placing.model_copy(update={"centre_px": (u_px + dx_px, v_px + dy_px)})
        self._renderer = Renderer(
            self._placed_as,
            self._profile,
            placing,
            self._mode,
            arm=self._arm,
            seed=self._seed,
            slots=self._slots,
        )

    # Faults

    def freeze(self, is_frozen: bool = True) -> None:
        """Give the last picture again and again, under new numbers and times, or stop that."""
        if is_frozen and self._last is None and self._renderer is not None:
            self.grab()
        self._faults.is_frozen = is_frozen
        if not is_frozen:
            self._last = None

    def cover_lens(self, is_covered: bool = True) -> None:
        """Put the cap on the lens, or take it off."""
        self._faults.is_covered = is_covered
        self._last = None

    def defocus(self, sigma_px: float) -> None:
        """Turn the lens out of focus: a blur as seen at 1280 pixels across; 0 is sharp."""
        self._faults.defocus_px = sigma_px
        self._last = None

    def knock(self, dx_px: float, dy_px: float) -> None:
        """Turn the camera so that what it sees moves in the picture (1280 x 960); 0, 0 undoes."""
        self._faults.knock_px = (dx_px, dy_px)
        self._point()

    def leave_auto(self, feature: FeatureName) -> None:
        """Leave a feature automatic, as another program might.

        Raises:
            ValueError: The body has no automatic mode for it.
        """
        if not self._body.registers.leave_auto(feature):
            raise ValueError(f"the camera has no automatic {feature}")
        self._last = None

    def fall_silent(self, is_silent: bool = True) -> None:
        """Give no pictures, or give them again."""
        self._faults.is_silent = is_silent

    def half_frame(self, count: int = 1) -> None:
        """Lose half of each of the next pictures."""
        self._faults.half_frames = count
        self._last = None

    def pull_cable(self) -> None:
        """Take the camera off the bus, with its power."""
        self._body.registers.is_powered = False

    def plug_in(self) -> None:
        """Put the camera back on the bus: closed, its settings lost until it is opened."""
        if not self._body.registers.is_powered:
            self._body.registers.power_up()
            self.close()

    def swap_cables(self, other: TwinCamera) -> None:
        """Exchange the ports of two cameras: here is the other camera now, and there this one."""
        self._body, other._body = other._body, self._body
        self.swap_places(other)

    def swap_places(self, other: TwinCamera) -> None:
        """Exchange where two cameras hang; each keeps its cable and GUID."""
        self._placing, other._placing = other._placing, self._placing
        self._placed_as, other._placed_as = other._placed_as, self._placed_as
        self._settings = other._settings = None
        self._point()
        other._point()

    def mend(self) -> None:
        """Undo every fault of this camera, except swapped places and cables."""
        self._faults = CameraFaults()
        self.plug_in()
        self._point()
