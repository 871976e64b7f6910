"""Everything on, everything off: the order in which a cell's devices come up and go."""

from __future__ import annotations

from collections.abc import Callable

from cell.clock import Clock
from cell.devices.display import Display
from cell.devices.gripper import Gripper
from cell.errors import CellError, LedgerError
from cell.events import DeviceClosed, DeviceFailed, DeviceOpened, EventBus
from cell.motion.guarded import GuardedArm
from cell.optics import CellOptics
from cell.profile import Profile
from cell.recovery.opening import OpeningFailed, Step, bring_up
from cell.stop import StopToken


class CellPower:
    """Brings the devices of a cell up and switches them off.

    Args:
        profile: The cell's profile.
        arm: The arm, whose controller switches lights and the gripper's power.
        gripper: The gripper.
        display: The television.
        optics: Lights and cameras.
        may_hold_block: Says whether a block may be between the fingers.
        events: Told what came up, what failed, and that everything is off.
        clock: Decides whether devices come up at the same time.
        stop: Ends an opening.
    """

    def __init__(
        self,
        profile: Profile,
        *,
        arm: GuardedArm,
        gripper: Gripper,
        display: Display,
        optics: CellOptics,
        may_hold_block: Callable[[], bool],
        events: EventBus,
        clock: Clock,
        stop: StopToken,
    ) -> None:
        self._outputs = profile.outputs
        self._input = profile.display.input
        self._has_gripper = profile.arm.enabled and profile.gripper.enabled
        self._arm = arm
        self._gripper = gripper
        self._display = display
        self._optics = optics
        self._may_hold_block = may_hold_block
        self._events = events
        self._clock = clock
        self._stop = stop

    def switch_on(self) -> None:
        """Bring every device up: arm, gripper with its power, display, lights.

        What does not need each other comes up at the same time, where the clock allows it,
        and all failures are told at once.

        Raises:
            DeviceError: A device does not come up; what was opened is closed again.
        """
        identities: dict[str, str] = {}
        try:
            bring_up((self._arm_chain(identities), self._display_chain(identities)), self._clock)
            for device in ("arm", "gripper", "display"):
                self._events.emit(DeviceOpened(device, identities[device]))
            self._optics.switch_lights(is_on=True)
        except CellError as error:
            self._tell_failures(error)
            self.switch_off()
            raise

    def switch_off(self) -> None:
        """Close all devices; one that fails does not keep the others on.

        The arm stays where it is, and the gripper keeps what it holds: fingers that may hold
        a block keep their power, because without it they forget their zero.
        """
        keeps_power = self._may_keep_block()
        for device, close in (
            ("display", self._display.switch_off),
            ("display", self._display.close),
            ("gripper", self._gripper.close),
            ("lights", lambda: self._optics.set_output(self._outputs.lights, is_on=False)),
            ("gripper", lambda: self._power_gripper(is_on=keeps_power)),
            ("arm", self._arm.close),
            ("cameras", self._optics.close_cameras),
        ):
            try:
                close()
            except CellError as error:
                self._events.emit(DeviceFailed(device, str(error)))
        self._events.emit(DeviceClosed("cell"))

    def _arm_chain(self, identities: dict[str, str]) -> list[Step]:
        """Return how arm and gripper come up: the gripper has its power from the arm."""

        def power_gripper() -> None:
            if self._has_gripper:
                self._power_gripper(is_on=True)

        return [
            self._step("arm", self._arm.open, identities),
            Step("arm", power_gripper),
            self._step("gripper", self._gripper.open, identities),
        ]

    def _display_chain(self, identities: dict[str, str]) -> list[Step]:
        return [
            self._step("display", self._display.open, identities),
            Step("display", self._display.switch_on),
            Step("display", lambda: self._display.select_input(self._input)),
        ]

    def _step(self, device: str, bring: Callable[[], str], identities: dict[str, str]) -> Step:
        def run() -> None:
            self._stop.check()
            identities[device] = bring()

        return Step(device, run)

    def _power_gripper(self, *, is_on: bool) -> None:
        self._optics.set_output(self._outputs.gripper_power, is_on=is_on)

    def _may_keep_block(self) -> bool:
        try:
            return self._may_hold_block()
        except LedgerError:
            # Nobody knows: power does no harm.
            return True

    def _tell_failures(self, error: CellError) -> None:
        if isinstance(error, OpeningFailed):
            for failure in error.failures:
                self._events.emit(DeviceFailed(failure.device, str(failure.error)))
        else:
            self._events.emit(DeviceFailed("cell", str(error)))
