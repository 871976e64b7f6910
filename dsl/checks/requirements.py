"""The `require` statements of environments and goals."""

from __future__ import annotations

from dsl import nodes as n
from dsl.checks.values import lattice_point, relation, selector
from dsl.diagnostics import Report
from dsl.program import Distance, Gap, Party, Region, Requirement


def check_requirement(
    node: n.RequireNode, report: Report, *, is_in_goal: bool
) -> Requirement | None:
    """Return what a `require` asks for, or None with a report."""
    if isinstance(node, n.RegionNode):
        return _region(node, report)
    compared = relation(node.relation, report)
    if isinstance(node, n.GapNode):
        return None if compared is None else Gap(compared, node.span)
    first = _party(node.first, report, is_in_goal=is_in_goal)
    second = _party(node.second, report, is_in_goal=is_in_goal)
    if first is None or second is None or compared is None:
        return None
    return Distance(first, second, compared, node.span)


def _party(node: n.PartyNode, report: Report, *, is_in_goal: bool) -> Party | None:
    if node.blocks is not None:
        found = selector(node.blocks, report)
        return None if found is None else Party("blocks", found)
    if not is_in_goal:
        message = f"an environment knows no {node.role}"
        report.add("E108", node.span, message, "put this requirement into a goal")
        return None
    return Party(node.role, None)


def _region(node: n.RegionNode, report: Report) -> Region | None:
    which = selector(node.blocks, report)
    first, second = lattice_point(node.corner, report), lattice_point(node.opposite, report)
    if which is None or first is None or second is None:
        return None
    return Region(
        which,
        node.is_inside,
        min(first[0], second[0]),
        min(first[1], second[1]),
        max(first[0], second[0]),
        max(first[1], second[1]),
        node.span,
    )
