"""Declarations that nothing uses."""

from __future__ import annotations

from dsl import nodes as n
from dsl.checks.scope import Scope
from dsl.diagnostics import Report


def check_usage(scope: Scope, report: Report) -> None:
    """Warn of actions and environments that nothing uses.

    Does nothing for a script with syntax problems, whose uses may be lost.
    """
    if scope.script.damage:
        return
    used_actions = {
        name.text
        for environment in scope.environments.values()
        for part in environment.parts
        if isinstance(part, n.ActionsNode)
        for name in part.names
    }
    for name, action in scope.actions.items():
        if name not in used_actions:
            message = f"no environment uses the action {name}"
            report.add("W601", action.name.span, message, "list it in `actions` or remove it")
    used_environments = {
        name.text
        for goal in scope.goals.values()
        for part in goal.parts
        if isinstance(part, n.InNode)
        for name in part.names
    }
    used_environments |= {e.base.text for e in scope.environments.values() if e.base is not None}
    for name, environment in scope.environments.items():
        if name not in used_environments:
            message = f"no goal offers the environment {name}"
            report.add(
                "W602", environment.name.span, message, "name it in a goal's `in` or remove it"
            )
