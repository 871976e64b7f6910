"""Everything the controller offers besides moving: right, servos, programs, signals, values."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from cell.drivers.melfa_r3 import records
from cell.drivers.melfa_r3.dialogue import Dialogue
from cell.drivers.melfa_r3.statements import (
    SelectTool,
    Statement,
    SwitchHand,
    SwitchOutput,
    print_statement,
)
from cell.drivers.melfa_r3.tables import UNKNOWN_COMMAND
from cell.errors import DeviceError

Record = TypeVar("Record")

_MAX_PROGRAMS = 999
_LEFTOVERS = "the controller took the first request for something else; its line held leftovers"


class ControlPanel:
    """The verbs of the command table, one method each, without waiting for anything.

    Every method raises `DeviceError` when the controller refuses or answers
    nonsense and `DeviceTimeout` when it does not answer.
    """

    def __init__(self, dialogue: Dialogue) -> None:
        self._dialogue = dialogue

    # Session, right and servos

    def open_session(self, client: str) -> records.Identity:
        """Open a session and return who the controller is.

        What was in its line before, such as half a request of another program or bytes at a
        wrong speed, makes the first request no command; the refused line is its end, so the
        second is clean.
        """
        try:
            return self._read(records.parse_identity, "OPEN", f"={client}")
        except DeviceError as error:
            if error.code != UNKNOWN_COMMAND:
                raise
        self._dialogue.on_repeat(self._dialogue.device, _LEFTOVERS)
        return self._read(records.parse_identity, "OPEN", f"={client}")

    def close_session(self) -> None:
        """End the session."""
        self._dialogue.ask("CLOSE")

    def take_right(self) -> None:
        """Take the operation right."""
        self._dialogue.ask("CNTLON")

    def give_right_back(self) -> None:
        """Give the operation right back."""
        self._dialogue.ask("CNTLOFF")

    def switch_servos(self, *, is_on: bool) -> None:
        """Switch the servos; they take some seconds to come on."""
        self._dialogue.ask("SRVON" if is_on else "SRVOFF")

    # State

    def state(self) -> records.FullState:
        """Return the whole state."""
        return self._read(records.parse_full_state, "STATE")

    def short_state(self) -> records.ShortState:
        """Return status bits and error only."""
        return self._read(records.parse_short_state, "DSTATE")

    def stop_sources(self) -> records.StopSources:
        """Return who holds the arm with a stop or an emergency stop."""
        return self._read(records.parse_stop_sources, "STPSIG")

    def alarm(self) -> int:
        """Return the number of the active alarm, 0 for none."""
        return self._dialogue.active_alarm()

    def alarm_text(self, number: int) -> str:
        """Return the controller's own text of an error number."""
        return self._dialogue.ask("ERRORMES", str(number)).strip()

    def last_alarm(self) -> tuple[str, ...]:
        """Return the fields of the latest entry in the history of alarms."""
        return tuple(self._dialogue.ask("ERRORRD").split(";"))

    def reset_alarm(self) -> None:
        """Reset the active alarm."""
        self._dialogue.ask("RSTALRM")

    # Override, values and parameters

    def override(self) -> int:
        """Return the override in percent."""
        return self._read(records.parse_percent, "OVRD")

    def set_override(self, percent: int) -> None:
        """Set the override, 1 to 100 percent.

        Raises:
            DeviceError: The figure is out of range, or the controller took another one.
        """
        if not 1 <= percent <= 100:
            raise DeviceError(
                self._dialogue.device,
                f"an override of {percent} % was asked for",
                hint="use 1 to 100 %",
            )
        accepted = self._read(records.parse_percent, "OVRD", f"={percent}")
        if accepted != percent:
            raise DeviceError(
                self._dialogue.device,
                f"the controller took an override of {accepted} % for {percent} %",
                hint="check the override on the operation panel",
            )

    def variable(self, name: str) -> str:
        """Return the value of a variable as the controller prints it."""
        return self._read(records.parse_variable, "VAL", name)[1]

    def set_variable(self, name: str, value: str) -> None:
        """Assign a value in MELFA-BASIC notation to a variable of the loaded program."""
        self._dialogue.ask("VAL", f"={name}={value}")

    def parameter(self, name: str) -> tuple[str, ...]:
        """Return the values of a parameter, such as MEJAR."""
        return self._read(records.parse_parameter, "PNR", name)[1]

    # Programs

    def programs(self) -> tuple[str, ...]:
        """Return the names of the programs in the controller."""
        names: list[str] = []
        entry = self._dialogue.ask("PDIR", "<")
        while entry and len(names) < _MAX_PROGRAMS:
            names.append(entry.split(";", 1)[0].rsplit(".", 1)[0])
            entry = self._dialogue.ask("PDIR", f"{len(names):02d}")
        return tuple(names)

    def load_program(self, name: str) -> None:
        """Select a program in the slot."""
        self._dialogue.ask("PRGLOAD", f"={name}")

    def run_program(self, name: str = "", *, is_cyclic: bool = True) -> None:
        """Start a program for one cycle or for ever; without a name the loaded one goes on."""
        self._dialogue.ask("RUN", f"{name};{int(is_cyclic)}" if name else "")

    def reset_program(self) -> None:
        """Put the program in the slot back to its start."""
        self._dialogue.ask("RSTPRG")

    def restart(self) -> None:
        """Restart the controller; the session ends, and it takes a while to come back."""
        self._dialogue.ask("RSTPWR")

    def reset_slots(self) -> None:
        """Put all slots back to their start."""
        self._dialogue.ask("SLOTINIT")

    # Direct statements, hands and signals

    def execute(self, statement: Statement) -> None:
        """Execute one statement, when an earlier move is over."""
        self._dialogue.ask_when_free("EXEC", print_statement(statement))

    def select_tool(self, number: int) -> None:
        """Select a tool by number."""
        self.execute(SelectTool(number))

    def move_hand(self, hand: int, *, is_open: bool) -> None:
        """Open or close a hand."""
        self.execute(SwitchHand(hand, is_open))

    def hands(self) -> tuple[records.HandState, ...]:
        """Return the hands that are fitted."""
        hands = self._read(records.parse_hands, "HNDSTS")
        return tuple([hand for hand in hands if hand.output >= 0])

    def switch_output(self, bit: int, *, is_on: bool) -> None:
        """Switch one output."""
        self.execute(SwitchOutput(bit, is_on))

    def outputs(self, first: int) -> int:
        """Return 16 outputs from number `first`, which is bit 0."""
        return self._read(records.parse_word, "OUT", str(first))

    def set_outputs(self, first: int, word: int) -> None:
        """Force 16 outputs from number `first`, which is bit 0."""
        self._dialogue.ask("OUT", f"={first};{word & 0xFFFF:04X}")

    def inputs(self, first: int) -> int:
        """Return 16 inputs from number `first`, which is bit 0."""
        return self._read(records.parse_word, "IN", str(first))

    def set_pseudo_inputs(self, first: int, word: int) -> None:
        """Set 16 pseudo-inputs from number `first`, which is bit 0."""
        self._dialogue.ask("IN", f"={first};{word & 0xFFFF:04X}")

    def signals(self, first_input: int, first_output: int) -> tuple[int, int]:
        """Return 16 inputs and 16 outputs at once."""
        return self._read(records.parse_word_pair, "IOSIGNAL", f"{first_input};{first_output}")

    # Positions

    def axes(self, command: str, args: str = "") -> records.AxisReport:
        """Return what PPOSF, JPOSF, PPOS or JPOS reports."""
        return self._read(records.parse_axes, command, args)

    def _read(self, parse: Callable[[str], Record], command: str, args: str = "") -> Record:
        return self._dialogue.read(parse, command, args)
