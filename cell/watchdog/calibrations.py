"""The test whether the cell's calibrations still hold: what it is offered, what it tells.

Who knows calibrations stands above `cell` and is handed in as a `CalibrationCheck`. This module
sees to everything around it: light, a lit screen, the arm out of the way, and afterwards the
screen as it was.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import Frame
from cell.errors import CellError
from cell.robot_cell import RobotCell
from cell.watchdog.components import ComponentTest, lights_if_possible

COMPONENT = "calibrations"


class CalibrationBroken(CellError):
    """Something has moved since it was calibrated."""


class CannotTell(CellError):
    """A test came to no result, though nothing failed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationWord:
    """What a check tells.

    Attributes:
        verdict: Whether all calibrations hold, something moved, or nobody can tell.
        text: What was seen, with figures.
        hint: What to do; empty if nothing.
    """

    verdict: Literal["holds", "moved", "cannot tell"]
    text: str
    hint: str = ""


class Sight(Protocol):
    """What a check may do with the cell."""

    def show_pixels(self, pixels: NDArray[np.uint8], name: str) -> None:
        """Show a picture of the panel's size.

        Raises:
            CellError: It cannot be shown, or the cell is needed for something else.
        """

    def grab(self, camera: str) -> Frame:
        """Return a new picture of a camera, 1280 x 960.

        Raises:
            CellError: There is none, or the cell is needed for something else.
        """


class CalibrationCheck(Protocol):
    """Checks the calibrations of a cell by what its cameras see of its screen."""

    def is_due(self) -> bool:
        """Return whether there is anything to check."""

    def look(self, sight: Sight) -> CalibrationWord:
        """Look and tell.

        Raises:
            CellError: A device fails, or the cell is needed for something else.
        """


def calibration_tests(
    cell: RobotCell, check: CalibrationCheck, go_on: Callable[[], None]
) -> tuple[ComponentTest, ...]:
    """Return the test of a cell's calibrations, none where there is nothing to check.

    Args:
        cell: The cell.
        check: Knows the calibrations.
        go_on: Raises `Stopped` when the cell is needed for something else.
    """
    profile = cell.profile
    if not profile.display.enabled or not check.is_due():
        return ()
    needs = ("arm", "display") if profile.arm.enabled else ("display",)

    def run(cell: RobotCell, pictures: list[Frame]) -> str:
        with _screen_in_view(cell):
            told = check.look(_CellSight(cell, pictures, go_on))
        text = told.text + (f"; {told.hint}" if told.hint else "")
        if told.verdict == "moved":
            raise CalibrationBroken(text)
        if told.verdict == "cannot tell":
            raise CannotTell(text)
        return text

    return (ComponentTest(COMPONENT, needs, run),)


class _CellSight:
    """Screen and cameras of a cell, asked before each use whether it may go on.

    The screen is used as it is, not by way of the cell, which would hold the arm until somebody
    looks after it when a picture does not come up.
    """

    def __init__(self, cell: RobotCell, pictures: list[Frame], go_on: Callable[[], None]) -> None:
        self._cell = cell
        self._pictures = pictures
        self._go_on = go_on

    def show_pixels(self, pixels: NDArray[np.uint8], name: str) -> None:
        self._go_on()
        self._cell.screen.show_pixels(pixels, name)

    def grab(self, camera: str) -> Frame:
        self._go_on()
        frame = self._cell.grab(camera, is_fresh=True)
        self._pictures.append(frame)
        return frame


@contextmanager
def _screen_in_view(cell: RobotCell) -> Iterator[None]:
    """Light the cell and its screen, bring the arm aside; afterwards all is as it was."""
    with ExitStack() as undo:
        is_lit = undo.enter_context(lights_if_possible(cell))
        undo.callback(cell.close_cameras)
        if is_lit:
            cell.arm.rest()
        undo.enter_context(_lit_display(cell))
        undo.callback(_quietly, cell.screen.bookmark())
        yield


@contextmanager
def _lit_display(cell: RobotCell) -> Iterator[None]:
    """Have the television show the computer's picture."""
    display, wanted = cell.display, cell.profile.display.input
    with ExitStack() as undo:
        undo.callback(_quietly, display.close)
        display.open()
        if not display.is_on():
            undo.callback(_quietly, display.switch_off)
            display.switch_on()
        shown: int | None = None
        with suppress(CellError):
            # A tuner has no number: there is nothing to go back to.
            shown = display.selected_input()
        if shown != wanted:
            display.select_input(wanted)
            if shown is not None:
                undo.callback(_quietly, _selecting(cell, shown))
        yield


def _selecting(cell: RobotCell, number: int) -> Callable[[], None]:
    return lambda: cell.display.select_input(number)


def _quietly(do: Callable[[], None]) -> None:
    """Do what puts something back; what fails there, the tests of the next round tell."""
    with suppress(CellError):
        do()
