"""Writes and deletes programs in the controller's memory."""

from __future__ import annotations

from collections.abc import Sequence

from cell.drivers.melfa_r3.codec import UnsendableRequest
from cell.drivers.melfa_r3.dialogue import Dialogue
from cell.drivers.melfa_r3.program_text import (
    is_program_name,
    join_lines,
    print_lines,
)
from cell.errors import CellError

EDIT_SLOT = 9
"""The slot in which programs are edited; TASKMAX + 1 on controllers with more tasks."""


class ProgramEditor:
    """The controller's program memory; needs an open session.

    An upload that fails is not saved: the program stays as it was.
    """

    def __init__(self, dialogue: Dialogue, edit_slot: int = EDIT_SLOT) -> None:
        self._dialogue = dialogue
        self._slot = edit_slot

    def write(self, name: str, statements: Sequence[str]) -> None:
        """Write a program, in place of one that has the name.

        Args:
            name: Up to 12 letters, digits and underscores.
            statements: MELFA-BASIC without line numbers.

        Raises:
            UnsendableRequest: Name or a statement cannot be sent; nothing was changed.
            DeviceError: The controller refused; nothing was saved.
        """
        self._require_name(name)
        lines = print_lines(statements)
        self._ask("NEW")
        try:
            self._ask("LOAD", f"={name}")
            self._ask("ECLR")
            for packed in join_lines(lines):
                self._ask("EMDAT", packed)
            self._ask("SAVE")
        except CellError:
            self._ask("NEW")
            raise

    def write_line(self, name: str, number: int, statement: str) -> None:
        """Write or replace one line of a program.

        Raises:
            UnsendableRequest: Name or statement cannot be sent; nothing was changed.
            DeviceError: The controller refused; nothing was saved.
        """
        self._require_name(name)
        self._ask("LOAD", f"={name}")
        self._ask("EDATA", f" {number} {statement}")
        self._ask("SAVE")

    def delete(self, name: str) -> None:
        """Delete a program.

        Raises:
            UnsendableRequest: The name is none.
            DeviceError: There is none of that name.
        """
        self._require_name(name)
        self._ask("FDEL", name)

    def _require_name(self, name: str) -> None:
        if not is_program_name(name):
            raise UnsendableRequest(
                f"{name!r} is no name of a program; up to 12 capital letters, digits and "
                "underscores are possible",
                device=self._dialogue.device,
            )

    def _ask(self, command: str, args: str = "") -> None:
        self._dialogue.ask(command, args, slot=self._slot)
