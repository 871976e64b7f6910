"""Hands, inputs and outputs of the emulated controller, as requests read and switch them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from cell.drivers.melfa_r3 import records, tables
from cell.twin.emulators.melfa_r3.arguments import number_of
from cell.twin.emulators.melfa_r3.interpreter import HANDS, OUTPUTS, Interpreter
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.state import ControllerState

_FIRST_HAND_OUTPUT = 900


class Signals:
    """The commands that read and switch signals.

    Attributes:
        handlers: What each command does.
    """

    def __init__(self, state: ControllerState, interpreter: Interpreter) -> None:
        self._state = state
        self._interpreter = interpreter
        self.handlers: Mapping[str, Callable[[str, float, float], str]] = {
            "HNDON": self._hand_on, "HNDOFF": self._hand_off, "HNDSTS": self._hands,
            "IN": self._inputs, "OUT": self._outputs, "IOSIGNAL": self._signals,
        }  # fmt: skip

    def _hand_on(self, args: str, now_s: float, at_s: float) -> str:
        self._interpreter.switch_hand(number_of(args), is_open=True)
        return ""

    def _hand_off(self, args: str, now_s: float, at_s: float) -> str:
        self._interpreter.switch_hand(number_of(args), is_open=False)
        return ""

    def _hands(self, args: str, now_s: float, at_s: float) -> str:
        is_open = self._state.open_hands
        return records.print_hands(
            [
                records.HandState(_FIRST_HAND_OUTPUT + 2 * hand, 1 if hand + 1 in is_open else 2, 1)
                for hand in range(HANDS)
            ]
        )

    def _outputs(self, args: str, now_s: float, at_s: float) -> str:
        if args.startswith("="):
            first, word, width = _signal_write(args)
            for bit in range(width):
                self._interpreter.switch_output(first + bit, now_s, is_on=bool(word >> bit & 1))
            return ""
        return records.print_words(_word(self._state.outputs, _signal(args)))

    def _inputs(self, args: str, now_s: float, at_s: float) -> str:
        inputs = self._state.inputs
        if args.startswith("="):
            first, word, width = _signal_write(args)
            for bit in range(width):
                (inputs.add if word >> bit & 1 else inputs.discard)(first + bit)
            return ""
        return records.print_words(_word(inputs, _signal(args)))

    def _signals(self, args: str, now_s: float, at_s: float) -> str:
        first_input, semicolon, first_output = args.partition(";")
        if not semicolon:
            raise Refusal(tables.ARGUMENT_COUNT)
        return records.print_words(
            _word(self._state.inputs, _signal(first_input)),
            _word(self._state.outputs, _signal(first_output)),
        )


def _signal(text: str) -> int:
    """Return the number of a first signal.

    Raises:
        Refusal: It is no number, or 16 signals from there on are too many.
    """
    first = number_of(text)
    if first > OUTPUTS - 16:
        raise Refusal(tables.ARGUMENT_RANGE)
    return first


def _signal_write(args: str) -> tuple[int, int, int]:
    """Return first signal, word and width of `=<no>;<hhhh>` (16 wide) or `=<no>;<0 or 1>`."""
    first, semicolon, digits = args[1:].partition(";")
    if not semicolon:
        raise Refusal(tables.ARGUMENT_COUNT)
    if digits in ("0", "1"):
        return _signal(first), int(digits), 1
    try:
        if len(digits) != 4:
            raise Refusal(tables.ARGUMENT_TYPE)
        return _signal(first), int(digits, 16), 16
    except ValueError as error:
        raise Refusal(tables.ARGUMENT_TYPE) from error


def _word(signals: set[int], first: int) -> int:
    return sum([1 << bit for bit in range(16) if first + bit in signals])
