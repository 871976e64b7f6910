"""The cell as its users see it: everything it can do, none of how it is wired."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cell.block_work import BlockWork
from cell.cleaning.report import CleaningPlan, PictureCleaning
from cell.clock import Clock
from cell.devices.absent import AbsentDisplay, AbsentGripper, AbsentScreen
from cell.devices.camera import Camera, Frame
from cell.devices.display import Display, Screen
from cell.devices.gripper import Gripper
from cell.events import EventBus
from cell.geometry import JointPositions, LatticeMap, Pose
from cell.hand_laying import LaidOutByPeople
from cell.ledger import Ledger
from cell.manipulation import Deployment, Manipulator, Progress, no_progress
from cell.motion.guarded import GuardedArm
from cell.moving import move_over_table
from cell.optics import CellOptics, camera_mode
from cell.power import CellPower
from cell.profile import Profile
from cell.recovery.resume import ResumeCheck
from cell.recovery.watched_display import DisplayKeeper
from cell.recovery.watched_gripper import WatchedGripper
from cell.reporting import FaultReporter
from cell.stop import StopToken
from cell.store import StorePlan, TablePlace

__all__ = ["RobotCell", "camera_mode"]


class RobotCell:
    """A whole cell: arm, gripper, display, cameras, lights, store and ledger.

    Used by one thread at a time, except for `stop`, which anybody may set. After
    a fault the arm stands still and the ledger knows where the blocks are; nothing
    moves again before the resume check is clear, and `clean` then puts things right.
    The first motion after every opening is checked likewise: nobody knows what happened
    while no program watched. What the profile disables is left out, and the event bus is
    told so.
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
        has_gripper = profile.arm.enabled and profile.gripper.enabled
        if not has_gripper:
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
        kind = Manipulator if has_gripper and profile.manipulation.enabled else LaidOutByPeople
        self.manipulator = kind(arm, self.gripper, ledger, plan, profile, events)
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
        self._optics = CellOptics(
            arm,
            profile.outputs,
            screen=screen,
            keeper=DisplayKeeper(display, profile.display.input, reporter),
            cameras=self.cameras,
            reporter=reporter,
            events=events,
            settings_by_light={
                name: (device.settings, device.settings_lights_off)
                for name, device in profile.cameras.items()
                if device.settings_lights_off is not None
            },
        )
        self._power = CellPower(
            profile,
            arm=arm,
            gripper=self.gripper,
            display=display,
            optics=self._optics,
            may_hold_block=self.manipulator.may_hold_block,
            events=events,
            clock=clock,
            stop=stop,
        )
        self._blocks = BlockWork(
            profile,
            arm=arm,
            manipulator=self.manipulator,
            ledger=ledger,
            plan=plan,
            eyes=self._optics,
        )
        self._release = release
        self._is_open = self._was_open = False

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
        and all failures are told at once. The first motion is put to the resume check. After
        a fault this is also how somebody says that it may go on: the check decides then.

        Raises:
            DeviceError: A device does not come up; what was opened is closed again.
        """
        self.arm.allow_resume()
        if self._is_open:
            return
        self._power.switch_on()
        self._optics.is_display_up = True
        self._check_before_moving()
        if not self.profile.manipulation.enabled:
            self._reporter.skipped("manipulation", "people lay out and clear the blocks")
        self._is_open = True

    def _check_before_moving(self) -> None:
        """Have the first motion checked; say so if an earlier program left things unfinished."""
        self.arm.check_before_moving("the cell was just opened")
        was_open, self._was_open = self._was_open, True
        if was_open or self.arm.is_held or self.manipulator.is_table_clean():
            return
        self._reporter.held(
            "cell: the program before was not ended in order, blocks are out; the table is "
            "cleaned before anything is laid out"
        )

    def close(self) -> None:
        """Switch every device off; harmless when they are off.

        The arm stays where it is, and the gripper keeps what it holds.
        """
        if self._is_open:
            self._is_open = self._optics.is_display_up = False
            self._power.switch_off()

    def dispose(self) -> None:
        """Switch everything off and give back the ledger and the cell's lock."""
        self.close()
        self.ledger.close()
        self._release()

    # Motion

    def move_to(self, x_mm: float, y_mm: float, z_mm: float, rotation_deg: float = 180.0) -> None:
        """Bring the tool point, gripper down, to a place above the table.

        In a straight line when it stands at that height already; otherwise up to the service
        height, over, and down.

        Raises:
            MotionRefused: The guard turned it down.
            DeviceError: The arm did not get there.
        """
        move_over_table(
            self.arm,
            self.profile.heights.service_mm,
            x_mm=x_mm,
            y_mm=y_mm,
            z_mm=z_mm,
            rotation_deg=rotation_deg,
        )

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
        self._blocks.set_speed(speed_mm_s, joint_percent)

    # Blocks

    def lay_out(self, deployments: Sequence[Deployment], progress: Progress = no_progress) -> None:
        """Bring blocks from their slots to their places; see `BlockWork.lay_out`."""
        self._blocks.lay_out(deployments, progress)

    def clean(self, progress: Progress = no_progress) -> list[int]:
        """Bring every block that is out home, and stand aside; see `BlockWork.clean`."""
        return self._blocks.clean(progress)

    def clean_objects(self, slots: Sequence[int], progress: Progress = no_progress) -> list[int]:
        """Bring only the blocks of these slots home."""
        return self._blocks.clean_objects(slots, progress)

    def clean_from_picture(self, progress: Progress = no_progress) -> PictureCleaning:
        """Bring home what the top camera sees; see `BlockWork.clean_from_picture`."""
        return self._blocks.clean_from_picture(progress)

    def plan_from_picture(self) -> CleaningPlan:
        """Look and tell what would be cleaned how; see `BlockWork.plan_from_picture`."""
        return self._blocks.plan_from_picture()

    def deploy(self, slot: int, place: TablePlace) -> None:
        """Bring one block from its slot to a place."""
        self._blocks.deploy(slot, place)

    def carry(self, slot: int, place: TablePlace) -> None:
        """Bring one block from wherever it lies to a place; see `BlockWork.carry`."""
        self._blocks.carry(slot, place)

    def grip_at(self, place: TablePlace) -> int:
        """Grip the block at a place and lift it; return its slot number."""
        return self._blocks.grip_at(place)

    def release_at(self, place: TablePlace) -> None:
        """Put the gripped block down at a place."""
        self._blocks.release_at(place)

    def slot_of(self, kind: str, colour: str) -> tuple[int, ...]:
        """Return the numbers of the slots where blocks of a kind and colour belong."""
        return tuple(slot.number for slot in self.plan.slots_of(kind, colour))

    # Light, picture, cameras

    def set_output(self, bit: int, *, is_on: bool) -> None:
        """Switch one output of the arm controller."""
        self._optics.set_output(bit, is_on=is_on)

    def switch_lights(self, *, is_on: bool) -> None:
        """Switch the cell's lights."""
        self._optics.switch_lights(is_on=is_on)

    def switch_magnet(self, *, is_on: bool) -> None:
        """Switch the electromagnet (tool 2)."""
        self.set_output(self.profile.outputs.magnet, is_on=is_on)

    def show(self, picture: str) -> None:
        """Show a picture on the screen under the playground, and see to it that it is seen."""
        self._optics.show(picture)

    def show_pixels(self, pixels: NDArray[np.uint8], name: str = "pixels") -> None:
        """Show any picture of the panel's size, such as a pattern to measure with."""
        self._optics.show_pixels(pixels, name)

    def grab(
        self, camera: str, width_px: int = 1280, height_px: int = 960, *, is_fresh: bool = False
    ) -> Frame:
        """Return a picture of a camera in the mode of that size; a new one if it must be.

        Raises:
            DeviceError: There is no such camera or mode, or no picture.
        """
        return self._optics.grab(camera, width_px, height_px, is_fresh=is_fresh)

    def close_cameras(self) -> None:
        """Stop all cameras."""
        self._optics.close_cameras()
