"""Finds a script by path or by the name of a shipped one, and shows what is wrong with it."""

from __future__ import annotations

import sys
from pathlib import Path

from console.exits import ConsoleError, Exit
from console.output import has_colour
from dsl.compiler import compile_script
from dsl.library import library_names, library_script
from dsl.render import render_diagnostics
from sessions.cell_script import CellScript


def read_script(name: str) -> tuple[str, str]:
    """Return file name and text of a script.

    Args:
        name: Path of a script, or the name of a shipped one, with or without `.cell`.

    Raises:
        ConsoleError: There is no such script, or it cannot be read.
    """
    path = Path(name)
    shipped = name.removesuffix(".cell")
    if not path.exists() and shipped in library_names():
        return f"{shipped}.cell", library_script(shipped)
    try:
        return path.name, path.read_text("utf-8")
    except FileNotFoundError as error:
        raise ConsoleError(
            f"there is no script {name}; shipped are {', '.join(library_names())}"
        ) from error
    except UnicodeDecodeError as error:
        raise ConsoleError(f"{name} is not UTF-8 text (byte {error.start})", Exit.FAILED) from error
    except OSError as error:
        raise ConsoleError(f"{name} cannot be read: {error.strerror}") from error


def load_script(name: str) -> CellScript:
    """Return a script that is fit to be served; mistakes are shown on stderr.

    Raises:
        ConsoleError: There is no such script, or it has mistakes.
    """
    file_name, text = read_script(name)
    compiled = compile_script(text, file_name)
    if compiled.program is None:
        colour = has_colour(sys.stderr)
        shown = render_diagnostics(compiled.diagnostics, text, file_name, colour=colour)
        print(shown, file=sys.stderr)
        raise ConsoleError(f"{file_name} has mistakes and cannot be served", Exit.FAILED)
    return CellScript(file_name, text, compiled.program)
