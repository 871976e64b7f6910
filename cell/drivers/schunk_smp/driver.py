"""The PG-70 gripper behind the SCHUNK Motion Protocol.

A motion is accepted at once and ends with an impulse: "position reached" or
"move blocked". Impulses may get lost or may come late from an earlier motion,
so each one is held against the module's state, and when none comes the state is
asked for. When the answer to a start is lost, the state tells whether the fingers have
started; only fingers that stand are told a second time.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from cell.clock import Clock
from cell.devices.gripper import GripperState, GripResult
from cell.drivers.schunk_smp.commands import (
    Acknowledge,
    EmergencyStop,
    MoveGrip,
    MovePosition,
    Reference,
    SetTarget,
    Stop,
)
from cell.drivers.schunk_smp.conversation import LINK_PAUSE_S, Conversation, OnRepeat, told
from cell.drivers.schunk_smp.replies import (
    Answer,
    ErrorReport,
    Impulse,
    MoveAccepted,
    MoveBlocked,
    PositionReached,
    StateReply,
)
from cell.drivers.schunk_smp.requests import ModuleRequests
from cell.drivers.schunk_smp.settings import SchunkSettings
from cell.drivers.schunk_smp.tables import (
    Code,
    Command,
    Register,
    Status,
    problem_of,
)
from cell.errors import DeviceError, DeviceTimeout, LinkError, OutOfRange, Stopped
from cell.links.base import Link
from cell.links.errors import is_lasting
from cell.stop import StopToken

_LOGGER = logging.getLogger(__name__)
_UNPROVEN = "this driver was never tried on hardware; watch its first motions"


def _log_warning(text: str) -> None:
    _LOGGER.warning("%s", text)


def _log_repeat(device: str, problem: str) -> None:
    _LOGGER.warning("%s: asked again: %s", device, problem)


class SchunkGripper:
    """A `Gripper` that speaks the SCHUNK Motion Protocol.

    Args:
        link: The line to the module.
        clock: What deadlines are measured with.
        settings: Figures of the cell and patience.
        token: Asked, if given, during every motion; a stop ends it.
        on_warning: Told what a technician should know although nothing failed.
        on_repeat: Told the device and what was wrong, whenever a request is sent again.
    """

    def __init__(
        self,
        link: Link,
        clock: Clock,
        settings: SchunkSettings,
        *,
        token: StopToken | None = None,
        on_warning: Callable[[str], None] = _log_warning,
        on_repeat: OnRepeat = _log_repeat,
    ) -> None:
        self._clock = clock
        self._settings = settings
        self._conversation = Conversation(
            link,
            clock,
            device=settings.device,
            module=settings.module_id,
            attempts=settings.attempts,
            token=token,
            on_repeat=on_repeat,
        )
        self._on_repeat = on_repeat
        self._module = ModuleRequests(self._conversation, settings)
        self._on_warning = on_warning
        self._identity = ""
        self._is_in_use = False
        self._lowest_mm = 0.0
        self._highest_mm = settings.stroke_mm
        self._max_current_a = 0.0

    def open(self, *, may_move: bool = True) -> str:
        """Make the module ready to move: errors cleared, impulses on, referenced.

        Opening again is harmless. Referencing moves the fingers over their whole
        stroke.

        Args:
            may_move: Whether to reference a module that does not know its zero; one that
                is not referenced here refuses to move until `reference`.

        Returns:
            The module's identity.

        Raises:
            DeviceError: An error does not go away, or the unit system is not millimetres.
            DeviceTimeout: The module is silent, or referencing does not end.
        """
        if self._identity:
            return self._identity
        self._is_in_use = True
        if not self._settings.was_tried_on_hardware:
            self._on_warning(f"{self._settings.device}: {_UNPROVEN}")
        module = self._module
        state = module.await_boot(self._clock)
        if state.error or state.status & Status.ERROR:
            self.acknowledge()
        identity = module.identity()
        module.require_millimetres()
        self._read_limits()
        module.switch_impulses_on()
        settings = self._settings
        self._module.ask(SetTarget(Command.SET_TARGET_VELOCITY, settings.speed_mm_s))
        self._module.ask(SetTarget(Command.SET_TARGET_ACCELERATION, settings.acceleration_mm_s2))
        if may_move and not self._module.state().status & Status.REFERENCED:
            self.reference()
        self._identity = identity
        return identity

    def close(self) -> None:
        """Stop the fingers; they keep what they hold. Closing twice is harmless.

        The link stays with whoever made it, so the gripper can be opened again. A
        module that does not answer (its power may be off already) is left alone.

        Raises:
            DeviceError: The module refuses to stop.
        """
        if not self._is_in_use:
            return
        self._is_in_use = False
        self._identity = ""
        try:
            self.stop()
        except DeviceTimeout as error:
            self._on_warning(f"{error}; closed all the same")

    def reference(self) -> None:
        """Let the module find its zero position; the fingers move.

        Raises:
            DeviceError: The module refuses or fails.
            DeviceTimeout: It takes longer than the settings allow.
        """
        self._start(Reference())
        state = self._await_end("referencing", self._settings.reference_timeout_s)
        if not state.status & Status.REFERENCED:
            raise self._module.error(
                "referencing ended without a zero position", Code.NOT_REFERENCED
            )

    def move_to(self, opening_mm: float) -> None:
        """Move the fingers to an opening and return when they stand there.

        Raises:
            DeviceError: The opening is out of reach, something blocks the fingers, or
                the module refuses or fails.
            DeviceTimeout: The module does not answer or does not finish.
        """
        self._require_reachable(opening_mm)
        settings = self._settings
        answer = self._start(
            MovePosition(opening_mm, settings.speed_mm_s, settings.acceleration_mm_s2)
        )
        expected_s = answer.duration_s if isinstance(answer, MoveAccepted) else self._longest_s()
        state = self._await_end(
            f"moving to {opening_mm:.1f} mm",
            2.0 * expected_s + 4.0 * settings.margin_s,
            target_mm=opening_mm,
            quiet_s=expected_s + settings.margin_s,
        )
        self._require_at(opening_mm, state)

    def grip(self, current_a: float) -> GripResult:
        """Close the fingers with a motor current until something holds them.

        Args:
            current_a: Motor current, above 0; the sign for closing is the settings' affair.

        Returns:
            Whether something is held, and the opening at which the fingers stand.

        Raises:
            DeviceError: The current is out of range, or the module refuses or fails.
            DeviceTimeout: The module does not answer or does not finish.
        """
        self._require_current(current_a)
        settings = self._settings
        self._start(MoveGrip(settings.closing_sign * current_a))
        try:
            state = self._await_end("gripping", settings.grip_timeout_s)
        except DeviceError as error:
            if error.code != Code.SOFT_LIMIT_LOW:
                raise
            self.acknowledge()
            state = self._module.state()
        width_mm = _position(state)
        is_empty = width_mm < self._lowest_mm + settings.empty_below_mm
        return GripResult(is_holding=not is_empty, width_mm=width_mm)

    def stop(self) -> None:
        """Stop the fingers now and return when they stand."""
        self._module.ask(Stop())
        self._await_standstill(self._settings.reply_timeout_s + self._longest_s())

    def emergency_stop(self) -> None:
        """Stop at once; the module stays in its error state until `acknowledge`."""
        self._module.ask(EmergencyStop())

    def wait_for_position(self, opening_mm: float, timeout_s: float) -> None:
        """Return when the fingers stand at an opening.

        Raises:
            DeviceError: The module reports an error.
            DeviceTimeout: They do not stand there in time.
        """
        tolerance_mm = self._settings.tolerance_mm
        deadline_s = self._clock.now_s() + timeout_s
        state = self._module.sound_state()
        while state.status & Status.MOVING or abs(_position(state) - opening_mm) > tolerance_mm:
            if self._clock.now_s() >= deadline_s:
                raise DeviceTimeout(
                    self._settings.device,
                    f"at {_position(state):.1f} mm instead of {opening_mm:.1f} mm "
                    f"after {timeout_s:g} s",
                    hint="look for something that blocks the fingers",
                )
            self._pause()
            state = self._module.sound_state()

    def wait_for_stop(self, timeout_s: float) -> GripperState:
        """Return the state as soon as the fingers stand still.

        Raises:
            DeviceTimeout: They still move after `timeout_s`.
        """
        return self._gripper_state(self._await_standstill(timeout_s))

    def read_state(self) -> GripperState:
        """Return position, speed, current, flags and error."""
        return self._gripper_state(self._module.state())

    def acknowledge(self) -> None:
        """Acknowledge latched errors.

        Raises:
            DeviceError: An error stays because its cause is still there.
        """
        self._module.ask(Acknowledge())
        state = self._module.state()
        if state.error or state.status & Status.ERROR:
            raise self._module.error(problem_of(state.error).text, state.error)
        self._conversation.forget_impulses()

    def _read_limits(self) -> None:
        module = self._module
        self._lowest_mm = module.register(Register.SOFT_LIMIT_LOW)
        self._highest_mm = min(self._settings.stroke_mm, module.register(Register.SOFT_LIMIT_HIGH))
        self._max_current_a = module.register(Register.MAX_CURRENT)

    def _start(self, command: MovePosition | MoveGrip | Reference) -> Answer | None:
        """Send the start of a motion; what was said before belongs to earlier ones.

        Returns:
            The answer, or None when it was lost but the fingers have started.
        """
        try:
            self._conversation.forget_impulses()
            return self._module.ask(command)
        except (DeviceTimeout, LinkError) as error:
            if is_lasting(error):
                raise
            has_begun = self._has_begun(command, self._module.state())
            self._on_repeat(
                self._settings.device,
                f"{told(error)}; the fingers {'have started' if has_begun else 'stand still'}",
            )
        return None if has_begun else self._module.ask(command)

    def _has_begun(self, command: MovePosition | MoveGrip | Reference, state: StateReply) -> bool:
        """Return whether a start was heard: the fingers move, or are where it leads."""
        if state.status & Status.MOVING or state.error:
            return True
        if not state.status & Status.REFERENCED:
            # It was without power in between, and has forgotten whatever it was told.
            return False
        match command:
            case MovePosition(position_mm=target_mm):
                return abs(_position(state) - target_mm) <= self._settings.tolerance_mm
            case MoveGrip():
                # The brake is open only while the motor pushes against something.
                return not state.status & Status.BRAKE
            case Reference():
                return True

    def _await_end(
        self,
        what: str,
        timeout_s: float,
        *,
        target_mm: float | None = None,
        quiet_s: float | None = None,
    ) -> StateReply:
        """Return the state in which a motion ended.

        Args:
            what: The motion, for messages.
            timeout_s: How long it may take.
            target_mm: Where it leads, if that is known.
            quiet_s: How long to rely on impulses before asking for the state.
        """
        begin_s = self._clock.now_s()
        deadline_s = begin_s + timeout_s
        wait_s = self._settings.margin_s if quiet_s is None else quiet_s
        try:
            while True:
                impulse = self._next_impulse(min(wait_s, timeout_s))
                if isinstance(impulse, ErrorReport):
                    raise self._module.error(
                        f"{what} failed: {problem_of(impulse.code).text}", impulse.code
                    )
                if impulse is None or isinstance(impulse, MoveBlocked | PositionReached):
                    state = self._module.sound_state(what)
                    if not state.status & Status.MOVING:
                        return state
                    wait_s = self._settings.margin_s
                if self._clock.now_s() >= deadline_s:
                    break
        except Stopped:
            self.stop()
            raise
        self.stop()
        raise DeviceTimeout(
            self._settings.device,
            f"{what} did not end within {timeout_s:.1f} s; stopped",
            hint="look for something that holds the fingers",
        )

    def _next_impulse(self, timeout_s: float) -> Impulse | None:
        """Return what the module says next; over a link that just broke that is nothing."""
        try:
            return self._conversation.next_impulse(timeout_s)
        except LinkError as error:
            if is_lasting(error):
                raise
            self._on_repeat(self._settings.device, str(error))
            self._clock.sleep(LINK_PAUSE_S)
            return None

    def _await_standstill(self, timeout_s: float) -> StateReply:
        deadline_s = self._clock.now_s() + timeout_s
        state = self._module.state()
        while state.status & Status.MOVING:
            if self._clock.now_s() >= deadline_s:
                raise DeviceTimeout(
                    self._settings.device,
                    f"still moving after {timeout_s:.1f} s",
                    hint="switch the gripper's power off",
                )
            self._pause()
            state = self._module.state()
        return state

    def _pause(self) -> None:
        """Let some time pass, but no longer than until the module says something."""
        self._conversation.next_impulse(self._settings.poll_s)

    def _require_reachable(self, opening_mm: float) -> None:
        nearest_mm = min(max(opening_mm, self._lowest_mm), self._highest_mm)
        if opening_mm != nearest_mm:
            raise OutOfRange(
                self._settings.device,
                f"an opening of {opening_mm:.1f} mm is out of reach",
                hint=f"allowed are {self._lowest_mm:.1f} to {self._highest_mm:.1f} mm, "
                f"nearest is {nearest_mm:.1f} mm",
            )

    def _require_current(self, current_a: float) -> None:
        if not 0 < current_a <= self._max_current_a:
            raise OutOfRange(
                self._settings.device,
                f"a grip current of {current_a:g} A is out of range",
                hint=f"allowed is above 0 up to {self._max_current_a:g} A",
            )

    def _require_at(self, opening_mm: float, state: StateReply) -> None:
        position_mm = _position(state)
        if abs(position_mm - opening_mm) > self._settings.tolerance_mm:
            raise DeviceError(
                self._settings.device,
                f"blocked at {position_mm:.1f} mm on the way to {opening_mm:.1f} mm",
                hint="look for something between or beside the fingers",
            )

    def _longest_s(self) -> float:
        """Return how long a move over the whole stroke takes."""
        settings = self._settings
        ramp_s = settings.speed_mm_s / settings.acceleration_mm_s2
        return settings.stroke_mm / settings.speed_mm_s + ramp_s

    def _gripper_state(self, state: StateReply) -> GripperState:
        return GripperState(
            position_mm=_position(state),
            velocity_mm_s=state.velocity_mm_s or 0.0,
            current_a=state.current_a or 0.0,
            is_referenced=bool(state.status & Status.REFERENCED),
            is_moving=bool(state.status & Status.MOVING),
            has_error=bool(state.status & Status.ERROR),
            error=state.error,
            error_text=problem_of(state.error).text if state.error else "",
        )


def _position(state: StateReply) -> float:
    # Asked for all three values, a module always sends the position.
    return 0.0 if state.position_mm is None else state.position_mm
