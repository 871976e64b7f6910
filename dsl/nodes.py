"""A script as it is written: one node for each thing in the source, each with its span.

Nodes hold what the source says, right or wrong; what it means is found out by
`dsl.checks`. Formatter and editor work on nodes too, so nothing is lost but spaces
and line breaks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dsl.spans import Span


@dataclass(frozen=True, slots=True)
class Name:
    """A name, where it is declared or used."""

    text: str
    span: Span


@dataclass(frozen=True, slots=True)
class Number:
    """A number with its unit, if one is written; infinite when it is too large."""

    value: float
    unit: Name | None
    span: Span


@dataclass(frozen=True, slots=True)
class Text:
    """A text, its escapes resolved."""

    value: str
    span: Span


@dataclass(frozen=True, slots=True)
class Size:
    """Two whole numbers around an x."""

    width: float
    height: float
    span: Span


@dataclass(frozen=True, slots=True)
class Blocks:
    """Which blocks are meant; None where the source says `any` or nothing."""

    kind: Name | None
    colour: Name | None
    span: Span


@dataclass(frozen=True, slots=True)
class PointNode:
    """A lattice point, or steps of a move."""

    x: Number
    y: Number
    span: Span


@dataclass(frozen=True, slots=True)
class CornerNode:
    """A corner of the world."""

    is_upper: bool
    is_right: bool
    span: Span


@dataclass(frozen=True, slots=True)
class RandomNode:
    """`random`: drawn from the seed."""

    span: Span


SpotNode = PointNode | CornerNode | RandomNode


@dataclass(frozen=True, slots=True)
class SlotNode:
    """A slot of the store."""

    number: Number
    blocks: Blocks
    x: Number
    y: Number
    span: Span


@dataclass(frozen=True, slots=True)
class StoreNode:
    """A `store` declaration."""

    name: Name
    parts: tuple[SlotNode, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class MoveNode:
    """The `move` statement of an action."""

    steps: PointNode
    span: Span


@dataclass(frozen=True, slots=True)
class ActionNode:
    """An `action` declaration."""

    name: Name
    parts: tuple[MoveNode, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class WorldNode:
    """The `world` statement."""

    size: Size
    span: Span


@dataclass(frozen=True, slots=True)
class BackgroundNode:
    """The `background` statement."""

    name: Name
    span: Span


@dataclass(frozen=True, slots=True)
class TravelNode:
    """The `travel` statement."""

    height: Number
    span: Span


@dataclass(frozen=True, slots=True)
class AccuracyNode:
    """The `accuracy` statement of an environment or a goal."""

    limit: Number
    span: Span


@dataclass(frozen=True, slots=True)
class ViewNode:
    """One view of a `views` statement, with what stands after its `as`."""

    name: Name
    is_described: bool
    format: Name | None
    size: Size | None
    span: Span


@dataclass(frozen=True, slots=True)
class ViewsNode:
    """The `views` statement."""

    views: tuple[ViewNode, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class ActionsNode:
    """The `actions` statement of an environment."""

    names: tuple[Name, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class TeachingNode:
    """The `teaching` statement."""

    is_on: bool
    span: Span


@dataclass(frozen=True, slots=True)
class NothingNode:
    """`place nothing`."""

    span: Span


@dataclass(frozen=True, slots=True)
class PlaceNode:
    """A `place` statement; `low` is None where no number of blocks is written."""

    low: Number | None
    high: Number | None
    blocks: Blocks
    spot: SpotNode
    turn: Number | None
    span: Span


@dataclass(frozen=True, slots=True)
class RelationNode:
    """The comparison that ends a requirement."""

    sign: str
    limit: Number


@dataclass(frozen=True, slots=True)
class GapNode:
    """`require gap`."""

    relation: RelationNode
    span: Span


@dataclass(frozen=True, slots=True)
class PartyNode:
    """One end of a distance: `start`, `target` or some blocks."""

    role: Literal["start", "target", "blocks"]
    blocks: Blocks | None
    span: Span


@dataclass(frozen=True, slots=True)
class DistanceNode:
    """`require distance(…)`."""

    first: PartyNode
    second: PartyNode
    relation: RelationNode
    span: Span


@dataclass(frozen=True, slots=True)
class RegionNode:
    """`require … inside …` or `outside`."""

    blocks: Blocks
    is_inside: bool
    corner: PointNode
    opposite: PointNode
    span: Span


RequireNode = GapNode | DistanceNode | RegionNode
EnvironmentPart = (
    WorldNode
    | BackgroundNode
    | TravelNode
    | AccuracyNode
    | ViewsNode
    | ActionsNode
    | TeachingNode
    | NothingNode
    | PlaceNode
    | GapNode
    | DistanceNode
    | RegionNode
)


@dataclass(frozen=True, slots=True)
class EnvironmentNode:
    """An `environment` declaration."""

    name: Name
    base: Name | None
    parts: tuple[EnvironmentPart, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class InNode:
    """The `in` statement of a goal."""

    names: tuple[Name, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class StartNode:
    """The `start` statement."""

    spot: SpotNode
    span: Span


@dataclass(frozen=True, slots=True)
class TargetNode:
    """The `target` statement."""

    blocks: Blocks
    spot: SpotNode | None
    turn: Number | None
    span: Span


@dataclass(frozen=True, slots=True)
class ConditionNode:
    """The condition of a rule."""

    sort: Literal["wall", "target", "block", "blocks", "steps", "otherwise"]
    blocks: Blocks | None
    steps: Number | None
    span: Span


@dataclass(frozen=True, slots=True)
class EffectNode:
    """One effect of a rule."""

    sort: Literal["reward", "event", "finish", "fail"]
    reward: Number | None
    text: Text | None
    span: Span


@dataclass(frozen=True, slots=True)
class RuleNode:
    """A reward rule."""

    condition: ConditionNode
    effects: tuple[EffectNode, ...]
    span: Span


GoalPart = (
    InNode | StartNode | TargetNode | AccuracyNode | RuleNode | GapNode | DistanceNode | RegionNode
)


@dataclass(frozen=True, slots=True)
class GoalNode:
    """A `goal` declaration."""

    name: Name
    parts: tuple[GoalPart, ...]
    span: Span


Declaration = StoreNode | ActionNode | EnvironmentNode | GoalNode
Node = (
    Declaration | EnvironmentPart | GoalPart | SlotNode | MoveNode | ViewNode | ConditionNode
    | EffectNode | SpotNode | Blocks | Name | Number | Text | Size | PartyNode
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment, from its `#` to the end of its line."""

    text: str
    span: Span


@dataclass(frozen=True, slots=True)
class Script:
    """Everything that a source text says, in its order.

    Attributes:
        declarations: What could be read.
        mentioned: Sort and name of every declaration, those that could not be read
            included.
        damage: Offsets of syntax problems; what holds one may have lost statements.
    """

    declarations: tuple[Declaration, ...]
    mentioned: frozenset[tuple[str, str]]
    damage: tuple[int, ...]

    def is_damaged(self, node: Declaration) -> bool:
        """Return whether a declaration may have lost statements to a syntax problem."""
        return any(node.span.start <= offset <= node.span.end for offset in self.damage)
