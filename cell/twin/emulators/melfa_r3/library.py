"""The controller's memory of programs, and the one that is being edited."""

from __future__ import annotations

from collections.abc import Mapping

from cell.drivers.melfa_r3 import tables
from cell.drivers.melfa_r3.program_text import (
    MAX_PROGRAM_LINES,
    GarbledLine,
    is_program_name,
    parse_line,
)
from cell.twin.emulators.melfa_r3.refusal import Refusal


class ProgramLibrary:
    """Programs by name; one of them may be open in the edit slot.

    What is edited counts only when it was saved; closing the session or cutting the power
    loses it, as a host that died in the middle of an upload expects.
    """

    def __init__(self, programs: Mapping[str, tuple[str, ...]]) -> None:
        self._programs = dict(programs)
        self._name = ""
        self._lines: dict[int, str] = {}
        self._is_changed = False

    @property
    def is_editing(self) -> bool:
        """Whether a program is open in the edit slot."""
        return bool(self._name)

    @property
    def is_changed(self) -> bool:
        """Whether the program in the edit slot differs from the saved one."""
        return self._is_changed

    def names(self) -> list[str]:
        """Return the names of all programs, in order."""
        return sorted(self._programs)

    def lines(self, name: str) -> tuple[str, ...] | None:
        """Return the statements of a program, without their numbers; None if there is none."""
        return self._programs.get(name)

    def begin(self, name: str) -> None:
        """Open a program for editing, an empty one if there is none of that name.

        Raises:
            Refusal: The name is none.
        """
        if not is_program_name(name):
            raise Refusal(tables.ARGUMENT_TYPE)
        self._name = name
        kept = self._programs.get(name, ())
        self._lines = {10 * place: line for place, line in enumerate(kept, 1)}
        self._is_changed = False

    def close(self) -> None:
        """Leave the edit slot; what was not saved is lost."""
        self._name = ""
        self._lines = {}
        self._is_changed = False

    def clear(self) -> None:
        """Empty the program in the edit slot.

        Raises:
            Refusal: None is open.
        """
        self._require_open()
        self._lines = {}
        self._is_changed = True

    def write(self, text: str) -> None:
        """Write one line, `<number> <statement>`; a line of that number is replaced.

        Raises:
            Refusal: No program is open, the text is no line, or the program is full.
        """
        self._require_open()
        try:
            number, statement = parse_line(text)
        except GarbledLine as error:
            raise Refusal(tables.SYNTAX) from error
        if number not in self._lines and len(self._lines) >= MAX_PROGRAM_LINES:
            raise Refusal(tables.ARGUMENT_COUNT)
        self._lines[number] = statement
        self._is_changed = True

    def save(self) -> str:
        """Keep the program in the edit slot; return its name.

        Raises:
            Refusal: None is open.
        """
        self._require_open()
        self._programs[self._name] = tuple(self._lines[number] for number in sorted(self._lines))
        self._is_changed = False
        return self._name

    def keep(self, name: str, lines: tuple[str, ...]) -> None:
        """Put a program into memory, in the place of one of that name."""
        self._programs[name] = lines

    def delete(self, name: str) -> None:
        """Forget a program.

        Raises:
            Refusal: There is none of that name.
        """
        if self._programs.pop(name, None) is None:
            raise Refusal(tables.NO_SUCH_PROGRAM)

    def _require_open(self) -> None:
        if not self._name:
            raise Refusal(tables.NO_PROGRAM)
