"""The reward rules of a goal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from dsl import nodes as n
from dsl.checks.values import finite, selector, whole
from dsl.diagnostics import Report
from dsl.program import Condition, Rule, Selector

MAX_STEP_COUNT = 1_000_000


def check_rules(goal: n.GoalNode, report: Report, *, is_whole: bool) -> tuple[Rule, ...]:
    """Return the rules of a goal, and report what is wrong with them and their order.

    Args:
        goal: The goal.
        report: Takes what is wrong.
        is_whole: Whether no rule was lost to a syntax problem.
    """
    nodes = [part for part in goal.parts if isinstance(part, n.RuleNode)]
    rules = [rule for rule in (_rule(node, report) for node in nodes) if rule is not None]
    if is_whole and len(rules) == len(nodes):
        _check_order(goal, nodes, rules, report)
    return tuple(rules)


def _rule(node: n.RuleNode, report: Report) -> Rule | None:
    condition = _condition(node.condition, report)
    reward: float | None = 0.0
    event: str | None = None
    status: Literal["running", "finished", "failed"] = "running"
    seen: set[str] = set()
    for effect in node.effects:
        group = "end" if effect.sort in ("finish", "fail") else effect.sort
        if group in seen:
            said = "`finish` or `fail`" if group == "end" else f"`{group}`"
            report.add("E204", effect.span, f"the rule has a {said} already", "remove one")
            continue
        seen.add(group)
        if effect.reward is not None:
            reward = finite(effect.reward, report)
        elif effect.text is not None:
            event = effect.text.value
            if not event.strip():
                report.add("E307", effect.text.span, "the event text is empty", "remove the event")
        else:
            status = "finished" if effect.sort == "finish" else "failed"
    if condition is None or reward is None:
        return None
    return Rule(condition, reward + 0.0, event, status, node.span)


def _condition(node: n.ConditionNode, report: Report) -> Condition | None:
    if node.blocks is not None:
        which = selector(node.blocks, report)
        return None if which is None else Condition("blocks", which)
    if node.steps is not None:
        steps = whole(node.steps, "the number of steps", 1, MAX_STEP_COUNT, report)
        return None if steps is None else Condition("steps", steps=steps)
    return Condition(node.sort)


def _check_order(
    goal: n.GoalNode, nodes: Sequence[n.RuleNode], rules: Sequence[Rule], report: Report
) -> None:
    for index, rule in enumerate(rules):
        for earlier, node in zip(rules[:index], nodes, strict=False):
            if _covers(earlier.condition, rule.condition):
                line = node.span.line
                message = f"this rule never applies: the one in line {line} comes first"
                report.add(
                    "W503", nodes[index].condition.span, message, "put it earlier or remove it"
                )
                break
    if not any(rule.condition.sort == "otherwise" for rule in rules):
        span = nodes[-1].span.after() if nodes else goal.name.span
        message = f"the goal {goal.name.text} has no `otherwise` rule"
        report.add("E504", span, message, "end with `otherwise reward 0`")
    elif all(rule.status == "running" for rule in rules):
        message = f"no rule of {goal.name.text} has `finish` or `fail`: it never ends"
        report.add("W505", goal.name.span, message, "put `finish` into the rule of the target")


def _covers(earlier: Condition, later: Condition) -> bool:
    """Whether the earlier condition holds whenever the later one does."""
    if earlier.sort == "otherwise" or earlier == later:
        return True
    if earlier.sort == "steps" and later.sort == "steps":
        return earlier.steps <= later.steps
    is_any_block = earlier.sort == "block" or earlier.selector == Selector(None, None)
    if is_any_block:
        return later.sort in ("block", "blocks", "target")
    if earlier.selector is None or later.selector is None:
        return False
    wide, narrow = earlier.selector, later.selector
    return wide.kind in (None, narrow.kind) and wide.colour in (None, narrow.colour)
