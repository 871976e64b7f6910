"""The cell as its users see it: everything it can do, none of how it is wired."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from cell.clock import Clock
from cell.devices.absent import AbsentDisplay, AbsentGripper, AbsentScreen
from cell.devices.camera import MODES, Camera, CameraMode, Frame
from cell.devices.display import Display, Screen
from cell.devices.gripper import Gripper
from cell.errors import (
    CellError,
    DeviceError,
    GripFailed,
    LedgerError,
    LinkError,
    VisionError,
)
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
from cell.hand_laying import LaidOutByPeople
from cell.ledger import Ledger
from cell.manipulation import Deployment, Manipulator, Progress, no_progress
from cell.motion.guarded import GuardedArm
from cell.picture_cleaning import PictureCleaning, bring_home, seeing_camera
from cell.profile import Profile
from cell.recovery.faults import DeviceName
from cell.recovery.opening import OpeningFailed, Step, bring_up
from cell.recovery.resume import ResumeCheck
from cell.recovery.watched_camera import CameraKeeper
from cell.recovery.watched_display import DisplayKeeper
from cell.recovery.watched_gripper import WatchedGripper
from cell.reporting import FaultReporter
from cell.stop import StopToken
from cell.store import StorePlan, TablePlace
from cell.vision import find_blocks


class RobotCell:
    """A whole cell: arm, gripper, display, cameras, lights, store and ledger.

    Used by one thread at a time, except for `stop`, which anybody may set. After
    a fault the arm stands still and the ledger knows where the blocks are; nothing
    moves again before the resume check is clear, and `clean` then puts things right.
    What the profile disables is left out, and the event bus is told so.
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
        reporter = self._reporter = FaultReporter(events)
        self._has_gripper = profile.arm.enabled and profile.gripper.enabled
        if not self._has_gripper:
            gripper = AbsentGripper(profile.gripper.open_mm, on_skip=reporter.skipped)
        if not profile.display.enabled:
            display = AbsentDisplay(profile.display.input, on_skip=reporter.skipped)
            screen = AbsentScreen()
        self.gripper = WatchedGripper(
            gripper,
            arm,
            may_hold_block=lambda: self.manipulator.may_hold_block(),
            power_up=lambda: arm.arm.set_output(profile.outputs.gripper_power, is_on=True),
            reporter=reporter,
        )
        self.display = display
        self.screen = screen
        self.cameras = dict(cameras)
        self._pictures = CameraKeeper(reporter)
        can_manipulate = self._has_gripper and profile.manipulation.enabled
        kind = Manipulator if can_manipulate else LaidOutByPeople
        self.manipulator = kind(arm, self.gripper, ledger, plan, profile, events)
        self._keeper = DisplayKeeper(display, profile.display.input, reporter)
        arm.pass_through(
            lambda opened: ResumeCheck(
                profile,
                arm=opened,
                guard=arm.guard,
                gripper=gripper,
                grip_problem=self.manipulator.grip_problem,
                reporter=reporter,
            )
        )
        self.lattice = LatticeMap(
            step_mm=profile.lattice.step_mm,
            angle_deg=profile.lattice.angle_deg,
            origin_x_mm=profile.lattice.origin_mm[0],
            origin_y_mm=profile.lattice.origin_mm[1],
        )
        self._release = release
        self._is_open = False
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

        What does not need each other comes up at the same time, where the clock allows it,
        and all failures are told at once. After a fault this is also how somebody says that
        it may go on: the resume check decides then.

        Raises:
            DeviceError: A device does not come up; what was opened is closed again.
        """
        self.arm.allow_resume()
        if self._is_open:
            return
        identities: dict[str, str] = {}
        try:
            bring_up((self._arm_chain(identities), self._display_chain(identities)), self.clock)
            for device in ("arm", "gripper", "display"):
                self.events.emit(DeviceOpened(device, identities[device]))
            self.switch_lights(is_on=True)
        except CellError as error:
            self._tell_failures(error)
            self._switch_off()
            raise
        if not self.profile.manipulation.enabled:
            self._reporter.skipped("manipulation", "people lay out and clear the blocks")
        self._is_open = True

    def _arm_chain(self, identities: dict[str, str]) -> list[Step]:
        """Return how arm and gripper come up: the gripper has its power from the arm."""

        def power_gripper() -> None:
            if self._has_gripper:
                self.set_output(self.profile.outputs.gripper_power, is_on=True)

        return [
            self._step("arm", self.arm.open, identities),
            Step("arm", power_gripper),
            self._step("gripper", self.gripper.open, identities),
        ]

    def _display_chain(self, identities: dict[str, str]) -> list[Step]:
        return [
            self._step("display", self.display.open, identities),
            Step("display", self.display.switch_on),
            Step("display", lambda: self.display.select_input(self.profile.display.input)),
        ]

    def _step(self, device: str, bring: Callable[[], str], identities: dict[str, str]) -> Step:
        def run() -> None:
            self.stop.check()
            identities[device] = bring()

        return Step(device, run)

    def _tell_failures(self, error: CellError) -> None:
        if isinstance(error, OpeningFailed):
            for failure in error.failures:
                self.events.emit(DeviceFailed(failure.device, str(failure.error)))
        else:
            self.events.emit(DeviceFailed("cell", str(error)))

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

    def _switch_off(self) -> None:
        """Close all devices; one that fails does not keep the others on.

        Fingers that may hold a block keep their power: without it they forget their zero.
        """
        outputs = self.profile.outputs
        keeps_power = self._may_hold_block()
        for device, close in (
            ("display", self.display.switch_off),
            ("display", self.display.close),
            ("gripper", self.gripper.close),
            ("lights", lambda: self.set_output(outputs.lights, is_on=False)),
            (
                "gripper",
                lambda: self.set_output(outputs.gripper_power, is_on=keeps_power),
            ),
            ("arm", self.arm.close),
            ("cameras", self.close_cameras),
        ):
            try:
                close()
            except CellError as error:
                self.events.emit(DeviceFailed(device, str(error)))
        self.events.emit(DeviceClosed("cell"))

    def _may_hold_block(self) -> bool:
        try:
            return self.manipulator.may_hold_block()
        except LedgerError:
            # Nobody knows: power does no harm.
            return True

    @contextmanager
    def _watched(self, device: DeviceName) -> Iterator[None]:
        """Hold the arm when a device fails, or the ledger cannot be written."""
        try:
            yield
        except LedgerError as error:
            raise self.arm.fail("ledger", error) from error
        except (DeviceError, LinkError) as error:
            if self.arm.is_held:
                raise
            raise self.arm.fail(device, error) from error

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
        with self._watched("ledger"):
            if not self.manipulator.is_table_clean():
                self.clean(progress)
            self.manipulator.lay_out(deployments, progress)

    def clean(self, progress: Progress = no_progress) -> list[int]:
        """Bring every block that is out back to its slot, and stand aside.

        A block that fell from the fingers is looked for: first in its slot, where a person
        may have put it, then with the camera over the table.

        Returns:
            The slot numbers of the blocks brought home.

        Raises:
            GripFailed: A block is not where the ledger has it, or a lost one is not found.
        """
        home: list[int] = []
        with self._watched("ledger"):
            if not self.manipulator.is_table_clean():
                home = self.manipulator.clean(progress=progress)
            if self.ledger.strays():
                home += self._find_strays(progress)
        self.arm.raise_to(self.profile.heights.service_mm)
        self.arm.rest()
        return home

    def _find_strays(self, progress: Progress) -> list[int]:
        home = self.manipulator.look_for_strays()
        if self.ledger.strays():
            picture = self.screen.shown()
            try:
                home += self.clean_from_picture(progress).home
            except VisionError as error:
                raise GripFailed(f"{self._lost()} ({error})") from error
            finally:
                self.show(picture)
        if self.ledger.strays():
            raise GripFailed(self._lost())
        return home

    def _lost(self) -> str:
        blocks = ", ".join(self.plan.slot(number).block for number in self.ledger.strays())
        return (
            f"{blocks}: fell from the fingers and is not found; look around the table, put it "
            "into its slot by hand, then run `cell clean`"
        )

    def deploy(self, slot: int, place: TablePlace) -> None:
        """Bring one block from its slot to a place."""
        with self._watched("ledger"):
            self.manipulator.transfer(slot, None, place)

    def grip_at(self, place: TablePlace) -> int:
        """Grip the block at a place and lift it; return its slot number."""
        with self._watched("ledger"):
            return self.manipulator.pick_up(place)

    def release_at(self, place: TablePlace) -> None:
        """Put the gripped block down at a place."""
        with self._watched("ledger"):
            self.manipulator.put_down(place)

    def clean_objects(self, slots: Sequence[int], progress: Progress = no_progress) -> list[int]:
        """Bring only the blocks of these slots home."""
        with self._watched("ledger"):
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
        with self._watched("lights"):
            self.arm.arm.set_output(bit, is_on=is_on)

    def switch_lights(self, *, is_on: bool) -> None:
        """Switch the cell's lights."""
        self.set_output(self.profile.outputs.lights, is_on=is_on)
        self.events.emit(LightsSwitched(is_on))

    def switch_magnet(self, *, is_on: bool) -> None:
        """Switch the electromagnet (tool 2)."""
        self.set_output(self.profile.outputs.magnet, is_on=is_on)

    def show(self, picture: str) -> None:
        """Show a picture on the screen under the playground, and see to it that it is seen."""
        with self._watched("display"):
            if self._is_open:
                self._keeper.ensure_shown()
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
        with self._watched("camera"):
            frame = self._pictures.grab(device, mode)
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
