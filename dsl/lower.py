"""From lark's tree to nodes. Nothing after this module knows lark.

Finds out what a text or number says; whether that makes sense is for `dsl.checks`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, cast

from dsl import nodes as n
from dsl.parser import Parsed
from dsl.syntax_errors import token_span
from dsl.words import LATER_WORDS

if TYPE_CHECKING:
    from lark import Token, Tree

    from dsl.diagnostics import Report
    from dsl.spans import Span

    Child = Token | Tree[Token]

_CONTROL = re.compile(r"[\x00-\x1f\x7f]")
_ESCAPE = re.compile(r"\\(.?)")


def lower(parsed: Parsed, report: Report) -> n.Script:
    """Turn a syntax tree into nodes.

    Args:
        parsed: What the parser made of the text.
        report: Has the syntax problems; takes those of texts and names.
    """
    lowering = _Lowering(report)
    trees = [] if parsed.tree is None else _trees(parsed.tree)
    makers: dict[str, Callable[[Tree[Token]], n.Declaration]] = {
        "store": lowering.store,
        "action": lowering.action,
        "environment": lowering.environment,
        "goal": lowering.goal,
    }
    declarations = tuple(makers[tree.data](tree) for tree in trees)
    damage = tuple(d.span.start for d in report.diagnostics() if d.severity == "error")
    return n.Script(declarations, parsed.mentioned, damage)


def _trees(tree: Tree[Token]) -> list[Tree[Token]]:
    """Return the children that are trees."""
    return [c for c in tree.children if not isinstance(c, str)]


def _tokens(tree: Tree[Token], terminal: str) -> list[Token]:
    """Return the children that are tokens of one terminal."""
    return [c for c in tree.children if isinstance(c, str) and c.type == terminal]


def _has(tree: Tree[Token], terminal: str) -> bool:
    return bool(_tokens(tree, terminal))


def _span(tree: Tree[Token]) -> Span:
    """Return where a tree stands: from its first token to its last."""
    first: Child = tree
    while not isinstance(first, str):
        first = first.children[0]
    last: Child = tree
    while not isinstance(last, str):
        last = last.children[-1]
    return token_span(first).to(token_span(last))


class _Lowering:
    """Makes nodes; one method for each rule of the grammar."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._parts: dict[str, Callable[[Tree[Token]], object]] = {
            "world": self.world,
            "background": self.background,
            "travel": self.travel,
            "accuracy": self.accuracy,
            "views": self.views,
            "actions": self.actions,
            "teaching": self.teaching,
            "nothing": lambda tree: n.NothingNode(_span(tree)),
            "place": self.place,
            "among": self.among,
            "begin": self.begin,
            "target": self.target,
            "rule": self.rule,
            "require_gap": self.require_gap,
            "require_distance": self.require_distance,
            "require_region": self.require_region,
        }

    # ------------------------------------------------------------ declarations

    def store(self, tree: Tree[Token]) -> n.StoreNode:
        slots = tuple(self.slot(t) for t in _trees(tree))
        return n.StoreNode(self.name(_tokens(tree, "NAME")[0]), slots, _span(tree))

    def slot(self, tree: Tree[Token]) -> n.SlotNode:
        blocks, x, y = _trees(tree)
        number = self.number(_tokens(tree, "NUMBER")[0])
        return n.SlotNode(
            number, self.blocks(blocks), self.length(x), self.length(y), _span(tree)
        )  # fmt: skip

    def action(self, tree: Tree[Token]) -> n.ActionNode:
        moves = tuple(n.MoveNode(self.point(_trees(t)[0]), _span(t)) for t in _trees(tree))
        return n.ActionNode(self.name(_tokens(tree, "NAME")[0]), moves, _span(tree))

    def environment(self, tree: Tree[Token]) -> n.EnvironmentNode:
        names = [self.name(t) for t in _tokens(tree, "NAME")]
        base = names[1] if len(names) > 1 else None
        parts = tuple(cast("n.EnvironmentPart", self._parts[t.data](t)) for t in _trees(tree))
        return n.EnvironmentNode(names[0], base, parts, _span(tree))

    def goal(self, tree: Tree[Token]) -> n.GoalNode:
        parts = tuple(cast("n.GoalPart", self._parts[t.data](t)) for t in _trees(tree))
        return n.GoalNode(self.name(_tokens(tree, "NAME")[0]), parts, _span(tree))

    # ------------------------------------------------------------ environments

    def world(self, tree: Tree[Token]) -> n.WorldNode:
        return n.WorldNode(self.size(_tokens(tree, "SIZE")[0]), _span(tree))

    def background(self, tree: Tree[Token]) -> n.BackgroundNode:
        return n.BackgroundNode(self.name(_tokens(tree, "NAME")[0]), _span(tree))

    def travel(self, tree: Tree[Token]) -> n.TravelNode:
        return n.TravelNode(self.length(_trees(tree)[0]), _span(tree))

    def accuracy(self, tree: Tree[Token]) -> n.AccuracyNode:
        return n.AccuracyNode(self.length(_trees(tree)[0]), _span(tree))

    def views(self, tree: Tree[Token]) -> n.ViewsNode:
        return n.ViewsNode(tuple(self.view(t) for t in _trees(tree)), _span(tree))

    def view(self, tree: Tree[Token]) -> n.ViewNode:
        names = [self.name(t) for t in _tokens(tree, "NAME")]
        sizes = [self.size(t) for t in _tokens(tree, "SIZE")]
        return n.ViewNode(
            names[0],
            _has(tree, "AS"),
            names[1] if len(names) > 1 else None,
            sizes[0] if sizes else None,
            _span(tree),
        )

    def actions(self, tree: Tree[Token]) -> n.ActionsNode:
        return n.ActionsNode(tuple(self.name(t) for t in _tokens(tree, "NAME")), _span(tree))

    def teaching(self, tree: Tree[Token]) -> n.TeachingNode:
        return n.TeachingNode(_has(tree, "ON"), _span(tree))

    def place(self, tree: Tree[Token]) -> n.PlaceNode:
        counts = [self.number(t) for t in _tokens(tree, "NUMBER")]
        blocks, spot, *turn = _trees(tree)
        return n.PlaceNode(
            counts[0] if counts else None,
            counts[-1] if counts else None,
            self.blocks(blocks),
            self.spot(spot),
            self.turn(turn),
            _span(tree),
        )

    # ------------------------------------------------------------ goals

    def among(self, tree: Tree[Token]) -> n.InNode:
        return n.InNode(tuple(self.name(t) for t in _tokens(tree, "NAME")), _span(tree))

    def begin(self, tree: Tree[Token]) -> n.StartNode:
        return n.StartNode(self.spot(_trees(tree)[0]), _span(tree))

    def target(self, tree: Tree[Token]) -> n.TargetNode:
        blocks, *rest = _trees(tree)
        spot = self.spot(rest[0]) if rest else None
        return n.TargetNode(self.blocks(blocks), spot, self.turn(rest[1:]), _span(tree))

    def rule(self, tree: Tree[Token]) -> n.RuleNode:
        condition, *effects = _trees(tree)
        return n.RuleNode(
            self.condition(condition), tuple(self.effect(t) for t in effects), _span(tree)
        )

    def condition(self, tree: Tree[Token]) -> n.ConditionNode:
        span = _span(tree)
        if tree.data == "above_blocks":
            return n.ConditionNode("blocks", self.blocks(_trees(tree)[0]), None, span)
        if tree.data == "after_steps":
            steps = self.number(_tokens(tree, "NUMBER")[0])
            return n.ConditionNode("steps", None, steps, span)
        if tree.data == "hit_wall":
            return n.ConditionNode("wall", None, None, span)
        if tree.data == "above_target":
            return n.ConditionNode("target", None, None, span)
        if tree.data == "above_block":
            return n.ConditionNode("block", None, None, span)
        return n.ConditionNode("otherwise", None, None, span)

    def effect(self, tree: Tree[Token]) -> n.EffectNode:
        span = _span(tree)
        if tree.data == "reward":
            return n.EffectNode("reward", self.number(_tokens(tree, "NUMBER")[0]), None, span)
        if tree.data == "event":
            return n.EffectNode("event", None, self.text(_tokens(tree, "TEXT")[0]), span)
        return n.EffectNode("finish" if tree.data == "finish" else "fail", None, None, span)

    # ------------------------------------------------------------ requirements

    def require_gap(self, tree: Tree[Token]) -> n.GapNode:
        return n.GapNode(self.relation(tree), _span(tree))

    def require_distance(self, tree: Tree[Token]) -> n.DistanceNode:
        first, second = (self.party(t) for t in _trees(tree))
        return n.DistanceNode(first, second, self.relation(tree), _span(tree))

    def require_region(self, tree: Tree[Token]) -> n.RegionNode:
        blocks, corner, opposite = _trees(tree)
        return n.RegionNode(
            self.blocks(blocks),
            _has(tree, "INSIDE"),
            self.point(corner),
            self.point(opposite),
            _span(tree),
        )

    def party(self, tree: Tree[Token]) -> n.PartyNode:
        span = _span(tree)
        if tree.data == "start_party":
            return n.PartyNode("start", None, span)
        if tree.data == "target_party":
            return n.PartyNode("target", None, span)
        return n.PartyNode("blocks", self.blocks(tree), span)

    def relation(self, tree: Tree[Token]) -> n.RelationNode:
        sign = str(_tokens(tree, "RELATION")[0])
        return n.RelationNode(sign, self.number(_tokens(tree, "NUMBER")[0]))

    # ------------------------------------------------------------ small things

    def blocks(self, tree: Tree[Token]) -> n.Blocks:
        names: list[n.Name | None] = [self.name(t) for t in _tokens(tree, "NAME")]
        if _has(tree, "ANY"):
            names.insert(0, None)
        names.append(None)
        return n.Blocks(names[0], names[1], _span(tree))

    def spot(self, tree: Tree[Token]) -> n.SpotNode:
        if tree.data == "point":
            return self.point(tree)
        if tree.data == "corner":
            return n.CornerNode(_has(tree, "UPPER"), _has(tree, "RIGHT"), _span(tree))
        return n.RandomNode(_span(tree))

    def point(self, tree: Tree[Token]) -> n.PointNode:
        x, y = (self.number(t) for t in _tokens(tree, "NUMBER"))
        return n.PointNode(x, y, _span(tree))

    def turn(self, trees: list[Tree[Token]]) -> n.Number | None:
        return self.length(_trees(trees[0])[0]) if trees else None

    def length(self, tree: Tree[Token]) -> n.Number:
        units = [self.name(t) for t in _tokens(tree, "NAME")]
        number = self.number(_tokens(tree, "NUMBER")[0])
        return n.Number(number.value, units[0] if units else None, _span(tree))

    def number(self, token: Token) -> n.Number:
        return n.Number(float(token), None, token_span(token))

    def size(self, token: Token) -> n.Size:
        width, height = (float(part) for part in token.split("x"))
        return n.Size(width, height, token_span(token))

    def name(self, token: Token) -> n.Name:
        span = token_span(token)
        if token in LATER_WORDS:
            message = f"`{token}` is kept for a later version of the language"
            self._report.add("E105", span, message, f"use another name, such as `{token.upper()}`")
        return n.Name(str(token), span)

    def text(self, token: Token) -> n.Text:
        span = token_span(token)
        inside = token[1:-1]
        if _CONTROL.search(inside):
            self._report.add("E103", span, "the text has a control character", "remove it")
        for escape in _ESCAPE.finditer(inside):
            if escape[1] not in ('"', "\\"):
                message = f"`\\{escape[1]}` is no escape"
                self._report.add("E103", span, message, r"write `\"` or `\\`")
        return n.Text(_ESCAPE.sub(r"\1", inside), span)
