"""The table of faults: every device and fault, and what the cell does about it.

`docs/reference/faults.md` shows the same rows to people; a test reads both. Drivers
repeat requests; what reaches the cell all the same is looked up here.
"""

from __future__ import annotations

from cell.recovery.faults import Deed, DeviceName, Fault, Rule

_ASKED = "{}: asked again: ..."


def _repeated(device: DeviceName, *faults: Fault) -> tuple[Rule, ...]:
    """Return the rows of faults that one repeated request gets over."""
    asked = _ASKED.format("arm" if device == "lights" else device)
    return tuple(Rule(device, fault, "once", Deed.RETRY, "-", asked) for fault in faults)


_ONE_REPLY = (Fault.LOST_REPLY, Fault.GARBAGE, Fault.HALF, Fault.LATE)

POLICY: tuple[Rule, ...] = (
    *_repeated("arm", *_ONE_REPLY),
    Rule("arm", Fault.SLOW, "once", Deed.NOTHING, "-", "-"),
    Rule("arm", Fault.REPLUGGED, "under 0.5 s", Deed.RETRY, "-", "arm: asked again: ..."),
    Rule("arm", Fault.SILENCE, "lasting", Deed.HOLD, "ERROR 'arm: ...", "held: arm: ..."),
    Rule(
        "arm", Fault.UNPLUGGED, "lasting", Deed.HOLD,
        "ERROR 'The connection to a device failed'", "held: arm: ...",
    ),
    Rule("arm", Fault.REFUSAL, "any", Deed.HOLD, "ERROR 'arm: ...", "held: arm: ..."),
    Rule("arm", Fault.ALARM, "in motion", Deed.HOLD, "ERROR 'arm: ...", "held: arm: ..."),
    Rule("arm", Fault.POWER_LOSS, "any", Deed.STOP, "ERROR 'arm: ...", "held: arm: ..."),
    Rule("arm", Fault.EMERGENCY_STOP, "in motion", Deed.STOP, "ERROR 'arm: ...", "held: arm: ..."),
    Rule("arm", Fault.STOP_BUTTON, "in motion", Deed.STOP, "ERROR 'arm: ...", "held: arm: ..."),
    Rule("arm", Fault.TEACH, "any", Deed.STOP, "ERROR 'arm: ...", "held: arm: ..."),
    Rule("arm", Fault.RIGHT_TAKEN, "any", Deed.STOP, "ERROR 'arm: ...", "held: arm: ..."),
    Rule("arm", Fault.STOPPED, "any", Deed.HOLD, "ERROR 'The cell was stopped'", "held: ..."),
    Rule(
        "arm", Fault.SILENCE, "while opening", Deed.HOLD,
        "ERROR 'arm: ...", "...END_TASK_SETUP...arm: ...",
    ),
    *_repeated("gripper", *_ONE_REPLY, Fault.CHECKSUM),
    Rule("gripper", Fault.SLOW, "once", Deed.NOTHING, "-", "-"),
    Rule("gripper", Fault.REPLUGGED, "under 0.5 s", Deed.RETRY, "-", "gripper: asked again: ..."),
    Rule(
        "gripper", Fault.SILENCE, "lasting", Deed.HOLD,
        "ERROR 'gripper: ...", "held: gripper: ...",
    ),
    Rule(
        "gripper", Fault.SILENCE, "while opening", Deed.HOLD,
        "ERROR 'gripper: ...", "...END_TASK_SETUP...gripper: ...",
    ),
    Rule(
        "gripper", Fault.UNPLUGGED, "lasting", Deed.HOLD,
        "ERROR 'The connection to a device failed'", "held: gripper: ...",
    ),
    Rule(
        "gripper", Fault.ERROR_LATCHED, "its cause is gone", Deed.RECOVER,
        "-", "gripper: recovered: ...",
    ),
    Rule(
        "gripper", Fault.ERROR_LATCHED, "its cause stays", Deed.HOLD,
        "ERROR 'gripper: ...", "held: gripper: ...",
    ),
    Rule(
        "gripper", Fault.POWER_LOSS, "back at once, fingers empty", Deed.RECOVER,
        "-", "gripper: recovered: ...",
    ),
    Rule(
        "gripper", Fault.POWER_LOSS, "back at once, holding a block", Deed.HOLD,
        "ERROR 'gripper: ...", "held: gripper: ...",
    ),
    Rule(
        "gripper", Fault.POWER_LOSS, "lasting", Deed.HOLD,
        "ERROR 'gripper: ...", "held: gripper: ...",
    ),
    Rule("gripper", Fault.BLOCKED, "any", Deed.HOLD, "ERROR 'gripper: ...", "held: gripper: ..."),
    Rule(
        "gripper", Fault.BLOCK_LOST, "on the way", Deed.HOLD,
        "ERROR 'slot ...: lost ...", "held: gripper: slot ...: lost ...",
    ),
    *_repeated("display", *_ONE_REPLY),
    Rule("display", Fault.SLOW, "once", Deed.NOTHING, "-", "-"),
    Rule("display", Fault.REPLUGGED, "under 0.5 s", Deed.RETRY, "-", "display: asked again: ..."),
    Rule(
        "display", Fault.SILENCE, "lasting", Deed.HOLD,
        "ERROR 'display: ...", "held: display: ...",
    ),
    Rule(
        "display", Fault.SILENCE, "while opening", Deed.HOLD,
        "ERROR 'display: ...", "...END_TASK_SETUP...display: ...",
    ),
    Rule(
        "display", Fault.UNPLUGGED, "lasting", Deed.HOLD,
        "ERROR 'The connection to a device failed'", "held: display: ...",
    ),
    Rule("display", Fault.ASLEEP, "any", Deed.RECOVER, "-", "display: recovered: ..."),
    Rule("display", Fault.WRONG_INPUT, "any", Deed.RECOVER, "-", "display: recovered: ..."),
    Rule(
        "display", Fault.POWER_LOSS, "any", Deed.HOLD,
        "ERROR 'display: ...", "held: display: ...",
    ),
    Rule("screen", Fault.NO_PAGE, "any", Deed.HOLD, "ERROR 'screen: ...", "held: screen: ..."),
    Rule("screen", Fault.HIDDEN, "any", Deed.HOLD, "ERROR 'screen: ...", "held: screen: ..."),
    Rule("screen", Fault.WRONG_SIZE, "any", Deed.HOLD, "ERROR 'screen: ...", "held: screen: ..."),
    Rule("screen", Fault.PAINTED_LATE, "once", Deed.RECOVER, "-", "screen: recovered: ..."),
    Rule(
        "screen", Fault.PAINTED_LATE, "lasting", Deed.HOLD,
        "ERROR 'screen: ...", "held: screen: ...",
    ),
    *_repeated("lights", Fault.LOST_REPLY, Fault.GARBAGE),
    Rule(
        "lights", Fault.SILENCE, "lasting", Deed.HOLD,
        "ERROR 'arm: ...", "held: lights: arm: ...",
    ),
    Rule("camera", Fault.TORN, "once", Deed.RECOVER, "-", "camera ...: recovered: ..."),
    Rule("camera", Fault.FROZEN, "any", Deed.RECOVER, "-", "camera ...: recovered: ..."),
    Rule(
        "camera", Fault.REPLUGGED, "any", Deed.RECOVER, "-", "camera ...: recovered: ...",
    ),
    Rule(
        "camera", Fault.SILENCE, "lasting", Deed.HOLD,
        "ERROR 'camera ...", "held: camera ...",
    ),
    Rule(
        "camera", Fault.UNPLUGGED, "lasting", Deed.HOLD,
        "ERROR 'camera ...", "held: camera ...",
    ),
    Rule(
        "ledger", Fault.DISK, "any", Deed.STOP,
        "ERROR 'The ledger of blocks cannot be used'", "held: ledger: ...",
    ),
)  # fmt: skip
"""Every row; of two with the same device and fault the last one is what reaches the cell."""

_LAST = {(rule.device, rule.fault): rule for rule in POLICY}


def deed_for(device: DeviceName, fault: Fault) -> Deed:
    """Return what the cell does about a fault that retrying and recovering did not end."""
    rule = _LAST.get((device, fault))
    return Deed.STOP if rule is not None and rule.deed is Deed.STOP else Deed.HOLD


def may_recover(device: DeviceName) -> bool:
    """Return whether the cell tries to bring a device back before it gives up."""
    return any(rule.device == device and rule.deed is Deed.RECOVER for rule in POLICY)
