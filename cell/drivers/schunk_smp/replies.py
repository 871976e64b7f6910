"""What a module answers and says unasked, as records.

Lengths are in the module's unit system; the names say millimetres because the
driver insists on that one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from cell.drivers.schunk_smp.tables import Command


@dataclass(frozen=True, slots=True)
class Accepted:
    """The command is accepted."""

    command: Command


@dataclass(frozen=True, slots=True)
class MoveAccepted:
    """A move is accepted and will take `duration_s` if nothing comes in between."""

    command: Command
    duration_s: float


@dataclass(frozen=True, slots=True)
class Refused:
    """The command is refused."""

    command: int
    code: int


@dataclass(frozen=True, slots=True)
class StateReply:
    """The module's state; what was not asked for is None."""

    position_mm: float | None
    velocity_mm_s: float | None
    current_a: float | None
    status: int
    error: int


@dataclass(frozen=True, slots=True)
class RegisterValue:
    """The value of a register of the configuration."""

    register: int
    value: float


@dataclass(frozen=True, slots=True)
class RegisterWritten:
    """A register of the configuration was written."""

    register: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Identity:
    """Who the module is."""

    kind: str
    order: int
    firmware: int
    protocol: int
    hardware: int
    date: str
    rest: bytes = bytes(5)
    """Five bytes of unknown meaning."""


@dataclass(frozen=True, slots=True)
class DetailedError:
    """More about the latched error; `kind` is ERROR, WARNING or INFO."""

    kind: Command
    code: int
    value: float


@dataclass(frozen=True, slots=True)
class UserChanged:
    """The user level that is now in force."""

    level: int


@dataclass(frozen=True, slots=True)
class ImpulsesSwitched:
    """Whether spontaneous messages are now on."""

    are_on: bool


@dataclass(frozen=True, slots=True)
class KnownValues:
    """The known values of the link self-test."""

    block: bytes


@dataclass(frozen=True, slots=True)
class KnownValuesChecked:
    """The module received the known values unharmed if `result` is 0."""

    result: int


@dataclass(frozen=True, slots=True)
class MoveBlocked:
    """Unasked: the fingers stand still before their target."""

    position_mm: float


@dataclass(frozen=True, slots=True)
class PositionReached:
    """Unasked: the fingers stand at their target; some models add status and error."""

    position_mm: float
    status: int | None = None
    error: int | None = None


@dataclass(frozen=True, slots=True)
class Info:
    """Unasked: something to know, such as a boot or that no error is left."""

    code: int


@dataclass(frozen=True, slots=True)
class ErrorReport:
    """Unasked, repeated until acknowledged: an error; the motor is off."""

    code: int


@dataclass(frozen=True, slots=True)
class WarningReport:
    """Unasked, repeated while it lasts: a warning."""

    code: int


Impulse: TypeAlias = MoveBlocked | PositionReached | Info | ErrorReport | WarningReport
Answer: TypeAlias = (
    Accepted
    | MoveAccepted
    | Refused
    | StateReply
    | RegisterValue
    | RegisterWritten
    | Identity
    | DetailedError
    | UserChanged
    | ImpulsesSwitched
    | KnownValues
    | KnownValuesChecked
)
Reply: TypeAlias = Answer | Impulse
IMPULSES = (MoveBlocked, PositionReached, Info, ErrorReport, WarningReport)
"""The types of what a module says unasked."""
