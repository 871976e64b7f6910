"""What a master asks of a module, as records.

Lengths are in the module's unit system; the names say millimetres because the
driver insists on that one. Values left out (None) are the module's own targets.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from cell.drivers.schunk_smp.tables import Command, StateMode


@dataclass(frozen=True, slots=True)
class Reference:
    """Find the zero position."""


@dataclass(frozen=True, slots=True)
class Stop:
    """Stop the motion under way."""


@dataclass(frozen=True, slots=True)
class EmergencyStop:
    """Stop at once and go into the error state."""


@dataclass(frozen=True, slots=True)
class Acknowledge:
    """Clear latched errors whose cause is gone."""


@dataclass(frozen=True, slots=True)
class GetDetailedError:
    """Ask for class, code and value of the latched error."""


@dataclass(frozen=True, slots=True)
class Reboot:
    """Start the module anew."""


@dataclass(frozen=True, slots=True)
class ToggleImpulses:
    """Turn spontaneous messages on if they are off, and off if they are on."""


@dataclass(frozen=True, slots=True)
class SendTestValues:
    """Ask for known values, to test the way from the module."""


@dataclass(frozen=True, slots=True)
class CheckTestValues:
    """Send known values, to test the way to the module."""

    block: bytes


@dataclass(frozen=True, slots=True)
class MovePosition:
    """Move to a position, or by a distance when `is_relative`."""

    position_mm: float
    velocity_mm_s: float | None = None
    acceleration_mm_s2: float | None = None
    current_a: float | None = None
    jerk_mm_s3: float | None = None
    is_relative: bool = False


@dataclass(frozen=True, slots=True)
class MovePositionTimed:
    """Move to a position (or by a distance) within a time."""

    position_mm: float
    velocity_mm_s: float
    acceleration_mm_s2: float
    current_a: float
    time_s: float
    is_relative: bool = False


@dataclass(frozen=True, slots=True)
class MoveCurrent:
    """Drive the motor with a constant current."""

    current_a: float


@dataclass(frozen=True, slots=True)
class MoveVelocity:
    """Move at a constant velocity."""

    velocity_mm_s: float
    current_a: float | None = None


@dataclass(frozen=True, slots=True)
class MoveGrip:
    """Move with rising current until something blocks the fingers."""

    current_a: float


@dataclass(frozen=True, slots=True)
class SetTarget:
    """Set what moves use that do not say it: `target` is one of the SET_TARGET commands."""

    target: Command
    value: float


@dataclass(frozen=True, slots=True)
class GetState:
    """Ask for the state once, or every `period_s` seconds when that is not zero.

    Without both values the module sends everything once.
    """

    period_s: float | None = None
    mode: StateMode | None = None


@dataclass(frozen=True, slots=True)
class GetConfig:
    """Ask for a register, or for the module's identity when `register` is None."""

    register: int | None = None


@dataclass(frozen=True, slots=True)
class SetConfig:
    """Write a register."""

    register: int
    value: float


@dataclass(frozen=True, slots=True)
class ChangeUser:
    """Log in as the user whom the password belongs to; an empty one logs out."""

    password: str = ""


CommandRecord: TypeAlias = (
    Reference
    | Stop
    | EmergencyStop
    | Acknowledge
    | GetDetailedError
    | Reboot
    | ToggleImpulses
    | SendTestValues
    | CheckTestValues
    | MovePosition
    | MovePositionTimed
    | MoveCurrent
    | MoveVelocity
    | MoveGrip
    | SetTarget
    | GetState
    | GetConfig
    | SetConfig
    | ChangeUser
)
