"""Single operations by hand: only the devices that one needs are brought up, then put back.

Motion still goes through the guarded arm of the cell. Reading, alarms, stops and outputs need
the controller of the arm but not its servos; what was found on stays on. A cell with a
playground and an arm that has none are the same in here, but for what only the former has.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Final, Protocol

from cell.clock import Clock
from cell.devices.gripper import Gripper
from cell.drivers.schunk_smp.scan import FoundModule, find_modules
from cell.drivers.ssc32.driver import Ssc32Arm
from cell.errors import CellError, MotionRefused, ProfileError, UnreachablePose
from cell.events import EventBus
from cell.geometry import JointPositions, Pose
from cell.links.base import Link
from cell.motion.guarded import GuardedArm
from cell.profile import CellProfile
from cell.reaching import PutBack, reaching
from cell.robot_cell import RobotCell
from cell.stop import StopToken

_BOOT_S: Final = 2.0
"""How long a module may take from power on until it answers (assumed)."""
_SERVICE_MM: Final = 200.0
_ANY_CURRENT_A: Final = 1.0


class HandCell(Protocol):
    """What operations by hand need of any cell."""

    @property
    def profile(self) -> CellProfile:
        """The cell's profile."""

    @property
    def clock(self) -> Clock:
        """The cell's clock."""

    @property
    def events(self) -> EventBus:
        """Where the cell's events go."""

    @property
    def stop(self) -> StopToken:
        """Ends what takes long."""

    @property
    def arm(self) -> GuardedArm:
        """The arm; every motion passes its guard."""

    @property
    def gripper(self) -> Gripper | None:
        """The gripper, None where the cell has none."""

    @property
    def dispose(self) -> Callable[[], None]:
        """Closes the wires and gives the cell back."""


