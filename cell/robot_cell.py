"""The cell as its users see it: everything it can do, none of how it is wired."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from cell.clock import Clock
from cell.devices.camera import MODES, Camera, CameraMode, Frame
from cell.devices.display import Display, Screen
from cell.devices.gripper import Gripper
from cell.errors import CellError, DeviceError
from cell.events import (
    DeviceClosed,
    DeviceFailed,
    DeviceOpened,
    EventBus,
    FrameTaken,
    LightsSwitched,
    PictureShown,
)
from cell.geometry import JointPositions, LatticeMap, Pose
from cell.ledger import Ledger
from cell.manipulation import Deployment, Manipulator, Progress, no_progress
from cell.motion.guarded import GuardedArm
from cell.picture_cleaning import PictureCleaning, bring_home, seeing_camera
from cell.profile import Profile
from cell.stop import StopToken
from cell.store import StorePlan, TablePlace
from cell.vision import find_blocks


class RobotCell:
    """A whole cell: arm, gripper, display, cameras, lights, store and ledger.

    Used by one thread at a time, except for `stop`, which anybody may set. After
    a fault the arm stands still and the ledger knows where the blocks are; `clean`
    puts things right when the cause is gone.
    """

    def __init__(
        self,
        profile: Profile,
        *,
        arm: GuardedArm,
        gripper: Gripper,
        display: Display,
        screen: Screen,
        cameras: Mapping[str, Camera],
        ledger: Ledger,
        plan: StorePlan,
        events: EventBus,
        clock: Clock,
        stop: StopToken,
        release: Callable[[], None],
    ) -> None:
        self.profile = profile
        self.events = events
        self.clock = clock
        self.stop = stop
        self.plan = plan
        self.ledger = ledger
        self.arm = arm
        self.gripper = gripper
        self.display = display
        self.screen = screen
        self.cameras = dict(cameras)
        self.manipulator = Manipulator(arm, gripper, ledger, plan, profile, events)
        self.lattice = LatticeMap(
            step_mm=profile.lattice.step_mm,
            angle_deg=profile.lattice.angle_deg,
            origin_x_mm=profile.lattice.origin_mm[0],
            origin_y_mm=profile.lattice.origin_mm[1],
        )
        self._release = release
        self._is_open = False
        self._modes: dict[str, CameraMode] = {}
        self._last_frames: dict[str, Frame] = {}

    # A session's beginning

    def begin_session(self, seed: int) -> None:
        """Start anew whatever counts: frames, and the twin's chance."""
        self.close_cameras()

    def world_json(self) -> str:
        """Return the twin's world as text; empty on hardware."""
        return ""

    # Everything on, everything off

    @property
    def is_open(self) -> bool:
        """Whether the devices are up."""
        return self._is_open

    def open(self) -> None:
        """Bring every device up: arm, gripper with its power, display, lights.

        Raises:
            DeviceError: A device does not come up; what was opened is closed again.
        """
        if self._is_open:
            return
        try:
            self._bring_up("arm", self.arm.open)
            self.set_output(self.profile.outputs.gripper_power, is_on=True)
            self._bring_up("gripper", self.gripper.open)
            self._bring_up("display", self.display.open)
            self.display.switch_on()
            self.display.select_input(self.profile.display.input)
            self.switch_lights(is_on=True)
        except CellError as error:
            self.events.emit(DeviceFailed("cell", str(error)))
            self._switch_off()
            raise
        self._is_open = True

    def close(self) -> None:
        """Switch every device off; harmless when they are off.

        The arm stays where it is, and the gripper keeps what it holds.
        """
        if self._is_open:
            self._is_open = False
            self._switch_off()

    def dispose(self) -> None:
        """Switch everything off and give back the ledger and the cell's lock."""
        self.close()
        self.ledger.close()
        self._release()

    def _bring_up(self, device: str, bring: Callable[[], str]) -> None:
        self.stop.check()
        self.events.emit(DeviceOpened(device, bring()))

    def _switch_off(self) -> None:
        """Close all devices; one that fails does not keep the others on."""
        outputs = self.profile.outputs
        for device, close in (
            ("display", self.display.switch_off),
            ("display", self.display.close),
            ("gripper", self.gripper.close),
            ("lights", lambda: self.set_output(outputs.lights, is_on=False)),
            ("gripper", lambda: self.set_output(outputs.gripper_power, is_on=False)),
            ("arm", self.arm.close),
            ("cameras", self.close_cameras),
        ):
            try:
                close()
            except CellError as error:
                self.events.emit(DeviceFailed(device, str(error)))
        self.events.emit(DeviceClosed("cell"))

    # Motion

    def move_to(self, x_mm: float, y_mm: float, z_mm: float, rotation_deg: float = 180.0) -> None:
        """Bring the tool point, gripper down, to a place above the table.

        In a straight line when it stands at that height already; otherwise up to the service
        height, over, and down.

        Raises:
            MotionRefused: The guard turned it down.
            DeviceError: The arm did not get there.
        """
        target = Pose(x_mm, y_mm, z_mm, 180.0, 0.0, rotation_deg)
        here = self.arm.pose()
        if here == target:
            return
        if here.z_mm != z_mm or here.c_deg != rotation_deg:
            service_mm = self.profile.heights.service_mm
            self.arm.raise_to(service_mm)
            self.arm.move_joint(target.at_height(max(z_mm, service_mm)))
        self.arm.move_linear(target)

    def move_to_lattice(
        self, x: int, y: int, height_mm: float = 200.0, rotation_deg: float = 180.0
    ) -> None:
        """Bring the tool point over a lattice point at a height in the robot frame."""
        x_mm, y_mm = self.lattice.to_robot(x, y)
        self.move_to(x_mm, y_mm, height_mm, rotation_deg)

    def move_joints(self, joints: JointPositions) -> None:
        """Move every joint to an angle."""
        self.arm.move_joints(joints)

    def read_pose(self) -> Pose:
        """Return where the tool point is, as the controller says."""
        return self.arm.arm.read_pose()

    def set_speed(self, speed_mm_s: float, joint_percent: float) -> None:
        """Set the speed of later moves."""
        self.arm.set_speed(speed_mm_s, joint_percent)

    # Blocks

    def lay_out(self, deployments: Sequence[Deployment], progress: Progress = no_progress) -> None:
        """Bring blocks from their slots to their places; whatever is out is cleaned first.

        Raises:
            GripFailed: A block is not in its slot.
        """
        if not self.manipulator.is_table_clean():
            self.clean(progress)
        self.manipulator.lay_out(deployments, progress)

    def clean(self, progress: Progress = no_progress) -> list[int]:
        """Bring every block that is out back to its slot, and stand aside.

        Returns:
            The slot numbers of the blocks brought home.
        """
        home: list[int] = []
        if not self.manipulator.is_table_clean():
            home = self.manipulator.clean(progress=progress)
        self.arm.raise_to(self.profile.heights.service_mm)
        self.arm.rest()
        return home

    def deploy(self, slot: int, place: TablePlace) -> None:
        """Bring one block from its slot to a place."""
        self.manipulator.transfer(slot, None, place)

    def grip_at(self, place: TablePlace) -> int:
        """Grip the block at a place and lift it; return its slot number."""
        return self.manipulator.pick_up(place)

    def release_at(self, place: TablePlace) -> None:
        """Put the gripped block down at a place."""
        self.manipulator.put_down(place)

    def clean_objects(self, slots: Sequence[int], progress: Progress = no_progress) -> list[int]:
        """Bring only the blocks of these slots home."""
        return self.manipulator.clean(slots, progress)

    def clean_from_picture(self, progress: Progress = no_progress) -> PictureCleaning:
        """Bring home every block that the top camera sees, wherever it was left.

        The arm stands aside first; the screen shows white, then black.

        Raises:
            VisionError: No camera is mapped to the table, or screen or lights are off.
            DeviceError: A device fails.
        """
        camera, plane_map = seeing_camera(self.profile)
        self.arm.raise_to(self.profile.heights.service_mm)
        self.arm.rest()
        self.switch_lights(is_on=True)
        self.show("white")
        white = self.grab(camera).pixels
        self.show("black")
        black = self.grab(camera).pixels
        seen = find_blocks(white, black)
        cleaning = bring_home(seen, plane_map, self.manipulator, self.ledger, self.plan, progress)
        self.arm.raise_to(self.profile.heights.service_mm)
        self.arm.rest()
        return cleaning

    def slot_of(self, kind: str, colour: str) -> tuple[int, ...]:
        """Return the numbers of the slots where blocks of a kind and colour belong."""
        return tuple(slot.number for slot in self.plan.slots_of(kind, colour))

    # Light and picture

    def set_output(self, bit: int, *, is_on: bool) -> None:
        """Switch one output of the arm controller."""
        self.arm.arm.set_output(bit, is_on=is_on)

    def switch_lights(self, *, is_on: bool) -> None:
        """Switch the cell's lights."""
        self.set_output(self.profile.outputs.lights, is_on=is_on)
        self.events.emit(LightsSwitched(is_on))

    def switch_magnet(self, *, is_on: bool) -> None:
        """Switch the electromagnet (tool 2)."""
        self.set_output(self.profile.outputs.magnet, is_on=is_on)

    def show(self, picture: str) -> None:
        """Show a picture on the screen under the playground."""
        self.screen.show(picture)
        self.events.emit(PictureShown(picture))

    def grab(self, camera: str, width_px: int = 1280, height_px: int = 960) -> Frame:
        """Return a picture of a camera in the mode of that size.

        Raises:
            DeviceError: There is no such camera or mode, or no picture.
        """
        device = self.cameras.get(camera)
        if device is None:
            known = ", ".join(sorted(self.cameras))
            raise DeviceError(f"camera {camera}", f"is not in the profile; known are {known}")
        mode = camera_mode(camera, width_px, height_px)
        if self._modes.get(camera) != mode:
            device.open(mode)
            self._modes[camera] = mode
        frame = device.grab()
        if self._last_frames.get(camera) is not frame:
            self._last_frames[camera] = frame
            self.events.emit(
                FrameTaken(camera, frame.number, frame.pixels.shape[1], frame.pixels.shape[0])
            )
        return frame

    def close_cameras(self) -> None:
        """Stop all cameras."""
        for camera in self.cameras.values():
            camera.close()
        self._modes.clear()
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
