"""Everything the controller can be asked and told, one method each."""

from __future__ import annotations

from collections.abc import Sequence

from cell.drivers.ssc32 import codec
from cell.drivers.ssc32.codec import BadCommand
from cell.drivers.ssc32.commands import (
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
from cell.drivers.ssc32.dialogue import Dialogue


class ServoPanel:
    """The controller as it is, without an arm; every method raises what `Dialogue` raises."""

    def __init__(self, dialogue: Dialogue) -> None:
        self._dialogue = dialogue

    def cancel_line(self) -> None:
        """Take back half a line that somebody may have left in the controller."""
        self._dialogue.cancel_line()

    def version(self) -> str:
        """Return the firmware's version."""
        return self._dialogue.ask(QueryVersion(), _decode_version)

    def is_moving(self) -> bool:
        """Return whether the last move is still under way, as far as pulses go."""
        return self._dialogue.ask(QueryMoving(), codec.decode_moving)

    def pulses_us(self, channels: Sequence[int]) -> tuple[int, ...]:
        """Return the commanded pulse widths, to within 10 us; 0 for none since power-up."""
        return self._dialogue.ask(QueryPulses(tuple(channels)), codec.decode_pulses)

    def move(self, move: Move) -> None:
        """Start a move; the controller does not answer, so nothing says that it was heard."""
        self._dialogue.tell(move)

    def stop_servos(self, channels: Sequence[int]) -> None:
        """Stop servos by the STOP of late firmware; others do not know it."""
        for channel in channels:
            self._dialogue.tell(StopServo(channel))

    def set_offsets(self, offsets: Sequence[tuple[int, int]]) -> None:
        """Shift the pulses of channels; pairs of channel and shift in us."""
        self._dialogue.tell_surely(SetOffsets(tuple(offsets)))

    def switch_output(self, channel: int, *, is_on: bool) -> None:
        """Make a channel a digital output, high or low; a servo on it loses its pulses."""
        self._dialogue.tell_surely(SetOutputs(((channel, is_on),)))

    def put_byte(self, bank: int, value: int) -> None:
        """Put a byte out on the eight channels of a bank; servos on them lose their pulses."""
        self._dialogue.tell_surely(SetBanks(((bank, value),)))

    def inputs(self, letters: str) -> tuple[bool, ...]:
        """Return whether digital inputs, such as `AF`, are high now."""
        return self._dialogue.ask(
            ReadInputs(tuple((letter, False) for letter in letters)), codec.decode_inputs
        )

    def latched_inputs(self, letters: str) -> tuple[bool, ...]:
        """Return the latches of digital inputs, which reading resets."""
        return self._dialogue.ask(
            ReadInputs(tuple((letter, True) for letter in letters)), codec.decode_inputs
        )

    def volts(self, letters: str) -> tuple[float, ...]:
        """Return the voltages of analogue inputs, such as `AH`."""
        return self._dialogue.ask(ReadAnalogues(tuple(letters)), codec.decode_volts)


def _decode_version(reply: bytes) -> str:
    text = reply.decode("latin-1").strip()
    if not text or not text.isprintable():
        raise BadCommand(f"answered {reply!r} to VER")
    return text
