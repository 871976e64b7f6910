"""The entry point `cell`: finds the command, and is the edge at which every error ends."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from console.commands import COMMANDS, overview
from console.edge import guarded
from console.exits import Exit

if TYPE_CHECKING:
    from cyclopts import App, CycloptsError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    return guarded(lambda: _run(words))


def _run(words: list[str]) -> int:
    if words in ([], ["--help"], ["-h"], ["help"]):
        sys.stdout.write(overview())
        return Exit.DONE if words else Exit.USAGE
    if words == ["--version"]:
        from importlib.metadata import version

        print(f"robocell {version('robocell')}")
        return Exit.DONE
    return _dispatch(words)


def command_line() -> App:
    """Return the parser of all commands; nothing of what they need is imported yet."""
    from cyclopts import App

    app = App(
        name="cell",
        version="",
        help_formatter="plain",
        help_format="plaintext",
        exit_on_error=False,
        print_error=False,
        suppress_keyboard_interrupt=False,
        result_action="return_value",
    )
    for command in COMMANDS:
        app.command(command.target, name=command.name, help=command.summary)
    return app


def _dispatch(words: list[str]) -> int:
    from cyclopts import CycloptsError

    try:
        result = command_line()(words)
    except CycloptsError as error:
        sentence = " ".join(_sentence(error).split())
        print(f"cell: {sentence}", file=sys.stderr)
        print(
            "`cell --help` lists the commands, `cell COMMAND --help` their options.",
            file=sys.stderr,
        )
        return Exit.USAGE
    return result if isinstance(result, int) else Exit.DONE


def _sentence(error: CycloptsError) -> str:
    """Return what is wrong, with the name of the value where the parser leaves it out."""
    from cyclopts import CoercionError

    if (
        isinstance(error, CoercionError)
        and error.msg is not None
        and error.argument is not None
        and (error.token is None or error.token.keyword is None)
    ):
        return f"Invalid value for {error.argument.name.lstrip('-').upper()}: {error}"
    return str(error)
