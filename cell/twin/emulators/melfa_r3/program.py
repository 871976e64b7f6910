"""Runs the program that is selected in the slot."""

from __future__ import annotations

from collections.abc import Callable

from cell.drivers.melfa_r3 import tables
from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.drivers.melfa_r3.statements import parse_statement
from cell.twin.emulators.melfa_r3.interpreter import Interpreter
from cell.twin.emulators.melfa_r3.library import ProgramLibrary
from cell.twin.emulators.melfa_r3.refusal import Refusal


class ProgramRunner:
    """Executes a program's lines one after the other, each when the last motion is over.

    Attributes:
        is_running: Whether the program runs.
        line: Index of the next line.
    """

    def __init__(
        self,
        library: ProgramLibrary,
        interpreter: Interpreter,
        is_moving: Callable[[float], bool],
    ) -> None:
        self._library = library
        self._interpreter = interpreter
        self._is_moving = is_moving
        self._lines: tuple[str, ...] = ()
        self._is_cyclic = True
        self.is_running = False
        self.line = 0

    def load(self, name: str) -> None:
        """Select a program and put it to its start.

        Raises:
            Refusal: There is no such program.
        """
        lines = self._library.lines(name)
        if lines is None:
            raise Refusal(tables.NO_SUCH_PROGRAM)
        self._lines = lines
        self.reset()

    def reset(self) -> None:
        """Put the program to its start, standing."""
        self.is_running = False
        self.line = 0

    def start(self, *, is_cyclic: bool) -> None:
        """Start, or go on from where it stands."""
        self.is_running = True
        self._is_cyclic = is_cyclic

    def advance(self, now_s: float) -> None:
        """Execute whatever is due.

        A program that repeats gets through its lines once at most, so that one
        without motion cannot keep the controller for ever.

        Raises:
            Refusal: A line cannot be executed; the program stands at it.
        """
        for _ in range(len(self._lines) + 1):
            if not self.is_running or self._is_moving(now_s):
                return
            if self.line >= len(self._lines):
                self.line = 0
                self.is_running = not self._is_cyclic
                continue
            self._execute(self._lines[self.line], now_s)
            self.line += 1

    def _execute(self, line: str, now_s: float) -> None:
        try:
            self._interpreter.execute(parse_statement(line), now_s, now_s)
        except GarbledMessage as error:
            self.is_running = False
            raise Refusal(tables.SYNTAX, is_alarm=True) from error
        except Refusal as refusal:
            self.is_running = False
            raise Refusal(refusal.number, is_alarm=True) from refusal
