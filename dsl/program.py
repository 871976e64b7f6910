"""What a checked script means: frozen values that a task runs on.

Every value keeps the span it comes from, so that findings of the cell's profile
(`dsl.site`) can be shown in the source.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

from dsl.spans import Span


class World(NamedTuple):
    """Size of a world in lattice points."""

    width: int
    height: int

    def holds(self, x: int, y: int) -> bool:
        """Return whether a point is in the world."""
        return 0 <= x < self.width and 0 <= y < self.height

    def __str__(self) -> str:
        return f"{self.width} x {self.height}"


@dataclass(frozen=True, slots=True)
class Slot:
    """A slot of the store, in millimetres on its plan."""

    number: int
    kind: str
    colour: str
    x_mm: float
    y_mm: float
    span: Span


@dataclass(frozen=True, slots=True)
class Store:
    """The blocks there are, by slot number."""

    name: str
    slots: tuple[Slot, ...]


@dataclass(frozen=True, slots=True)
class Action:
    """What a client can do: a move in lattice steps."""

    name: str
    dx: int
    dy: int
    span: Span


@dataclass(frozen=True, slots=True)
class View:
    """What a client can see.

    Attributes:
        name: Name of the camera's view, such as `CAMERA_TOP`.
        mime: Such as `image/mif`.
        width_px: Width of the picture.
        height_px: Its height.
        span: Where the script says so.
    """

    name: str
    mime: str
    width_px: int
    height_px: int
    span: Span


@dataclass(frozen=True, slots=True)
class Selector:
    """Which blocks are meant; None is any."""

    kind: str | None
    colour: str | None

    def matches(self, kind: str, colour: str) -> bool:
        """Return whether a block is meant."""
        return self.kind in (None, kind) and self.colour in (None, colour)

    @property
    def is_definite(self) -> bool:
        """Whether kind and colour are both given."""
        return self.kind is not None and self.colour is not None

    def __str__(self) -> str:
        return " ".join(part for part in (self.kind or "any", self.colour) if part)


@dataclass(frozen=True, slots=True)
class Spot:
    """A point of a world, or a way to find one.

    Attributes:
        sort: `point`, `corner` or `random`.
        x: Lattice x of a point; for a corner 1 if it is a right one.
        y: Lattice y of a point; for a corner 1 if it is an upper one.
        span: Where the script says so.
    """

    sort: Literal["point", "corner", "random"]
    x: int
    y: int
    span: Span

    @property
    def is_random(self) -> bool:
        """Whether the seed decides."""
        return self.sort == "random"

    def within(self, world: World) -> tuple[int, int] | None:
        """Return the lattice point in a world, or None when the seed decides."""
        if self.sort == "random":
            return None
        if self.sort == "corner":
            return (world.width - 1) * self.x, (world.height - 1) * self.y
        return self.x, self.y


@dataclass(frozen=True, slots=True)
class Place:
    """Blocks that lie out: `low` to `high` of them."""

    selector: Selector
    low: int
    high: int
    spot: Spot
    yaw_deg: float
    span: Span


@dataclass(frozen=True, slots=True)
class Party:
    """One end of a distance; the selector is None for `start` and `target`."""

    role: Literal["start", "target", "blocks"]
    selector: Selector | None

    def __str__(self) -> str:
        return self.role if self.selector is None else str(self.selector)


@dataclass(frozen=True, slots=True)
class Relation:
    """A comparison with a number."""

    sign: str
    limit: float

    def holds(self, value: float) -> bool:
        """Return whether a value is as asked for."""
        match self.sign:
            case ">=":
                return value >= self.limit
            case "<=":
                return value <= self.limit
            case ">":
                return value > self.limit
            case "<":
                return value < self.limit
            case _:
                return value == self.limit

    def __str__(self) -> str:
        return f"{self.sign} {self.limit:g}"


@dataclass(frozen=True, slots=True)
class Gap:
    """Any two blocks are so far apart, along the axis on which they are farther."""

    relation: Relation
    span: Span

    def __str__(self) -> str:
        return f"gap {self.relation}"


@dataclass(frozen=True, slots=True)
class Distance:
    """Two things are so many single steps apart."""

    first: Party
    second: Party
    relation: Relation
    span: Span

    def __str__(self) -> str:
        return f"distance({self.first}, {self.second}) {self.relation}"


@dataclass(frozen=True, slots=True)
class Region:
    """Blocks lie inside or outside of a rectangle, its borders included."""

    selector: Selector
    is_inside: bool
    left: int
    bottom: int
    right: int
    top: int
    span: Span

    def holds(self, x: int, y: int) -> bool:
        """Return whether a point is where it must be."""
        is_in = self.left <= x <= self.right and self.bottom <= y <= self.top
        return is_in is self.is_inside

    def __str__(self) -> str:
        where = "inside" if self.is_inside else "outside"
        return f"{self.selector} {where} ({self.left}, {self.bottom}) to ({self.right}, {self.top})"


@dataclass(frozen=True, slots=True)
class Accuracy:
    """How well the cell must be known: where its lattice and its views lie."""

    limit_mm: float
    span: Span


Requirement = Gap | Distance | Region


@dataclass(frozen=True, slots=True, kw_only=True)
class Environment:
    """Where a task takes place; what it extends is worked in."""

    name: str
    world: World
    background: str
    travel_mm: float
    views: tuple[View, ...]
    actions: tuple[str, ...]
    is_teaching: bool
    places: tuple[Place, ...]
    requirements: tuple[Requirement, ...]
    span: Span
    accuracy: Accuracy | None = None


@dataclass(frozen=True, slots=True)
class Target:
    """The block to reach; `spot` is None where the environment lays it out."""

    kind: str
    colour: str
    spot: Spot | None
    yaw_deg: float
    span: Span


@dataclass(frozen=True, slots=True)
class Condition:
    """When a rule applies.

    Attributes:
        sort: What is looked at; `blocks` are those of the selector.
        selector: The blocks of `blocks`.
        steps: The number of steps of `steps`.
    """

    sort: Literal["wall", "target", "block", "blocks", "steps", "otherwise"]
    selector: Selector | None = None
    steps: int = 0


@dataclass(frozen=True, slots=True)
class Rule:
    """What a step earns, if the condition holds and no earlier rule's does."""

    condition: Condition
    reward: float
    event: str | None
    status: Literal["running", "finished", "failed"]
    span: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class Goal:
    """What is to be done, and what it earns."""

    name: str
    environments: tuple[str, ...]
    start: Spot
    target: Target
    requirements: tuple[Requirement, ...]
    rules: tuple[Rule, ...]
    span: Span
    accuracy: Accuracy | None = None


@dataclass(frozen=True, slots=True)
class Program:
    """A script that passed its check; all mappings are in the order of declaration."""

    name: str
    store: Store
    actions: Mapping[str, Action]
    environments: Mapping[str, Environment]
    goals: Mapping[str, Goal]
