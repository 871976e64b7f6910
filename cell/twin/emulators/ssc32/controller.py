"""The emulated servo controller: bytes in, bytes out, pulses to servos.

What is assumed, because no source tells: an order that it does not understand, or whose
figures are out of range, is passed over as a whole and in silence; a channel without a servo
counts pulses like one with; a digital output on a channel ends its pulses; the latch of an
input holds that it was low since it was last read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, assert_never

from pydantic import Field

from cell.drivers.ssc32 import codec, tables
from cell.drivers.ssc32.codec import BadCommand
from cell.drivers.ssc32.commands import (
    Command,
    Move,
    QueryMoving,
    QueryPulses,
    QueryVersion,
    ReadAnalogues,
    ReadInputs,
    SetBanks,
    SetOffsets,
    SetOutputs,
    StopServo,
)
from cell.drivers.ssc32.servo_map import LinearServoMap
from cell.twin.emulators.ssc32.servos import KeptServo, ServoBank, ServoErrors, TwinServo
from cell.twin.emulators.ssc32.settings import Ssc32ControllerSettings
from cell.twin.emulators.uart import Transmitter

_BANK_CHANNELS = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptController:
    """A controller at rest, and its servos by channel.

    Attributes:
        servos: What is plugged in or pulsed.
        outputs: Digital outputs by channel.
    """

    servos: dict[Annotated[int, Field(ge=0, lt=tables.CHANNELS)], KeptServo]
    outputs: dict[Annotated[int, Field(ge=0, lt=tables.CHANNELS)], bool]


class Ssc32Controller:
    """An SSC-32 with servos, as a `cell.links.base.Emulator`.

    Args:
        servos: What is plugged in.
        settings: Who it is and how fast it answers.
    """

    def __init__(self, servos: ServoBank, settings: Ssc32ControllerSettings | None = None) -> None:
        self._settings = Ssc32ControllerSettings() if settings is None else settings
        self._plugged = frozenset(servos.servos)
        self._channels = tuple(
            servos.get(channel) or _bare_channel() for channel in range(tables.CHANNELS)
        )
        self._reader = codec.LineReader()
        self._transmitter = Transmitter(self._settings.byte_s)
        self._outputs: dict[int, bool] = {}
        self._inputs = dict.fromkeys(tables.INPUTS, True)
        self._latches = dict.fromkeys(tables.INPUTS, True)
        self._volts = dict.fromkeys(tables.ANALOGUES, 0.0)
        self._is_powered = True
        self._ready_s = 0.0
        self._is_silent = False
        self._latest_end_s = 0.0

    # The wire

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at `now_s`; without power, and while it starts, they are lost."""
        if not self._is_powered or now_s < self._ready_s:
            return
        heard_s = now_s + len(data) * self._settings.byte_s
        for line in self._reader.feed(data):
            try:
                command = codec.decode(line)
            except BadCommand:
                continue
            reply = self._obey(command, now_s)
            if reply and not self._is_silent:
                self._transmitter.send(reply, heard_s + self._settings.latency_s)

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`."""
        return self._transmitter.take(now_s)

    def next_output_s(self) -> float | None:
        """Return when the next bytes will be out, or None if none are coming."""
        return self._transmitter.next_s()

    # Hands at the controller

    def cut_power(self, now_s: float) -> None:
        """Take the logic supply away: it forgets everything and the arm slumps."""
        self._is_powered = False
        self._reader.clear()
        self._transmitter.clear()
        self._outputs.clear()
        for servo in self._channels:
            servo.lose_pulses(now_s)
            servo.shift(0.0, now_s)

    def restore_power(self, now_s: float) -> None:
        """Give the logic supply back; it hears again when it has started."""
        self._is_powered = True
        self._ready_s = now_s + self._settings.boot_s

    def switch_servo_supply(self, now_s: float, *, is_on: bool) -> None:
        """Switch the servos' own supply: the arm slumps, and the controller does not notice."""
        for servo in self._channels:
            servo.set_supply(now_s, is_on=is_on)

    def set_input(self, letter: str, *, is_high: bool) -> None:
        """Put a digital input, A to F, high or low."""
        self._inputs[letter] = is_high
        if not is_high:
            self._latches[letter] = False

    def set_volts(self, letter: str, volts: float) -> None:
        """Put a voltage on an analogue input, A to H."""
        self._volts[letter] = volts

    def output(self, channel: int) -> bool | None:
        """Return whether a digital output is high, None for a channel that is none."""
        return self._outputs.get(channel)

    def fall_silent(self, *, is_silent: bool) -> None:
        """Answer nothing any more (orders still take effect), or answer again."""
        self._is_silent = is_silent

    def pulse_us(self, channel: int, now_s: float) -> float:
        """Return the commanded pulse width of a channel, 0 without pulses."""
        return self._channels[channel].pulse_us(now_s)

    # From one process to the next

    def kept(self, now_s: float) -> KeptController:
        """Return what a controller that stays powered goes on with."""
        return KeptController(
            servos={n: servo.kept(now_s) for n, servo in enumerate(self._channels)
                    if servo.is_pulsed or n in self._plugged},
            outputs=dict(self._outputs),
        )  # fmt: skip

    def restore(self, kept: KeptController) -> None:
        """Go on from what was kept, at time 0; it was powered all the time."""
        for channel, servo in kept.servos.items():
            self._channels[channel].restore(servo)
        self._outputs = dict(kept.outputs)

    # What commands do

    def _obey(self, command: Command, now_s: float) -> bytes:
        match command:
            case Move():
                self._move(command, now_s)
            case SetOffsets(offsets):
                for channel, offset_us in offsets:
                    self._channels[channel].shift(float(offset_us), now_s)
            case SetOutputs(levels):
                for channel, is_high in levels:
                    self._switch(channel, now_s, is_high=is_high)
            case SetBanks(values):
                for bank, value in values:
                    for bit in range(_BANK_CHANNELS):
                        channel = bank * _BANK_CHANNELS + bit
                        self._switch(channel, now_s, is_high=bool(value >> bit & 1))
            case StopServo(channel):
                if self._settings.knows_stop:
                    self._channels[channel].hold(now_s)
            case QueryMoving():
                is_moving = now_s < self._latest_end_s and any(
                    servo.is_moving(now_s) for servo in self._channels
                )
                return tables.MOVING if is_moving else tables.FINISHED
            case QueryPulses(channels):
                return codec.encode_pulses([self._channels[c].pulse_us(now_s) for c in channels])
            case QueryVersion():
                return f"{self._settings.version}\r".encode("ascii")
            case ReadInputs(inputs):
                return b"".join(b"1" if self._read(*each) else b"0" for each in inputs)
            case ReadAnalogues(letters):
                return codec.encode_volts([self._volts[letter] for letter in letters])
            case _:
                assert_never(command)
        return b""

    def _move(self, move: Move, now_s: float) -> None:
        """Start servos together so that they arrive together, none above its own speed."""
        duration_s = move.time_ms / 1000.0
        for target in move.targets:
            servo = self._channels[target.channel]
            if target.speed_us_s and servo.is_pulsed:
                way_us = abs(target.pulse_us - servo.pulse_us(now_s))
                duration_s = max(duration_s, way_us / target.speed_us_s)
        self._latest_end_s = max(self._latest_end_s, now_s + duration_s)
        for target in move.targets:
            self._outputs.pop(target.channel, None)
            self._channels[target.channel].command(float(target.pulse_us), duration_s, now_s)

    def _switch(self, channel: int, now_s: float, *, is_high: bool) -> None:
        self._outputs[channel] = is_high
        if self._channels[channel].is_pulsed:
            self._channels[channel].lose_pulses(now_s)

    def _read(self, letter: str, is_latch: bool) -> bool:
        if not is_latch:
            return self._inputs[letter]
        was_high = self._latches[letter]
        self._latches[letter] = self._inputs[letter]
        return was_high


def _bare_channel() -> TwinServo:
    return TwinServo(LinearServoMap(centre_us=1500.0, us_per_unit=1.0), ServoErrors())
