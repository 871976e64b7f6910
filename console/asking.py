"""Asks a procedure's questions at the terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from console.exits import ConsoleError
from console.output import say, styled

if TYPE_CHECKING:
    from calibration.requests import Answer, Ask, Point, Value


class TerminalAsker:
    """Asks a person; implements `calibration.player.Asker`.

    Args:
        folder: Where pictures that are to be pointed at are written.
        read: Reads a line that follows a prompt; the terminal's unless given.
    """

    def __init__(self, folder: Path, read: Callable[[str], str] | None = None) -> None:
        self._folder = folder
        self._read = read or _read_line
        self._is_first = True

    def answer(self, ask: Ask) -> Answer:
        """Ask until the answer is one.

        Raises:
            ConsoleError: Nobody answers any more.
        """
        from calibration.answers import parse_words
        from calibration.errors import AnswerRefused

        self._tell_keys()
        say(_question(ask))
        while True:
            words = self._words(ask.key, _prompt(ask))
            if not words and ask.kind == "done":
                return True
            if not words and ask.default is not None:
                return ask.default
            try:
                return parse_words(ask, words)
            except AnswerRefused as refused:
                say(f"  {refused}", "yellow")

    def point(self, point: Point) -> Answer:
        """Write the picture to a file and ask for two numbers.

        Raises:
            ConsoleError: Nobody answers any more.
        """
        from calibration.answers import parse_point
        from calibration.errors import AnswerRefused
        from calibration.files import replace
        from calibration.pictures import encode_png

        path = self._folder / f"point-{point.key.replace('/', '-')}.png"
        replace(path, encode_png(point.picture.pixels))
        self._tell_keys()
        say(styled(point.question, "bold", sys.stderr))
        say(f"  look at {path}; columns u to the right, rows v down, in px from the upper left")
        guess = point.guess_px
        default = "" if guess is None else f" [{guess[0]:.1f} {guess[1]:.1f}]"
        while True:
            words = self._words(point.key, f"  u v{default}: ")
            if not words and guess is not None:
                return guess
            try:
                return parse_point(point, words)
            except AnswerRefused as refused:
                say(f"  {refused}", "yellow")

    def _tell_keys(self) -> None:
        """Tell before the first question what a person can type besides answers."""
        if self._is_first:
            self._is_first = False
            keys = "Enter takes what stands in [ ]; Ctrl-C stops safely, and --resume goes on there"
            say(styled(keys, "dim", sys.stderr))

    def _words(self, key: str, prompt: str) -> str:
        try:
            return self._read(prompt).strip()
        except EOFError as error:
            raise ConsoleError(
                f"{key}: nobody answers any more; `cell calibrate ... --resume` goes on here"
            ) from error


def ask_yes(question: str, read: Callable[[str], str] | None = None) -> bool:
    """Ask a person at the terminal; Enter alone means yes.

    Args:
        question: What is asked.
        read: Reads a line that follows a prompt; the terminal's unless given.

    Raises:
        ConsoleError: Nobody answers.
    """
    say(styled(question, "bold", sys.stderr))
    while True:
        try:
            words = (read or _read_line)("  (yes | no) [yes]: ").strip().lower()
        except EOFError as error:
            raise ConsoleError(f"nobody answers: {question}") from error
        if words in ("", "y", "yes"):
            return True
        if words in ("n", "no"):
            return False
        say(f"  yes or no is expected, not {words!r}", "yellow")


def _read_line(prompt: str) -> str:
    # The prompt goes to stderr, so that stdout holds data alone.
    print(prompt, end="", file=sys.stderr, flush=True)
    return input()


def _question(ask: Ask) -> str:
    return styled(ask.question, "bold", sys.stderr)


def _prompt(ask: Ask) -> str:
    parts = []
    if ask.unit:
        parts.append(f"in {ask.unit}")
    match ask.kind:
        case "choice":
            parts.append(" | ".join(ask.choices))
        case "yes":
            parts.append("yes | no")
        case "numbers":
            parts.append(f"{ask.count} numbers" if ask.count else "numbers")
        case "done":
            parts.append("Enter when it is done")
        case _:
            pass
    default = "" if ask.default is None else f" [{_shown(ask.default)}]"
    inside = f" ({', '.join(parts)})" if parts else ""
    return f"  {ask.key}{inside}{default}: "


def _shown(value: Value) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return " ".join(f"{one:g}" for one in value)
    return f"{value:g}" if isinstance(value, float) else str(value)
