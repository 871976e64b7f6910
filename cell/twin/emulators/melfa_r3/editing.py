"""The commands that edit programs."""

from __future__ import annotations

from collections.abc import Callable

from cell.drivers.melfa_r3 import tables
from cell.drivers.melfa_r3.program_text import split_lines
from cell.twin.emulators.melfa_r3.library import ProgramLibrary
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.state import ControllerState

Handler = Callable[[str, float, float], str]

_EDITING = 0x1
_RUNNING = 0x2
_CHANGED = 0x4


class Editing:
    """Carries out NEW, LOAD, ECLR, EMDAT, EDATA, SAVE and FDEL.

    Attributes:
        handlers: What each command does; all take arguments and times and return data.
    """

    def __init__(
        self,
        library: ProgramLibrary,
        state: ControllerState,
        is_running: Callable[[float], bool],
    ) -> None:
        self._library = library
        self._state = state
        self._is_running = is_running
        self.handlers: dict[str, Handler] = {
            "NEW": self._new,
            "LOAD": self._load,
            "ECLR": self._clear,
            "EMDAT": self._write_lines,
            "EDATA": self._write_line,
            "SAVE": self._save,
            "FDEL": self._delete,
        }

    def status(self, *, is_running: bool) -> int:
        """Return the edit status of STATE."""
        library = self._library
        return (
            (_EDITING if library.is_editing else 0)
            | (_RUNNING if is_running else 0)
            | (_CHANGED if library.is_changed else 0)
        )

    def _new(self, args: str, now_s: float, at_s: float) -> str:
        self._library.close()
        return ""

    def _load(self, args: str, now_s: float, at_s: float) -> str:
        self._library.begin(args.removeprefix("="))
        return ""

    def _clear(self, args: str, now_s: float, at_s: float) -> str:
        self._library.clear()
        return ""

    def _write_lines(self, args: str, now_s: float, at_s: float) -> str:
        for line in split_lines(args):
            self._library.write(line)
        return ""

    def _write_line(self, args: str, now_s: float, at_s: float) -> str:
        self._library.write(args)
        return ""

    def _save(self, args: str, now_s: float, at_s: float) -> str:
        self._require_idle(now_s)
        self._library.save()
        return ""

    def _delete(self, args: str, now_s: float, at_s: float) -> str:
        self._require_idle(now_s)
        if args == self._state.program:
            raise Refusal(tables.BUSY)
        self._library.delete(args)
        return ""

    def _require_idle(self, now_s: float) -> None:
        if self._is_running(now_s):
            raise Refusal(tables.BUSY)
