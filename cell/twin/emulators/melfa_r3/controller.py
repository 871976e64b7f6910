"""The emulated controller: bytes in, bytes out, and the hands that press its buttons.

A request takes effect when its end arrives; its reply is out after the time that
both need on the wire and the controller needs to think. Motions start when the
controller has thought.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterable

from cell.drivers.melfa_r3 import tables
from cell.drivers.melfa_r3.codec import (
    MAX_REQUEST_BYTES,
    GarbledMessage,
    LineReader,
    Reply,
    decode_request,
    encode_reply,
)
from cell.twin.bodies import ArmBody
from cell.twin.emulators.melfa_r3.commands import Commands
from cell.twin.emulators.melfa_r3.planner import Planner
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.settings import ControllerSettings
from cell.twin.emulators.melfa_r3.stand import ArmKinematics
from cell.twin.emulators.melfa_r3.state import StopButton, alarm_of

_ACCEPTED = b"QoK\r"
_ACCEPTED_IN_ALARM = b"Qok\r"


class MelfaController:
    """A MELFA controller with an arm, as an emulator behind a link.

    Args:
        body: The arm's mechanics in the twin.
        kinematics: The arm's kinematics, for the tool of the settings.
        settings: Who it is, its limits, speeds and delays.
        outputs_on: Outputs that are on already, as those of a controller that stayed on.
    """

    def __init__(
        self,
        body: ArmBody,
        kinematics: ArmKinematics,
        settings: ControllerSettings,
        *,
        outputs_on: Iterable[int] = (),
    ) -> None:
        self._settings = settings
        self._commands = Commands(body, Planner(kinematics, settings), settings)
        self._commands.state.outputs.update(outputs_on)
        self._reader = LineReader(MAX_REQUEST_BYTES)
        self._outbox: list[tuple[float, bytes]] = []
        self._wire_free_s = 0.0
        self._is_silent = False
        self._injected: bytes | None = None
        self._delay_s = 0.0
        self._boots_until_s = 0.0

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at `now_s`; without power, or while it starts, they are lost."""
        if now_s < self._boots_until_s:
            return
        for line in self._reader.feed(data):
            heard_s = now_s + (len(line) + 1) * self._settings.byte_s
            at_s = heard_s + self._settings.processing_s
            reply = self._answer(line, now_s, at_s)
            if not self._is_silent:
                self._send(reply, at_s)
            if self._commands.restarts:
                # The reply that is on its way is the last word before the restart.
                self._commands.lose_power(at_s)
                self._boots_until_s = at_s + self._settings.boot_s
                return

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`."""
        outbox = self._outbox
        data = b""
        while outbox and outbox[0][0] <= now_s:
            data += outbox.pop(0)[1]
        return data

    def next_output_s(self) -> float | None:
        """Return when the next bytes will be out, or None if none are coming."""
        return self._outbox[0][0] if self._outbox else None

    # Hands at the controller, and faults

    def press_emergency_stop(self, now_s: float, where: StopButton = "panel") -> None:
        """Press an emergency stop: it latches, the servos go off."""
        self._commands.state.pressed.add(where)
        self.raise_alarm(alarm_of(where), now_s)

    def release_emergency_stop(self, now_s: float) -> None:
        """Unlock every emergency stop; the alarm stays until it is reset."""
        self._advance(now_s)
        self._commands.state.pressed.clear()

    def enable_pendant(self, now_s: float, *, is_enabled: bool) -> None:
        """Turn the pendant's switch; enabled, it has the arm: right and servos are gone."""
        self._advance(now_s)
        self._commands.state.is_pendant_enabled = is_enabled
        if is_enabled:
            self._commands.state.holder = "nobody"
            self._servos_off(now_s)

    def lock_machine(self, *, is_locked: bool) -> None:
        """Switch machine lock: motions are taken, and the arm does not follow them."""
        self._commands.state.is_locked = is_locked

    def set_stop_input(self, now_s: float, *, is_on: bool) -> None:
        """Switch the stop input: a motion ends, and none goes on while it is on."""
        self._commands.state.is_stop_input_on = is_on
        if is_on:
            self.press_stop_button(now_s)

    def connect_arm(self, robot: str) -> None:
        """Have the controller drive an arm of another type, as it tells it."""
        self._commands.identity = self._commands.identity._replace(robot=robot)

    def break_output(self, bit: int, now_s: float) -> None:
        """Let an output stay off from now on, whatever is asked."""
        commands = self._commands
        commands.state.dead_outputs.add(bit)
        commands.state.outputs.discard(bit)
        commands.mechanism.switch_output(bit, now_s, is_on=False)

    def delete_program(self, name: str) -> None:
        """Delete a program at the panel.

        Raises:
            Refusal: There is none of that name.
        """
        self._commands.library.delete(name)

    def start_program(self, name: str, lines: tuple[str, ...], now_s: float) -> None:
        """Put a program into memory and start it at the panel, over and over."""
        self._advance(now_s)
        commands = self._commands
        commands.library.keep(name, lines)
        commands.runner.load(name)
        commands.state.program = name
        commands.state.holder = "panel"
        commands.runner.start(is_cyclic=False)

    def set_key_switch(self, now_s: float, *, is_automatic: bool) -> None:
        """Turn the key switch to AUTO or TEACH; TEACH takes right and servos away."""
        self._advance(now_s)
        state = self._commands.state
        state.is_automatic = is_automatic
        if not is_automatic:
            state.holder = "nobody"
            self._servos_off(now_s)

    def hold_right_by_panel(self, now_s: float, *, is_held: bool) -> None:
        """Let somebody at the panel take the operation right, or give it back."""
        self._advance(now_s)
        self._commands.state.holder = "panel" if is_held else "nobody"

    def raise_alarm(self, number: int, now_s: float) -> None:
        """Raise an alarm; its class decides what happens to servos and motion."""
        self._advance(now_s)
        state = self._commands.state
        state.set_alarm(number)
        if state.severity == "H":
            self._servos_off(now_s)
        elif state.severity == "L":
            self._commands.runner.is_running = False
            self._commands.mechanism.brake(now_s)

    def press_stop_button(self, now_s: float) -> None:
        """Press the panel's STOP: the motion ends without an alarm."""
        self._commands.runner.is_running = False
        self._commands.mechanism.brake(now_s)

    def lose_power(self, now_s: float, *, for_s: float = 1.0) -> None:
        """Take the mains away and give it back: the brakes fall in, outputs fall, all is forgotten.

        Args:
            now_s: When the mains goes.
            for_s: How long until the controller answers again, its start included.
        """
        self._advance(now_s)
        self._commands.lose_power(now_s)
        self._reader.clear()
        self._outbox.clear()
        self._boots_until_s = now_s + for_s

    def set_input(self, bit: int, *, is_on: bool) -> None:
        """Switch one input of the controller."""
        inputs = self._commands.state.inputs
        (inputs.add if is_on else inputs.discard)(bit)

    def fall_silent(self, *, is_silent: bool) -> None:
        """Answer nothing any more (requests still take effect), or answer again."""
        self._is_silent = is_silent

    def replace_next_reply(self, data: bytes) -> None:
        """Send these bytes instead of the next reply."""
        self._injected = data

    def delay_next_reply(self, delay_s: float) -> None:
        """Send the next reply later than usual."""
        self._delay_s = delay_s

    def chatter(self, data: bytes, now_s: float) -> None:
        """Send bytes that nobody asked for, at `now_s` or later."""
        insort(self._outbox, (now_s, data))

    def _answer(self, line: bytes, now_s: float, at_s: float) -> bytes:
        commands = self._commands
        state = commands.state
        try:
            if commands.runner.is_running:
                self._advance(now_s)
            data = commands.answer(decode_request(line), now_s, at_s)
        except GarbledMessage:
            return encode_reply(Reply(False, state.alarm != 0, tables.UNKNOWN_COMMAND))
        except Refusal as refusal:
            if refusal.is_alarm:
                state.set_alarm(refusal.number)
            return encode_reply(Reply(False, state.alarm != 0, refusal.number))
        if data:
            return encode_reply(Reply(True, state.alarm != 0, 0, data))
        return _ACCEPTED_IN_ALARM if state.alarm else _ACCEPTED

    def _send(self, reply: bytes, at_s: float) -> None:
        if self._injected is not None:
            reply, self._injected = self._injected, None
        start_s = max(at_s + self._delay_s, self._wire_free_s)
        self._delay_s = 0.0
        self._wire_free_s = start_s + len(reply) * self._settings.byte_s
        insort(self._outbox, (self._wire_free_s, reply))

    def _advance(self, now_s: float) -> None:
        """Let a running program go on; what it cannot execute becomes an alarm."""
        try:
            self._commands.runner.advance(now_s)
        except Refusal as refusal:
            self._commands.state.set_alarm(refusal.number)

    def _servos_off(self, now_s: float) -> None:
        self._commands.runner.is_running = False
        self._commands.mechanism.halt(now_s)
        self._commands.state.servo_ready_s = None
