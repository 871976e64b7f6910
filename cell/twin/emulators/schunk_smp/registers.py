"""The configuration of an emulated module: registers, users, unit system."""

from __future__ import annotations

from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.tables import (
    LENGTH_REGISTERS,
    MM_PER_UNIT,
    UNIT_MILLIMETRE,
    Code,
    Register,
    UserLevel,
)
from cell.twin.emulators.schunk_smp.settings import SchunkModuleSettings

_READ_ONLY = frozenset({Register.SERIAL_NUMBER, Register.ORDER_NUMBER})
_RS232 = 1


class Registers:
    """Keeps values in millimetres, tells them in the unit system; survives power loss."""

    def __init__(self, settings: SchunkModuleSettings) -> None:
        self._passwords = settings.passwords
        self._values: dict[int, float] = {
            Register.MODULE_ID: settings.module_id,
            Register.GROUP_ID: 1,
            Register.BAUD: 38400,
            Register.CAN_BAUD: 500,
            Register.COMMUNICATION_MODE: _RS232,
            Register.UNIT_SYSTEM: UNIT_MILLIMETRE,
            Register.SOFT_LIMIT_HIGH: settings.stroke_mm,
            Register.SOFT_LIMIT_LOW: 0.0,
            Register.MAX_VELOCITY: settings.max_velocity_mm_s,
            Register.MAX_ACCELERATION: settings.max_acceleration_mm_s2,
            Register.MAX_CURRENT: settings.max_current_a,
            Register.NOMINAL_CURRENT: settings.nominal_current_a,
            Register.MAX_JERK: settings.max_jerk_mm_s3,
            Register.REFERENCE_OFFSET: 0.0,
            Register.SERIAL_NUMBER: settings.serial_number,
            Register.ORDER_NUMBER: settings.order_number,
            Register.GEAR_RATIO: 1.0,
        }
        self.level = UserLevel.USER

    @property
    def mm_per_unit(self) -> float:
        """Millimetres in the unit of length in force."""
        return MM_PER_UNIT[int(self._values[Register.UNIT_SYSTEM])]

    def __getitem__(self, register: Register) -> float:
        """Return a register's value, lengths in millimetres."""
        return self._values[register]

    def read(self, register: int) -> float:
        """Return a register's value as it is told on the line.

        Raises:
            MalformedMessage: There is no such register.
        """
        self._require(register)
        value = self._values[register]
        return value / self.mm_per_unit if register in LENGTH_REGISTERS else value

    def write(self, register: int, value: float) -> None:
        """Set a register from a value as it is told on the line.

        Raises:
            MalformedMessage: There is no such register, the user may not write it, or
                the value is not allowed.
        """
        self._require(register)
        if register in _READ_ONLY or self.level < UserLevel.PROFI:
            raise MalformedMessage("the user may not write this", code=Code.NO_RIGHTS)
        if not self._is_allowed(register, value):
            raise MalformedMessage(f"{value} is not allowed", code=Code.WRONG_PARAMETER)
        is_length = register in LENGTH_REGISTERS
        self._values[register] = value * self.mm_per_unit if is_length else value

    def put(self, register: Register, value: float) -> None:
        """Set a register whoever may write it, lengths in millimetres."""
        self._values[register] = value

    def log_in(self, password: str) -> UserLevel:
        """Change the user level; an unknown password gives the lowest."""
        self.level = self._passwords.get(password, UserLevel.USER)
        return self.level

    def _is_allowed(self, register: int, value: float) -> bool:
        if register == Register.UNIT_SYSTEM:
            # Angles and whole-number units make no sense for these fingers.
            return value in MM_PER_UNIT
        if register == Register.MODULE_ID:
            return 1 <= value <= 255
        return value == value and abs(value) != float("inf")

    def _require(self, register: int) -> None:
        if register not in self._values:
            raise MalformedMessage("there is no such register", code=Code.WRONG_PARAMETER)
