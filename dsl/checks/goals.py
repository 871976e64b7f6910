"""Goals: where they are offered, start, target and rules."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from dsl import nodes as n
from dsl.checks.requirements import check_requirement
from dsl.checks.rules import check_rules
from dsl.checks.scope import Scope
from dsl.checks.values import accuracy, definite_selector, quarter_turn_deg, spot
from dsl.diagnostics import Report
from dsl.program import Goal, Spot, Target

Part = TypeVar("Part", n.InNode, n.StartNode, n.TargetNode, n.AccuracyNode)


def check_goals(scope: Scope, report: Report) -> dict[str, Goal]:
    """Return the goals that are right, by name."""
    found = {}
    for name, node in scope.goals.items():
        goal = _goal(scope, node, report)
        if goal is not None:
            found[name] = goal
    return found


def _goal(scope: Scope, node: n.GoalNode, report: Report) -> Goal | None:
    errors = report.count()
    is_whole = not scope.script.is_damaged(node)
    among = _once(node, n.InNode, "in", report)
    begin = _once(node, n.StartNode, "start", report)
    aim = _once(node, n.TargetNode, "target", report)
    demand = _once(node, n.AccuracyNode, "accuracy", report)
    limit = accuracy(demand, report) if demand else None
    environments = scope.known("environment", among.names if among else (), scope.environments)
    start = spot(begin.spot, report) if begin else Spot("corner", 0, 0, node.name.span)
    target = _target(aim, report) if aim else None
    requirements = [
        check_requirement(part, report, is_in_goal=True)
        for part in node.parts
        if isinstance(part, n.GapNode | n.DistanceNode | n.RegionNode)
    ]
    rules = check_rules(node, report, is_whole=is_whole)
    if is_whole:
        _report_missing(node, among, aim, report)
    if target is None or start is None or not is_whole or report.count() > errors:
        return None
    return Goal(
        name=node.name.text,
        environments=tuple(environments),
        start=start,
        target=target,
        requirements=tuple(r for r in requirements if r is not None),
        rules=rules,
        span=node.name.span,
        accuracy=limit,
    )


def _target(node: n.TargetNode, report: Report) -> Target | None:
    which = definite_selector(node.blocks, "the target", report)
    where = None if node.spot is None else spot(node.spot, report)
    yaw_deg = quarter_turn_deg(node.turn, report)
    if which is None or which.kind is None or which.colour is None:
        return None
    if node.spot is not None and where is None:
        return None
    return Target(which.kind, which.colour, where, yaw_deg, node.span)


def _report_missing(
    node: n.GoalNode, among: n.InNode | None, aim: n.TargetNode | None, report: Report
) -> None:
    wanted: Sequence[tuple[object, str, str]] = (
        (among, "in", "`in` and the environments that offer it"),
        (aim, "target", "`target cube red`"),
    )
    for part, word, example in wanted:
        if part is None:
            message = f"the goal {node.name.text} has no `{word}`"
            report.add("E205", node.name.span, message, f"such as {example}")


def _once(node: n.GoalNode, sort: type[Part], word: str, report: Report) -> Part | None:
    """Return the statement of a sort that may stand once; report any further ones."""
    parts = [part for part in node.parts if isinstance(part, sort)]
    for extra in parts[1:]:
        report.add("E204", extra.span, f"`{word}` stands twice in {node.name.text}", "remove one")
    return parts[0] if parts else None
