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
from cell.drivers.ssc32.tables import QUERY_UNIT_US
from cell.errors import DeviceError

_SURE_TRIES = 4


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

    def sure_pulses_us(
        self,
        channels: Sequence[int],
        expected_us: Sequence[int] | None = None,
        *,
        within_us: int = QUERY_UNIT_US,
    ) -> tuple[int, ...]:
        """Return commanded pulse widths that were told twice, or told as expected.

        An answer has no checksum, and a bit turned over on the line is another pulse: taken
        for where the arm is, it would make the next move a leap.

        Args:
            channels: Whose.
            expected_us: Pulses that are believed at once.
            within_us: How far two answers may differ; more while servos move.

        Raises:
            DeviceError: No two answers agree, or they are strange.
            DeviceTimeout: The controller does not answer.
        """
        told = self.pulses_us(channels)
        if expected_us is not None and agree(expected_us, told):
            return told
        for _ in range(_SURE_TRIES):
            again = self.pulses_us(channels)
            if agree(told, again, within_us=within_us) and _same_zeros(told, again):
                return again
            told = again
        raise DeviceError(
            self._dialogue.device,
            f"told different pulse widths {_SURE_TRIES + 1} times in a row",
            hint="check the cable, and that nobody else sends to the controller",
        )

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


def agree(
    one_us: Sequence[int], other_us: Sequence[int], *, within_us: int = QUERY_UNIT_US
) -> bool:
    """Return whether pulses are the same, as far as the controller's units tell."""
    return all(abs(a - b) <= within_us for a, b in zip(one_us, other_us, strict=True))


def _same_zeros(one_us: Sequence[int], other_us: Sequence[int]) -> bool:
    return all(bool(a) == bool(b) for a, b in zip(one_us, other_us, strict=True))


def _decode_version(reply: bytes) -> str:
    text = reply.decode("latin-1").strip()
    if not text or not text.isprintable():
        raise BadCommand(f"answered {reply!r} to VER")
    return text
