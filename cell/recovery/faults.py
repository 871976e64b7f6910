"""The words for faults: devices, faults, and what is done about them."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Literal

DeviceName = Literal["arm", "gripper", "display", "screen", "lights", "camera", "ledger"]


class Fault(enum.Enum):
    """What can be wrong with a device, as the table of faults names it."""

    SILENCE = "silence"
    LOST_REPLY = "lost reply"
    GARBAGE = "garbage"
    CHECKSUM = "wrong checksum"
    HALF = "half a frame"
    LATE = "late"
    SLOW = "slow reply"
    REFUSAL = "refusal"
    ALARM = "alarm"
    POWER_LOSS = "power loss"
    UNPLUGGED = "unplugged"
    REPLUGGED = "unplugged and replugged"
    EMERGENCY_STOP = "emergency stop"
    STOP_BUTTON = "stop button"
    TEACH = "key to TEACH"
    RIGHT_TAKEN = "right taken"
    ERROR_LATCHED = "error latched"
    BLOCKED = "blocked"
    BLOCK_LOST = "block lost"
    ASLEEP = "asleep"
    WRONG_INPUT = "wrong input"
    NO_PAGE = "no page connected"
    HIDDEN = "page hidden"
    WRONG_SIZE = "page of a wrong size"
    PAINTED_LATE = "painted late"
    TORN = "torn picture"
    FROZEN = "frozen picture"
    DISK = "disk error"
    STOPPED = "stop asked for"


class Deed(enum.Enum):
    """What the cell does about a fault."""

    NOTHING = "waits"
    RETRY = "retry"
    RECOVER = "recover"
    HOLD = "hold"
    STOP = "stop"


@dataclass(frozen=True, slots=True)
class Rule:
    """One row of the table of faults.

    Attributes:
        device: Whose fault it is.
        fault: What is wrong.
        when: For how long, or while what.
        deed: What the cell does in the end.
        reply: What the client gets: `-` is the ordinary reply, else its beginning, `...`
            standing for any words.
        log: The operator's line, `...` standing for any words; `-` is none.
    """

    device: DeviceName
    fault: Fault
    when: str
    deed: Deed
    reply: str
    log: str
