"""The store and the actions."""

from __future__ import annotations

from itertools import combinations, islice

from dsl import nodes as n
from dsl.checks.scope import Scope
from dsl.checks.values import definite_selector, length_mm, whole
from dsl.diagnostics import Report
from dsl.kinds import clash, shape_of
from dsl.program import Action, Slot, Store

MAX_SLOTS = 64
MAX_SLOT_NUMBER = 9999
MAX_PLAN_MM = 2000.0
MAX_STEPS = 99


def check_store(scope: Scope, report: Report) -> Store:
    """Return the script's store; an empty one if it declares none."""
    nodes = list(scope.stores.values())
    if not nodes:
        return Store("", ())
    for extra in islice(nodes, 1, None):
        message = f"the script has a store already, {nodes[0].name.text}"
        report.add("E201", extra.name.span, message, "a script has one store")
    node = nodes[0]
    if len(node.parts) > MAX_SLOTS:
        message = f"the store has {len(node.parts)} slots, more than {MAX_SLOTS}"
        report.add("E301", node.name.span, message)
        return Store(node.name.text, ())
    slots: dict[int, Slot] = {}
    for part in node.parts:
        slot = _slot(part, report)
        if slot is None:
            continue
        earlier = slots.setdefault(slot.number, slot)
        if earlier is not slot:
            message = f"slot {slot.number} is in line {earlier.span.line} already"
            report.add("E201", part.number.span, message, "give it another number")
    _check_room(list(slots.values()), report)
    return Store(node.name.text, tuple(slots.values()))


def _slot(node: n.SlotNode, report: Report) -> Slot | None:
    number = whole(node.number, "a slot's number", 1, MAX_SLOT_NUMBER, report)
    selector = definite_selector(node.blocks, "a slot", report)
    x = length_mm(node.x, "the slot's x", 0, MAX_PLAN_MM, report)
    y = length_mm(node.y, "the slot's y", 0, MAX_PLAN_MM, report)
    if number is None or selector is None or x is None or y is None:
        return None
    return Slot(number, selector.kind or "", selector.colour or "", x, y, node.span)


def _check_room(slots: list[Slot], report: Report) -> None:
    """Report slots whose blocks are in each other's way; lengths lie along plan x."""
    for first, second in combinations(slots, 2):
        across, along = second.y_mm - first.y_mm, second.x_mm - first.x_mm
        if abs(across) > 140 or abs(along) > 140:
            continue
        trouble = clash(shape_of(first.kind, 0), shape_of(second.kind, 0), across, along)
        if trouble is None:
            continue
        what = "overlap" if trouble == "overlap" else "leave no room for the fingers"
        message = f"the blocks of slots {first.number} and {second.number} {what}"
        report.add("E408", second.span, message, "move one of them")


def check_actions(scope: Scope, report: Report) -> dict[str, Action]:
    """Return the actions that are right, by name."""
    found = {}
    for name, node in scope.actions.items():
        action = _action(scope, node, report)
        if action is not None:
            found[name] = action
    return found


def _action(scope: Scope, node: n.ActionNode, report: Report) -> Action | None:
    if not node.parts:
        if not scope.script.is_damaged(node):
            message = f"the action {node.name.text} has no `move`"
            report.add("E205", node.name.span, message, "such as `move (0, 1)`")
        return None
    for extra in node.parts[1:]:
        report.add("E204", extra.span, "an action moves once", "remove one `move`")
    steps = node.parts[0].steps
    dx = whole(steps.x, "the move's x", -MAX_STEPS, MAX_STEPS, report)
    dy = whole(steps.y, "the move's y", -MAX_STEPS, MAX_STEPS, report)
    if dx is None or dy is None:
        return None
    if dx == dy == 0:
        report.add("E301", steps.span, "the move goes nowhere", "one of its numbers must not be 0")
        return None
    return Action(node.name.text, dx, dy, node.span)
