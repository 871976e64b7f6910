"""Small scripts for tests, put together from parts."""

from __future__ import annotations

from dsl.compiler import compile_script
from dsl.program import Program
from dsl.render import render_diagnostics

STORE = """
store toys {
  slot 11 cube red at (0, 0)       slot 3 cube red at (100, 0)
  slot 4 cube blue at (200, 0)     slot 5 cube blue at (300, 0)
  slot 6 cylinder green at (400, 0) slot 7 bridge green at (600, 0)
}
"""
ACTIONS = """
action UP { move (0, 1) }  action DOWN { move (0, -1) }
action RIGHT { move (1, 0) }  action LEFT { move (-1, 0) }
"""
RULES = """
  when hit wall reward -10 event "wall"
  when above target reward 20 event "there" finish
  otherwise reward 0
"""


def script(
    environment: str = "place cube red at (3, 3)",
    goal: str = "target cube red",
    *,
    world: str = "4 x 4",
    actions: str = "UP, DOWN, RIGHT, LEFT",
    rules: str = RULES,
    declarations: str = STORE + ACTIONS,
) -> str:
    """Return a script with one environment E and one goal G."""
    return (
        f"{declarations}environment E {{\nworld {world} actions {actions}\n{environment}\n}}\n"
        f"goal G {{\nin E\n{goal}\n{rules}\n}}\n"
    )


def program(text: str) -> Program:
    """Compile a script that must be right."""
    compiled = compile_script(text, "test")
    if compiled.program is None:
        raise AssertionError(render_diagnostics(compiled.diagnostics, text, "test"))
    return compiled.program
