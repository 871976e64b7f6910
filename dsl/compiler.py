"""From text to program: parse, lower, check. Never raises for a bad script."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

from dsl import nodes as n
from dsl.checks.basics import check_actions, check_store
from dsl.checks.environments import check_environments
from dsl.checks.goals import check_goals
from dsl.checks.layouts import check_layouts
from dsl.checks.scope import Scope
from dsl.checks.usage import check_usage
from dsl.diagnostics import Diagnostic, Report
from dsl.lower import lower
from dsl.parser import parse
from dsl.program import Program


@dataclass(frozen=True, slots=True)
class Compiled:
    """What became of a script.

    Attributes:
        program: The program, or None if there is any error.
        diagnostics: Every finding, in the order of the source.
        script: The script's nodes, as far as it could be read.
    """

    program: Program | None
    diagnostics: tuple[Diagnostic, ...]
    script: n.Script


def compile_script(text: str, name: str) -> Compiled:
    """Compile a script.

    Args:
        text: The script.
        name: What it is called in messages, such as its file name.
    """
    report = Report()
    script = lower(parse(text, report), report)
    program = check_script(script, name, report)
    is_good = report.count() == 0
    return Compiled(program if is_good else None, report.diagnostics(), script)


def check_script(script: n.Script, name: str, report: Report) -> Program:
    """Check a script's nodes and return what they mean, as far as it makes sense.

    The result is fit to run only if the report has no error.
    """
    scope = Scope(script, report)
    store = check_store(scope, report)
    actions = check_actions(scope, report)
    environments = check_environments(scope, report)
    goals = check_goals(scope, report)
    offered = {
        goal_name: goal
        for goal_name, goal in goals.items()
        if all(environment in environments for environment in goal.environments)
    }
    store_node = next(iter(scope.stores.values()), None)
    is_store_whole = store_node is None or (
        not script.is_damaged(store_node) and len(store.slots) == len(store_node.parts)
    )
    if is_store_whole and not (store_node is None and _mentions_store(script)):
        check_layouts(store, actions, environments, offered, report)
    check_usage(scope, report)
    return Program(
        name,
        store,
        MappingProxyType(actions),
        MappingProxyType(environments),
        MappingProxyType(goals),
    )


def _mentions_store(script: n.Script) -> bool:
    return any(sort == "store" for sort, _ in script.mentioned)
