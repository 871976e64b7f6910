"""What hangs on the registers beside the motors: two kinds of lamps, the gripper's valve."""

from __future__ import annotations

from cell.clock import Clock
from cell.drivers.ibm7545.bus import RegisterBus
from cell.drivers.ibm7545.registers import GripperBit, Lamp, Register
from cell.drivers.ibm7545.settings import ScaraSettings
from cell.errors import DeviceError, DeviceTimeout

HALOGEN = 0
"""Output of the halogen lamp beside the camera."""
FLUORESCENT = 1
"""Output of the three fluorescent lamps."""
GRIPPER = 8
"""Output of the gripper's valve: on is closed."""

NOT_WORKED = (
    "the gripper's valve was not worked since this program began, and no register tells how "
    "it stands"
)

_LAMPS = {HALOGEN: Lamp.HALOGEN, FLUORESCENT: Lamp.FLUORESCENT}


class Outputs:
    """Lamps and valve, by the numbers of outputs.

    Args:
        bus: The registers.
        clock: Time of the wait for the valve.
        settings: Deadline and pause of that wait.
    """

    def __init__(self, bus: RegisterBus, clock: Clock, settings: ScaraSettings) -> None:
        self._bus = bus
        self._clock = clock
        self._settings = settings
        # Its register never tells how the valve stands.
        self._is_closed: bool | None = None

    @property
    def is_closed(self) -> bool | None:
        """Whether the gripper was closed last, rather than opened; None if it is not known."""
        return self._is_closed

    def forget(self) -> None:
        """Forget how the valve was worked: the slave was restarted."""
        self._is_closed = None

    def switch(self, bit: int, *, is_on: bool) -> None:
        """Switch an output.

        Raises:
            DeviceError: There is no such output.
            DeviceTimeout: The slave does not work the valve, or the bridge is silent.
        """
        if bit == GRIPPER:
            self.work_gripper(is_closing=is_on)
            return
        lamp = self._lamp(bit)
        now = self._bus.read(Register.LAMPS)[0]
        self._bus.write(Register.LAMPS, (now | lamp if is_on else now & ~lamp,))

    def is_on(self, bit: int) -> bool:
        """Return whether an output is on.

        Raises:
            DeviceError: There is no such output, or the valve was not worked yet.
            DeviceTimeout: The bridge is silent.
        """
        if bit == GRIPPER:
            self._bus.read(Register.GRIPPER)
            if self._is_closed is None:
                raise DeviceError(self._bus.device, NOT_WORKED, hint="work the gripper once")
            return self._is_closed
        return bool(self._bus.read(Register.LAMPS)[0] & self._lamp(bit))

    def work_gripper(self, *, is_closing: bool) -> None:
        """Open or close the gripper and return when the slave has done it.

        Raises:
            DeviceTimeout: The slave does not clear the register in time.
        """
        word = GripperBit.CLOSE if is_closing else GripperBit.OPEN
        self._bus.write(Register.GRIPPER, (word,))
        deadline_s = self._clock.now_s() + self._settings.gripper_timeout_s
        while self._bus.read(Register.GRIPPER)[0]:
            if self._clock.now_s() >= deadline_s:
                self._bus.write(Register.GRIPPER, (0,))
                raise DeviceTimeout(
                    self._bus.device,
                    f"the gripper was not worked within {self._settings.gripper_timeout_s:g} s",
                    hint="the slave does it only between moves and without errors; "
                    "reset the alarm and see that no move is under way",
                )
            self._clock.sleep(self._settings.poll_s)
        self._is_closed = is_closing

    def _lamp(self, bit: int) -> int:
        if bit not in _LAMPS:
            raise DeviceError(
                self._bus.device,
                f"there is no output {bit}",
                hint=f"use {HALOGEN} (halogen), {FLUORESCENT} (fluorescent) or {GRIPPER} (gripper)",
            )
        return _LAMPS[bit]