class ByHand:
    """A cell of which only single devices are up.

    Args:
        cell: The cell, closed.

    Attributes:
        cell: The cell.
        reaching: How its controller is reached while the arm stays as it is.
    """

    def __init__(self, cell: HandCell) -> None:
        self.cell = cell
        self.reaching = reaching(cell.arm.arm, cell.profile.arm)
        self._put_back: list[PutBack] = []
        self._has_controller = False
        self._has_right = False
        self._has_gripper = False

    @property
    def clock(self) -> Clock:
        """The clock of the cell."""
        return self.cell.clock

    @property
    def has_playground(self) -> bool:
        """Whether the cell has a playground, with all that belongs to it."""
        return isinstance(self.cell, RobotCell)

    @property
    def playground(self) -> RobotCell:
        """The cell as one with a playground.

        Raises:
            ProfileError: It has none.
        """
        if isinstance(self.cell, RobotCell):
            return self.cell
        raise ProfileError(
            f"the cell {self.cell.profile.name} has no playground, and with it no lattice, store, "
            "television, lights, magnet or cameras by hand; `cell robot` and `cell gripper` work "
            "its arm and its fingers"
        )

    @property
    def gripper(self) -> Gripper:
        """The gripper.

        Raises:
            ProfileError: The cell has none.
        """
        if self.cell.gripper is None:
            raise ProfileError(
                f"the profile {self.cell.profile.name} leaves the fingers out; set `enabled` in "
                "[arm.fingers]"
            )
        return self.cell.gripper

    def reach_controller(self) -> None:
        """Begin to talk with the arm's controller; servos and alarms stay as they are.

        Raises:
            DeviceError: The controller does not answer or refuses.
        """
        if not self._has_controller:
            self._later(self.reaching.reach())
            self._has_controller = True

    def take_right(self) -> None:
        """Take the right to operate the controller, which outputs need.

        Raises:
            DeviceError: The controller does not answer, or somebody else has the right.
        """
        self.reach_controller()
        if not self._has_right:
            self._later(self.reaching.take_right())
            self._has_right = True

    def opening_moves(self) -> str:
        """Return what bringing the arm up will move, as a sentence; empty for nothing.

        Raises:
            DeviceError: The controller does not answer.
        """
        return self.reaching.opening_moves()

    @property
    def needs_confirmation(self) -> bool:
        """Whether the profile wants the first pose after power-up confirmed."""
        arm = self.cell.arm.arm
        return isinstance(arm, Ssc32Arm) and arm.wants_confirmation

    def confirm_first_pose(self) -> None:
        """Say that the arm was put into its rest pose by hand; for arms that ask for it."""
        arm = self.cell.arm.arm
        if isinstance(arm, Ssc32Arm):
            arm.confirm_first_pose()

    def bring_up_arm(self, *, leave_on: bool = False) -> str:
        """Bring the arm up with its servos on; return its identity.

        Args:
            leave_on: Whether the servos stay on afterwards.

        Raises:
            DeviceError: It does not come up.
        """
        self._has_controller = self._has_right = True
        identity = self.cell.arm.open()
        if not leave_on:
            self._put_back.append(self.cell.arm.close)
        return identity

    def let_go(self) -> None:
        """Stop the arm and close it, without bringing up one that would move for that.

        Raises:
            DeviceError: The controller does not answer.
        """
        self.reach_controller()
        if not self.reaching.let_go():
            self.bring_up_arm()

    # Where the arm is, and moves that every arm has

    def pose(self) -> Pose:
        """Return where the tool point is, as the controller says.

        Raises:
            DeviceError: The controller does not know, or does not answer.
        """
        self.reach_controller()
        self.reaching.require_place()
        return self.cell.arm.arm.read_pose()

    def joints(self) -> JointPositions:
        """Return where the joints are, as the controller says.

        Raises:
            DeviceError: The controller does not know, or does not answer.
        """
        self.reach_controller()
        self.reaching.require_place()
        return self.cell.arm.arm.read_joints()

    def move_to(
        self, x_mm: float, y_mm: float, z_mm: float | None, rotation_deg: float | None
    ) -> None:
        """Bring the tool point, gripper down, to a place.

        Over a playground as the cell itself does it; elsewhere in a straight line, or with all
        joints at once where no straight line is allowed.

        Args:
            x_mm: Robot x.
            y_mm: Robot y.
            z_mm: Height; None for the service height, elsewhere for where it is.
            rotation_deg: Turn of the gripper; None for 180, elsewhere for how it is.

        Raises:
            MotionRefused: The guard turned it down.
        """
        if self.has_playground:
            z_mm = _SERVICE_MM if z_mm is None else z_mm
            turn_deg = 180.0 if rotation_deg is None else rotation_deg
            self.playground.move_to(x_mm, y_mm, z_mm, turn_deg)
            return
        arm = self.cell.arm
        here = arm.pose()
        target = Pose(
            x_mm, y_mm, here.z_mm if z_mm is None else z_mm,
            180.0, 0.0, here.c_deg if rotation_deg is None else rotation_deg,
        )  # fmt: skip
        try:
            arm.move_linear(target)
        except (MotionRefused, UnreachablePose) as line:
            try:
                arm.move_joint(target)
            except (MotionRefused, UnreachablePose):
                raise line from None

    def home(self) -> None:
        """Go straight up first, as high as the arm stands aside, then stand aside.

        Raises:
            MotionRefused: The guard turned it down.
        """
        arm = self.cell.arm
        if self.has_playground:
            arm.raise_to(self.playground.profile.heights.service_mm)
        else:
            self._rise()
        arm.rest()

    def _rise(self) -> None:
        """Go straight up to the height of the rest pose, or, where that is not, stay."""
        arm = self.cell.arm
        rest = arm.guard.arm.forward(JointPositions(self.cell.profile.arm.rest_deg))
        here = arm.pose()
        if here.z_mm >= rest.z_mm:
            return
        try:
            arm.move_linear(replace(here, z_mm=rest.z_mm))
        except (MotionRefused, UnreachablePose):
            # The way of all joints at once is checked as a whole, too.
            return

    # The other devices

    def bring_up_gripper(self, *, may_move: bool = True, leave_on: bool = False) -> str:
        """Give the gripper power, if that is switched, and bring it up; return its identity.

        Args:
            may_move: Whether it may look for its zero, which moves the fingers.
            leave_on: Whether it keeps its power afterwards.

        Raises:
            DeviceError: It does not come up.
            ProfileError: The cell has none.
        """
        gripper = self.gripper
        if self.has_playground:
            self._give_power(leave_on=leave_on)
        self._put_back.append(gripper.close)
        self._has_gripper = True
        return gripper.open(may_move=may_move)

    def grip_current_a(self) -> float:
        """Return the current that sets the force of a grip; fingers without sensors take any."""
        return self.playground.profile.gripper.grip_current_a if self.has_playground \
            else _ANY_CURRENT_A  # fmt: skip

    def modules(self, ids: Iterable[int], line: Callable[[], Link]) -> list[FoundModule]:
        """Return the modules that answer on the gripper's line, without a driver of ours.

        Args:
            ids: The numbers to ask.
            line: Opens the line.

        Raises:
            LinkError: The line cannot be opened or breaks.
        """
        if self._give_power(leave_on=False):
            self.cell.clock.sleep(_BOOT_S)
        link = line()
        try:
            return find_modules(link, self.cell.clock, ids=ids)
        finally:
            link.close()

    def _give_power(self, *, leave_on: bool) -> bool:
        """Switch the gripper's power on; return whether it was off."""
        cell = self.playground
        self.take_right()
        bit = cell.profile.outputs.gripper_power
        if cell.arm.arm.read_output(bit):
            return False
        cell.set_output(bit, is_on=True)
        if not leave_on:
            self._put_back.append(lambda: cell.set_output(bit, is_on=False))
        return True

    def reach_display(self) -> str:
        """Reach the television and leave it as it is; return its identity.

        Raises:
            DeviceError: It does not answer.
        """
        display = self.playground.display
        identity = display.open()
        self._put_back.append(display.close)
        return identity

    def put_back(self) -> list[str]:
        """Put everything back, the last first; return what failed meanwhile."""
        failures: list[str] = []
        if isinstance(self.cell, RobotCell):
            self._put_back.append(self.cell.close_cameras)
        while self._put_back:
            try:
                self._put_back.pop()()
            except CellError as error:
                failures.append(str(error))
        self._has_controller = self._has_right = self._has_gripper = False
        return failures

    def stop_everything(self) -> list[str]:
        """Stop the arm and the fingers that are up now; return what failed meanwhile."""
        failures: list[str] = []
        stops = [self.cell.arm.arm.stop] if self._has_controller else []
        stops += [self.gripper.stop] if self._has_gripper else []
        for stop in stops:
            try:
                stop()
            except CellError as error:
                failures.append(str(error))
        return failures

    def _later(self, put_back: PutBack | None) -> None:
        if put_back is not None:
            self._put_back.append(put_back)
