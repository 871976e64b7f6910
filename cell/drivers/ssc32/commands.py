"""What can be said to an SSC-32, one record a command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class ServoTarget:
    """One servo of a move.

    Attributes:
        channel: 0 to 31.
        pulse_us: Pulse width, 500 to 2500.
        speed_us_s: Greatest speed; 0 for full speed.
    """

    channel: int
    pulse_us: int
    speed_us_s: int = 0


@dataclass(frozen=True, slots=True)
class Move:
    """Servos that start together and arrive together; there is no reply.

    Attributes:
        targets: At least one.
        time_ms: Least time of the whole move; 0 for none.
    """

    targets: tuple[ServoTarget, ...]
    time_ms: int = 0


@dataclass(frozen=True, slots=True)
class SetOffsets:
    """Shift the pulses of channels by -100 to 100 us; there is no reply.

    Attributes:
        offsets: Pairs of channel and shift in us.
    """

    offsets: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class SetOutputs:
    """Make channels digital outputs, high or low; there is no reply.

    Attributes:
        levels: Pairs of channel and whether it is high.
    """

    levels: tuple[tuple[int, bool], ...]


@dataclass(frozen=True, slots=True)
class SetBanks:
    """Put bytes out on banks of eight channels; there is no reply.

    Attributes:
        values: Pairs of bank, 0 to 3, and byte.
    """

    values: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class QueryMoving:
    """Ask whether the last move is over; one byte, `.` or `+`, comes back."""


@dataclass(frozen=True, slots=True)
class QueryPulses:
    """Ask for commanded pulse widths; one byte each, in units of 10 us, comes back.

    Attributes:
        channels: At least one.
    """

    channels: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class QueryVersion:
    """Ask for the firmware's version; a line comes back."""


@dataclass(frozen=True, slots=True)
class ReadInputs:
    """Ask for digital inputs; `0` or `1` each comes back.

    Attributes:
        inputs: Pairs of letter, A to F, and whether the latch is asked for.
    """

    inputs: tuple[tuple[str, bool], ...]


@dataclass(frozen=True, slots=True)
class ReadAnalogues:
    """Ask for voltages; one byte each, 51.2 counts a volt, comes back.

    Attributes:
        letters: A to H.
    """

    letters: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StopServo:
    """Stop a servo where it is commanded at the moment; there is no reply.

    Only an SSC-32U and late firmware know this.
    """

    channel: int


Command: TypeAlias = (
    Move
    | SetOffsets
    | SetOutputs
    | SetBanks
    | QueryMoving
    | QueryPulses
    | QueryVersion
    | ReadInputs
    | ReadAnalogues
    | StopServo
)
