"""Single operations by hand: only the devices that one needs are brought up, then put back.

Motion still goes through the guarded arm of the cell. Reading, alarms, stops and outputs need
the controller of the arm but not its servos; what was found on stays on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Final

from cell.clock import Clock
from cell.drivers.melfa_r3.driver import MelfaArm
from cell.drivers.melfa_r3.settings import ArmSettings
from cell.drivers.schunk_smp.scan import FoundModule, find_modules
from cell.errors import CellError
from cell.links.base import Link
from cell.robot_cell import RobotCell

_CLIENT: Final = "BYHAND"
_BOOT_S: Final = 2.0
"""How long a module may take from power on until it answers (assumed)."""


class ByHand:
    """A cell of which only single devices are up.

    Args:
        cell: The cell, closed.

    Attributes:
        cell: The cell.
    """

    def __init__(self, cell: RobotCell) -> None:
        self.cell = cell
        self._put_back: list[Callable[[], None]] = []
        self._has_controller = False
        self._has_right = False
        self._has_gripper = False

    @property
    def clock(self) -> Clock:
        """The clock of the cell."""
        return self.cell.clock

    def reach_controller(self) -> None:
        """Open a session with the arm's controller; servos and alarms stay as they are.

        Raises:
            DeviceError: The controller does not answer or refuses.
        """
        if self._has_controller:
            return
        arm = self.cell.arm.arm
        if isinstance(arm, MelfaArm):
            arm.panel.open_session(_CLIENT)
            self._put_back.append(arm.panel.close_session)
            self._has_controller = True
        else:
            self.bring_up_arm()

    def take_right(self) -> None:
        """Take the right to operate the controller, which outputs need.

        Raises:
            DeviceError: The controller does not answer, or somebody else has the right.
        """
        self.reach_controller()
        arm = self.cell.arm.arm
        if isinstance(arm, MelfaArm) and not self._has_right:
            arm.panel.take_right()
            self._put_back.append(arm.panel.give_right_back)
            arm.panel.reset_program()
            arm.panel.load_program(ArmSettings.from_profile(self.cell.profile.arm).program)
            self._has_right = True

    def bring_up_arm(self, *, leave_on: bool = False) -> str:
        """Bring the arm up with its servos on; return its identity.

        Args:
            leave_on: Whether the servos stay on afterwards.

        Raises:
            DeviceError: It does not come up.
        """
        identity = self.cell.arm.open()
        if not leave_on:
            self._put_back.append(self.cell.arm.close)
        self._has_controller = self._has_right = True
        return identity

    def bring_up_gripper(self, *, may_move: bool = True, leave_on: bool = False) -> str:
        """Give the gripper power and bring it up; return its identity.

        Args:
            may_move: Whether it may look for its zero, which moves the fingers.
            leave_on: Whether it keeps its power afterwards.

        Raises:
            DeviceError: It does not come up.
        """
        self._give_power(leave_on=leave_on)
        self._put_back.append(self.cell.gripper.close)
        self._has_gripper = True
        return self.cell.gripper.open(may_move=may_move)

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
        self.take_right()
        bit = self.cell.profile.outputs.gripper_power
        if self.cell.arm.arm.read_output(bit):
            return False
        self.cell.set_output(bit, is_on=True)
        if not leave_on:
            self._put_back.append(lambda: self.cell.set_output(bit, is_on=False))
        return True

    def reach_display(self) -> str:
        """Reach the television and leave it as it is; return its identity.

        Raises:
            DeviceError: It does not answer.
        """
        identity = self.cell.display.open()
        self._put_back.append(self.cell.display.close)
        return identity

    def put_back(self) -> list[str]:
        """Put everything back, the last first; return what failed meanwhile."""
        failures: list[str] = []
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
        stops += [self.cell.gripper.stop] if self._has_gripper else []
        for stop in stops:
            try:
                stop()
            except CellError as error:
                failures.append(str(error))
        return failures
