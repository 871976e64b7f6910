"""The television kept in service: switched on, on its input, connected again when it was lost."""

from __future__ import annotations

from cell.devices.display import Display
from cell.errors import CellError, DeviceError, DeviceTimeout
from cell.reporting import FaultReporter


class DisplayKeeper:
    """Sees to it that the television shows its input.

    Args:
        display: The television.
        number: The input that shows the computer's picture.
        reporter: Told when something had to be put right.
    """

    def __init__(self, display: Display, number: int, reporter: FaultReporter) -> None:
        self._display = display
        self._number = number
        self._reporter = reporter

    def ensure_shown(self) -> None:
        """Return when the set is on and on its input.

        Raises:
            DeviceError: It does not let itself be switched, or does not answer.
            LinkError: It is not connected.
        """
        try:
            done = self._put_right()
        except CellError:
            self._display.close()
            self._display.open()
            # A set that was just given its power back is on, and takes no commands yet.
            self._display.switch_on()
            done = ("connected again", *self._put_right())
        if done:
            self._reporter.recovered("display", ", ".join(done))

    def _put_right(self) -> tuple[str, ...]:
        done: list[str] = []
        if not self._display.is_on():
            self._display.switch_on()
            done.append("switched on")
        if not self._shows_input():
            self._display.select_input(self._number)
            done.append(f"input {self._number} selected")
        return tuple(done)

    def _shows_input(self) -> bool:
        try:
            return self._display.selected_input() == self._number
        except DeviceTimeout:
            raise
        except DeviceError:
            # What is shown has no number: the tuner.
            return False
