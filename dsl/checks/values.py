"""Numbers, units, kinds and colours: what stands for itself."""

from __future__ import annotations

import math

from dsl import nodes as n
from dsl.diagnostics import Report
from dsl.kinds import COLOURS, KINDS
from dsl.program import Accuracy, Relation, Selector, Spot
from dsl.words import did_you_mean, enumerate_words

MAX_COORDINATE = 999
"""Largest lattice coordinate that a script may write."""

MIN_ACCURACY_MM, MAX_ACCURACY_MM = 0.01, 100.0


def finite(number: n.Number, report: Report) -> float | None:
    """Return a number's value, or None with a report if it is too large."""
    if math.isfinite(number.value):
        return number.value
    report.add("E305", number.span, "the number is too large to represent", "write a smaller one")
    return None


def whole(number: n.Number, what: str, low: int, high: int, report: Report) -> int | None:
    """Return a whole number in a range, or None with a report."""
    value = finite(number, report)
    if value is None:
        return None
    if value != int(value):
        report.add("E302", number.span, f"{what} must be a whole number, not {value:g}")
        return None
    return None if not _is_in(number, what, value, low, high, "", report) else int(value)


def length_mm(number: n.Number, what: str, low: float, high: float, report: Report) -> float | None:
    """Return a length in a range, in millimetres, or None with a report."""
    return _measured(number, "mm", what, low, high, report)


def accuracy(node: n.AccuracyNode, report: Report) -> Accuracy | None:
    """Return how well the cell must be known, or None with a report."""
    limit_mm = length_mm(node.limit, "the accuracy", MIN_ACCURACY_MM, MAX_ACCURACY_MM, report)
    return None if limit_mm is None else Accuracy(limit_mm, node.span)


def quarter_turn_deg(number: n.Number | None, report: Report) -> float:
    """Return a turn by a multiple of 90 deg; 0 if there is none or it is wrong."""
    if number is None:
        return 0.0
    angle = _measured(number, "deg", "the turn", -180, 180, report)
    if angle is None:
        return 0.0
    if angle % 90:
        message = f"a block is turned by a multiple of 90 deg, not by {angle:g}"
        report.add("E301", number.span, message, "write 0, 90, -90 or 180 deg")
        return 0.0
    return angle + 0.0


def _measured(
    number: n.Number, unit: str, what: str, low: float, high: float, report: Report
) -> float | None:
    if number.unit is not None and number.unit.text != unit:
        message = f"{what} is in {unit}, not in {number.unit.text}"
        report.add("E209", number.unit.span, message, f"write `{unit}` or nothing")
        return None
    value = finite(number, report)
    if value is None or not _is_in(number, what, value, low, high, f" {unit}", report):
        return None
    return value


def _is_in(
    number: n.Number, what: str, value: float, low: float, high: float, unit: str, report: Report
) -> bool:
    if low <= value <= high:
        return True
    message = f"{what} is {value:g}{unit}, outside of {low:g} to {high:g}{unit}"
    report.add("E301", number.span, message)
    return False


def lattice_point(point: n.PointNode, report: Report) -> tuple[int, int] | None:
    """Return a lattice point, or None with a report."""
    x = whole(point.x, "the lattice x", -MAX_COORDINATE, MAX_COORDINATE, report)
    y = whole(point.y, "the lattice y", -MAX_COORDINATE, MAX_COORDINATE, report)
    return None if x is None or y is None else (x, y)


def spot(node: n.SpotNode, report: Report) -> Spot | None:
    """Return a spot, or None with a report."""
    if isinstance(node, n.RandomNode):
        return Spot("random", 0, 0, node.span)
    if isinstance(node, n.CornerNode):
        return Spot("corner", int(node.is_right), int(node.is_upper), node.span)
    point = lattice_point(node, report)
    return None if point is None else Spot("point", *point, node.span)


def selector(blocks: n.Blocks, report: Report) -> Selector | None:
    """Return which blocks are meant, or None with a report."""
    kind, colour = blocks.kind, blocks.colour
    is_good = True
    if kind is not None and kind.text not in KINDS:
        is_good = False
        hint = did_you_mean(kind.text, KINDS)
        if kind.text in COLOURS:
            other = "any" if colour is None or colour.text not in KINDS else colour.text
            hint = f"the kind comes before the colour: `{other} {kind.text}`"
        report.add("E206", kind.span, f"`{kind.text}` is no kind of block", hint)
    if colour is not None and colour.text not in COLOURS and (is_good or colour.text not in KINDS):
        is_good = False
        hint = did_you_mean(colour.text, COLOURS)
        report.add("E207", colour.span, f"`{colour.text}` is no colour", hint)
    if not is_good:
        return None
    return Selector(kind.text if kind else None, colour.text if colour else None)


def definite_selector(blocks: n.Blocks, what: str, report: Report) -> Selector | None:
    """Return which one sort of block is meant, or None with a report."""
    found = selector(blocks, report)
    if found is None or found.is_definite:
        return found
    parts = [p for p, v in (("a kind", found.kind), ("a colour", found.colour)) if v is None]
    missing = enumerate_words(parts, "and")
    report.add("E205", blocks.span, f"{what} needs {missing}", "such as `cube red`")
    return None


def relation(node: n.RelationNode, report: Report) -> Relation | None:
    """Return a comparison, or None with a report."""
    limit = whole(node.limit, "the limit", 0, 2 * MAX_COORDINATE, report)
    return None if limit is None else Relation(node.sign, limit)
