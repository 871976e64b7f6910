"""How the emulated controller says no."""

from __future__ import annotations

from cell.errors import CellError


class Refusal(CellError):
    """A request that the emulated controller turns down; never leaves the emulator.

    Attributes:
        number: The error number it answers with.
        is_alarm: Whether it raises an alarm of that number too.
    """

    def __init__(self, number: int, *, is_alarm: bool = False) -> None:
        self.number = number
        self.is_alarm = is_alarm
        super().__init__(f"refused with {number:04d}")
