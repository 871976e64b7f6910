"""From a script's text to what can be served."""

from __future__ import annotations

from dsl.compiler import compile_script
from dsl.render import render_diagnostics
from sessions.cell_script import CellScript
from sessions.errors import ScriptUnservable


def served_script(text: str, name: str) -> CellScript:
    """Compile a script for a session.

    Args:
        text: The script.
        name: Its file name.

    Raises:
        ScriptUnservable: It has mistakes; the text shows them.
    """
    compiled = compile_script(text, name)
    if compiled.program is None:
        shown = render_diagnostics(compiled.diagnostics, text, name)
        raise ScriptUnservable(f"{name} has mistakes and cannot be used:\n\n{shown}")
    return CellScript(name, text, compiled.program)
