"""What the emulated controller is in: session, right, servos, alarm, switches, signals."""

from __future__ import annotations

from collections import deque
from typing import Literal

from cell.drivers.melfa_r3 import tables
from cell.drivers.melfa_r3.records import StopSources
from cell.drivers.melfa_r3.tables import Run, Stop

Holder = Literal["nobody", "host", "panel"]
StopButton = Literal["panel", "pendant", "external"]
"""Where an emergency stop can be pressed."""

HISTORY = 32
"""How many alarms the controller remembers."""

_EMERGENCIES: dict[StopButton, tuple[int, int]] = {
    "panel": (0x2, tables.EMERGENCY_PANEL),
    "pendant": (0x4, tables.EMERGENCY_PENDANT),
    "external": (0x1, tables.EMERGENCY_EXTERNAL),
}
"""Bit of the emergency sources in STPSIG, and the alarm."""
_PENDANT_STOPS = 0x1
_INPUT_STOPS = 0x4
_LOCKED = int(Run.MACHINE_LOCK)
_SERVO_ON = int(Run.SERVO_ON)
_RUNNING = int(Run.RUNNING)
_TEACH = int(Run.TEACH)
_ENABLED = int(Run.OPERATION_ENABLED)
_REPEAT = int(Run.REPEAT)
_EMERGENCY = int(Stop.EMERGENCY)
_IDLE = int(Stop.STOP | Stop.WAIT)


class ControllerState:
    """Everything that is on or off, apart from motion.

    Attributes:
        is_open: Whether a session is open.
        holder: Who holds the operation right.
        is_automatic: Whether the key switch is at AUTO.
        pressed: The emergency stops that are pressed.
        is_pendant_enabled: Whether the teach pendant has the arm.
        is_locked: Whether machine lock is on: programs run, the arm stays where it is.
        is_stop_input_on: Whether the stop input is on: no motion goes on.
        dead_outputs: Outputs that stay off whatever is asked.
        alarm: Number of the active alarm, 0 for none.
        history: Numbers of past alarms, the latest first.
        servo_ready_s: When the servos are (or were) on, None while off.
        override_percent: The panel's override.
        is_cyclic: Whether the slot runs one cycle instead of repeating.
        program: Program selected in the slot, empty for none.
        outputs: Numbers of the outputs that are on.
        inputs: Numbers of the inputs that are on.
        open_hands: Hands that are open.
    """

    def __init__(self, override_percent: int) -> None:
        self.is_open = False
        self.holder: Holder = "nobody"
        self.is_automatic = True
        self.pressed: set[StopButton] = set()
        self.is_pendant_enabled = False
        self.is_locked = False
        self.is_stop_input_on = False
        self.dead_outputs: set[int] = set()
        self.alarm = 0
        self.history: deque[int] = deque(maxlen=HISTORY)
        self.servo_ready_s: float | None = None
        self.override_percent = override_percent
        self.is_cyclic = False
        self.program = ""
        self.outputs: set[int] = set()
        self.inputs: set[int] = set()
        self.open_hands: set[int] = set()

    @property
    def is_emergency_pressed(self) -> bool:
        """Whether any emergency stop is pressed."""
        return bool(self.pressed)

    @property
    def severity(self) -> tables.ErrorClass:
        """The class of the active alarm; what the table does not know is class L."""
        entry = tables.describe(self.alarm)
        return "L" if entry is None else entry.severity

    @property
    def is_blocked_by_alarm(self) -> bool:
        """Whether an alarm worse than a caution is active."""
        return self.alarm != 0 and self.severity != "C"

    def is_servo_on(self, now_s: float) -> bool:
        """Return whether the servos are on; turning on counts as off."""
        return self.servo_ready_s is not None and now_s >= self.servo_ready_s

    def is_barred(self) -> bool:
        """Return whether the arm stays where it is though motions are taken."""
        return self.is_locked or self.is_stop_input_on

    def set_alarm(self, number: int) -> None:
        """Make an alarm the active one and remember it."""
        self.alarm = number
        self.history.appendleft(number)

    def clear_alarm(self) -> None:
        """Clear the alarm, unless its cause is still there."""
        self.alarm = alarm_of(min(self.pressed)) if self.pressed else 0

    def forget(self) -> None:
        """Be as after power on: everything but switches, inputs and override is as at first."""
        self.is_open = False
        self.holder = "nobody"
        self.alarm = 0
        self.servo_ready_s = None
        self.is_cyclic = False
        self.program = ""
        self.outputs.clear()
        self.open_hands.clear()

    def run_status(self, now_s: float, *, is_running: bool) -> int:
        """Return the run status bits."""
        status = 0 if self.is_cyclic else _REPEAT
        if self.is_servo_on(now_s):
            status |= _SERVO_ON
        if is_running:
            status |= _RUNNING
        if not self.is_automatic:
            status |= _TEACH
        if self.holder == "host":
            status |= _ENABLED
        if self.is_locked:
            status |= _LOCKED
        return status

    def stop_status(self, *, is_running: bool) -> int:
        """Return the stop status bits; idle reads STOP and WAIT."""
        status = 0 if is_running else _IDLE
        return status | _EMERGENCY if self.is_emergency_pressed else status

    def stop_sources(self) -> StopSources:
        """Return who stops the arm, as STPSIG tells it."""
        stops = _PENDANT_STOPS if self.is_pendant_enabled else 0
        stops |= _INPUT_STOPS if self.is_stop_input_on else 0
        return StopSources(stops, sum(_EMERGENCIES[where][0] for where in self.pressed))


def alarm_of(where: StopButton) -> int:
    """Return the alarm of an emergency stop."""
    return _EMERGENCIES[where][1]
