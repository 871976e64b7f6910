"""Fingers on a servo of an SSC-32: moved by pulse width, and blind.

Nothing measures the opening, the force, or whether something is held. The opening told is
the commanded one; a grip is an opening less than the thing's width, and how firm it is
follows from the difference, not from a current.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable

from cell.clock import Clock
from cell.devices.gripper import GripperState, GripResult
from cell.drivers.ssc32.commands import Move, ServoTarget
from cell.drivers.ssc32.dialogue import Dialogue, log_repeat
from cell.drivers.ssc32.panel import ServoPanel
from cell.drivers.ssc32.settings import FingerSettings
from cell.drivers.ssc32.tables import QUERY_UNIT_US
from cell.errors import CellError, DeviceError, DeviceTimeout, OutOfRange
from cell.links.base import Link
from cell.stop import StopToken

_log = logging.getLogger(__name__)

_MOVING_US = 50
"""How far the pulse may change between two questions while the fingers move."""
_SLACK_MM = 1e-6
_UNPROVEN = "this driver was never tried on hardware; watch its first motions"
_BLIND = (
    "nothing measures these fingers: the opening told is the commanded one, a grip always "
    "counts as holding, and a grip current changes nothing; let a camera see what is held"
)
_OPEN_HINT = "open the gripper again or reference it; its first move jumps"


def _log_warning(text: str) -> None:
    _log.warning("%s", text)


class Ssc32Gripper:
    """A `Gripper` that is one servo; shares the link, and the thread, with the arm.

    Args:
        link: The line to the controller.
        clock: What deadlines are measured with.
        settings: Figures of the fingers and patience.
        on_warning: Told what a technician should know although nothing failed.
        on_repeat: Told device and problem when a question is asked again.
        token: Asked, if given, during every motion; a stop ends it.
    """

    def __init__(
        self,
        link: Link,
        clock: Clock,
        settings: FingerSettings,
        *,
        on_warning: Callable[[str], None] = _log_warning,
        on_repeat: Callable[[str, str], None] = log_repeat,
        token: StopToken | None = None,
    ) -> None:
        self._clock = clock
        self._settings = settings
        self._on_warning = on_warning
        self._token = token
        self._channel = settings.servo.channel
        self._sent_us: int | None = None
        self._identity = ""
        self.panel = ServoPanel(
            Dialogue(link, clock, settings.device, settings.line, on_repeat=on_repeat)
        )

    def open(self, *, may_move: bool = True) -> str:
        """Take the fingers into service; opening again is harmless.

        If they were never moved since power-up, they jump to their open position, after a
        warning: a servo's first move knows no speed.

        Args:
            may_move: Whether they may; when not, they stay limp until `reference`.

        Raises:
            DeviceError: The fingers get no pulses, or an answer is strange.
            DeviceTimeout: The controller does not answer.
        """
        if self._identity and self._pulse_us():
            return self._identity
        settings = self._settings
        if not settings.was_tried_on_hardware:
            self._on_warning(f"{settings.device}: {_UNPROVEN}")
        self._on_warning(f"{settings.device}: {_BLIND}")
        self.panel.cancel_line()
        self.panel.is_moving()
        servo = settings.servo
        if servo.offset_us:
            self.panel.set_offsets(((servo.channel, servo.offset_us),))
        if not self._pulse_us() and may_move:
            self.reference()
        self._identity = f"fingers on servo channel {self._channel}"
        return self._identity

    def close(self) -> None:
        """Stop; the fingers keep what they hold. Closing twice is harmless.

        A controller that does not answer is left alone.
        """
        if not self._identity:
            return
        self._identity = ""
        try:
            self.stop()
        except DeviceTimeout as error:
            self._on_warning(f"{error}; closed all the same")

    def reference(self) -> None:
        """Give the fingers a known opening, the open one; there is no zero position to find.

        Fingers that have pulses already know theirs, and stay.

        Raises:
            DeviceError: The fingers get no pulses, or an answer is strange.
            DeviceTimeout: The controller does not answer.
        """
        if self._pulse_us():
            return
        settings = self._settings
        self._on_warning(
            f"{settings.device}: no pulse since the controller's power-up; the fingers jump to "
            f"{settings.open_mm:g} mm now and drop what they hold"
        )
        self._send(settings.open_mm, 0)
        self._clock.sleep(settings.first_s)
        self._require_pulse()

    def move_to(self, opening_mm: float) -> None:
        """Move the fingers to an opening and return when the servo is told to be there.

        Raises:
            DeviceError: The opening is out of reach, or the controller was restarted.
            DeviceTimeout: The controller does not answer or does not finish.
            Stopped: A stop was asked for; the fingers stand still.
        """
        settings = self._settings
        nearest_mm = min(max(opening_mm, settings.min_mm), settings.max_mm)
        if math.isnan(opening_mm) or abs(opening_mm - nearest_mm) > _SLACK_MM:
            raise OutOfRange(
                settings.device,
                f"an opening of {opening_mm:.1f} mm is out of reach",
                hint=f"allowed are {settings.min_mm:.1f} to {settings.max_mm:.1f} mm, "
                f"nearest is {nearest_mm:.1f} mm",
            )
        here_mm = self._standing_mm()
        if not self._identity:
            raise DeviceError(
                settings.device, "the gripper is not open", hint="open the gripper first"
            )
        duration_s = max(abs(opening_mm - here_mm) / settings.speed_mm_s, settings.poll_s)
        try:
            self._send(opening_mm, math.ceil(duration_s * 1000.0))
            self._await_end(opening_mm, duration_s)
        except CellError:
            self._stop_after_failure()
            raise

    def grip(self, current_a: float) -> GripResult:
        """Close to the grip opening of the settings.

        Args:
            current_a: Above 0; it changes nothing, because a servo takes no current.

        Returns:
            The commanded opening, which is less than what is held is wide, and a claim
            that something is held, which nothing here can check.

        Raises:
            DeviceError: The current is not above 0, or the controller was restarted.
            DeviceTimeout: The controller does not answer or does not finish.
            Stopped: A stop was asked for; the fingers stand still.
        """
        if not current_a > 0:
            raise OutOfRange(
                self._settings.device,
                f"a grip current of {current_a:g} A is out of range",
                hint="allowed is above 0 A; it changes nothing on these fingers",
            )
        self.move_to(self._settings.grip_mm)
        return GripResult(is_holding=True, width_mm=self._settings.grip_mm)

    def stop(self) -> None:
        """Stop the fingers where their pulse is at the moment, to within 10 us."""
        is_moving, sent_us = self.panel.is_moving(), self._sent_us
        pulse_us = self._pulse_us()
        is_there = sent_us is None or abs(sent_us - pulse_us) <= QUERY_UNIT_US
        # One strange answer must not keep moving fingers from being stopped.
        if pulse_us and (is_moving or not is_there):
            self.panel.move(Move((ServoTarget(self._channel, pulse_us),)))
            self._sent_us = pulse_us
            self.panel.is_moving()

    def wait_for_position(self, opening_mm: float, timeout_s: float) -> None:
        """Return when the fingers are told to stand at an opening.

        Raises:
            DeviceError: The controller was restarted.
            DeviceTimeout: They are not told to stand there in time.
        """
        settings = self._settings
        deadline_s = self._clock.now_s() + timeout_s
        tolerance_mm = abs(self._unit_mm()) + _SLACK_MM
        while self.panel.is_moving() or abs(self._standing_mm() - opening_mm) > tolerance_mm:
            if self._clock.now_s() >= deadline_s:
                raise DeviceTimeout(
                    settings.device,
                    f"at {self._standing_mm():.1f} mm instead of {opening_mm:.1f} mm "
                    f"after {timeout_s:g} s",
                    hint="nothing told the fingers to go there",
                )
            self._check_token()
            self._clock.sleep(settings.poll_s)

    def wait_for_stop(self, timeout_s: float) -> GripperState:
        """Return the state as soon as the pulse stands still.

        Raises:
            DeviceTimeout: It still changes after `timeout_s`.
        """
        deadline_s = self._clock.now_s() + timeout_s
        while self.panel.is_moving():
            if self._clock.now_s() >= deadline_s:
                raise DeviceTimeout(
                    self._settings.device,
                    f"still moving after {timeout_s:.1f} s",
                    hint="switch the servo supply off",
                )
            self._check_token()
            self._clock.sleep(self._settings.poll_s)
        return self.read_state()

    def read_state(self) -> GripperState:
        """Return the commanded opening; current and errors do not exist and are 0.

        Fingers without a pulse since power-up count as not referenced; their opening is
        told as the open one, and is not known.
        """
        pulse_us = self._pulse_us()
        position_mm = self._adopted_mm(pulse_us) if pulse_us else self._settings.open_mm
        return GripperState(
            position_mm=position_mm,
            velocity_mm_s=0.0,
            current_a=0.0,
            is_referenced=bool(pulse_us),
            is_moving=self.panel.is_moving(),
            has_error=False,
            error=0,
            error_text="" if pulse_us else f"{self._no_pulse()}; {_OPEN_HINT}",
        )

    def acknowledge(self) -> None:
        """Do nothing but see that the controller is there: it has no errors."""
        self.panel.is_moving()

    def _send(self, opening_mm: float, time_ms: int) -> None:
        servo = self._settings.servo
        pulse_us = min(max(round(servo.map.pulse_us(opening_mm)), servo.min_us), servo.max_us)
        self._sent_us = pulse_us
        self.panel.move(Move((ServoTarget(self._channel, pulse_us),), time_ms))

    def _await_end(self, opening_mm: float, duration_s: float) -> None:
        settings = self._settings
        for _ in range(max(1, int(duration_s / settings.poll_s))):
            self._check_token()
            self._clock.sleep(settings.poll_s)
        self.wait_for_stop(settings.margin_s)
        self._clock.sleep(settings.settle_s)
        sent_us, pulse_us = self._sent_us, self._require_pulse()
        if sent_us is not None and abs(pulse_us - sent_us) > QUERY_UNIT_US:
            raise DeviceError(
                settings.device,
                f"the move to {opening_mm:.1f} mm ended at "
                f"{settings.servo.map.position(pulse_us):.1f} mm",
                hint="an order was lost on the line, or somebody else sends to the controller",
            )

    def _stop_after_failure(self) -> None:
        """Stop without hiding the failure that led here."""
        try:
            self.stop()
        except CellError as error:
            self._on_warning(f"{error}; the fingers could not be told to stop")

    def _pulse_us(self) -> int:
        expected = None if self._sent_us is None else (self._sent_us,)
        return self.panel.sure_pulses_us((self._channel,), expected, within_us=_MOVING_US)[0]

    def _require_pulse(self) -> int:
        pulse_us = self._pulse_us()
        if not pulse_us:
            self._sent_us = None
            raise DeviceError(self._settings.device, self._no_pulse(), hint=_OPEN_HINT)
        return pulse_us

    def _no_pulse(self) -> str:
        return "since its power-up the controller has sent the fingers no pulse"

    def _standing_mm(self) -> float:
        return self._adopted_mm(self._require_pulse())

    def _adopted_mm(self, pulse_us: int) -> float:
        """Return the opening of a pulse that was told, more exactly where it was sent."""
        sent_us = self._sent_us
        if sent_us is None or abs(sent_us - pulse_us) > QUERY_UNIT_US:
            sent_us = pulse_us
        return self._settings.servo.map.position(sent_us)

    def _unit_mm(self) -> float:
        servo_map = self._settings.servo.map
        middle = 0.5 * (self._settings.servo.min_us + self._settings.servo.max_us)
        return servo_map.position(middle + QUERY_UNIT_US) - servo_map.position(middle)

    def _check_token(self) -> None:
        if self._token is not None:
            self._token.check()
