"""Environments: each statement, and what is taken over by `extends`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from dsl import nodes as n
from dsl.checks.basics import MAX_SLOTS
from dsl.checks.requirements import check_requirement
from dsl.checks.scope import Scope
from dsl.checks.values import (
    accuracy,
    definite_selector,
    length_mm,
    quarter_turn_deg,
    selector,
    spot,
    whole,
)
from dsl.checks.views import check_views
from dsl.diagnostics import Report
from dsl.kinds import BACKGROUNDS
from dsl.program import Accuracy, Environment, Place, Requirement, View, World
from dsl.words import did_you_mean

MAX_WORLD = 40
MIN_TRAVEL_MM, MAX_TRAVEL_MM = 20.0, 400.0
DEFAULT_BACKGROUND = "black"
DEFAULT_TRAVEL_MM = 65.0

Part = TypeVar(
    "Part",
    n.WorldNode,
    n.BackgroundNode,
    n.TravelNode,
    n.AccuracyNode,
    n.ViewsNode,
    n.ActionsNode,
    n.TeachingNode,
)
Value = TypeVar("Value")


@dataclass(frozen=True, slots=True, kw_only=True)
class Draft:
    """What an environment and those it extends say; None where nothing is said.

    Attributes:
        is_whole: Whether nothing was lost to an error, so that what is missing is
            missing indeed.
    """

    world: World | None = None
    background: str | None = None
    travel_mm: float | None = None
    accuracy: Accuracy | None = None
    views: tuple[View, ...] | None = None
    actions: tuple[str, ...] | None = None
    is_teaching: bool | None = None
    places: tuple[Place, ...] | None = None
    requirements: tuple[Requirement, ...] | None = None
    is_whole: bool = True


def check_environments(scope: Scope, report: Report) -> dict[str, Environment]:
    """Return the environments that are right, by name."""
    drafts: dict[str, Draft] = {}
    found = {}
    for name, node in scope.environments.items():
        draft = _draft(scope, node, drafts, report)
        environment = _finish(node, draft, report)
        if environment is not None:
            found[name] = environment
    return found


def _draft(
    scope: Scope, node: n.EnvironmentNode, drafts: dict[str, Draft], report: Report
) -> Draft:
    """Return what an environment says, with what it takes over.

    Walks up to the last environment that extends none, then down again, so that a long
    chain needs no deep recursion.
    """
    chain = [node]
    names = {node.name.text}
    base = Draft()
    while chain[-1].name.text not in drafts and chain[-1].base is not None:
        wanted = chain[-1].base
        if not scope.is_known("environment", wanted, scope.environments):
            base = Draft(is_whole=False)
            break
        if wanted.text in names:
            message = f"{wanted.text} extends itself, by way of {chain[-1].name.text}"
            report.add("E203", wanted.span, message, "remove one `extends`")
            base = Draft(is_whole=False)
            break
        names.add(wanted.text)
        chain.append(scope.environments[wanted.text])
    for link in reversed(chain):
        name = link.name.text
        if name not in drafts:
            drafts[name] = _merged(base, _own(scope, link, report))
        base = drafts[name]
    return base


def _merged(base: Draft, own: Draft) -> Draft:
    """Return what the one says, completed by what the other says."""
    return Draft(
        world=own.world or base.world,
        background=own.background or base.background,
        travel_mm=own.travel_mm or base.travel_mm,
        accuracy=own.accuracy or base.accuracy,
        views=base.views if own.views is None else own.views,
        actions=base.actions if own.actions is None else own.actions,
        is_teaching=base.is_teaching if own.is_teaching is None else own.is_teaching,
        places=base.places if own.places is None else own.places,
        requirements=base.requirements if own.requirements is None else own.requirements,
        is_whole=base.is_whole and own.is_whole,
    )


def _finish(node: n.EnvironmentNode, draft: Draft, report: Report) -> Environment | None:
    """Return the environment with its defaults, or None if something is missing or wrong."""
    if draft.is_whole:
        missing = [("world", "`world 12 x 12`")] if draft.world is None else []
        missing += [("actions", "`actions UP, DOWN`")] if draft.actions is None else []
        for what, example in missing:
            message = f"the environment {node.name.text} has no `{what}`"
            report.add("E205", node.name.span, message, f"such as {example}")
    if not draft.is_whole or draft.world is None or draft.actions is None:
        return None
    return Environment(
        name=node.name.text,
        world=draft.world,
        background=draft.background or DEFAULT_BACKGROUND,
        travel_mm=draft.travel_mm or DEFAULT_TRAVEL_MM,
        views=draft.views or (),
        actions=draft.actions,
        is_teaching=bool(draft.is_teaching),
        places=draft.places or (),
        requirements=draft.requirements or (),
        span=node.name.span,
        accuracy=draft.accuracy,
    )


def _own(scope: Scope, node: n.EnvironmentNode, report: Report) -> Draft:
    """Return what the environment's own statements say."""
    errors = report.count()
    draft = Draft(
        world=_once(node, n.WorldNode, _world, report),
        background=_once(node, n.BackgroundNode, _background, report),
        travel_mm=_once(node, n.TravelNode, _travel, report),
        accuracy=_once(node, n.AccuracyNode, accuracy, report),
        views=_once(node, n.ViewsNode, check_views, report),
        actions=_once(
            node,
            n.ActionsNode,
            lambda part, _: tuple(scope.known("action", part.names, scope.actions)),
            report,
        ),
        is_teaching=_once(node, n.TeachingNode, lambda part, _: part.is_on, report),
        places=_places(node, report),
        requirements=_requirements(node, report),
    )
    is_whole = report.count() == errors and not scope.script.is_damaged(node)
    if draft.actions == () or not is_whole:
        return replace(draft, is_whole=False)
    return draft


def _once(
    node: n.EnvironmentNode,
    sort: type[Part],
    check: Callable[[Part, Report], Value | None],
    report: Report,
) -> Value | None:
    """Check the statement of a sort that may stand once; report any further ones."""
    parts = [part for part in node.parts if isinstance(part, sort)]
    for extra in parts[1:]:
        word = sort.__name__.removesuffix("Node").lower()
        message = f"`{word}` stands twice in {node.name.text}"
        report.add("E204", extra.span, message, "remove one")
    return check(parts[0], report) if parts else None


def _world(node: n.WorldNode, report: Report) -> World | None:
    for value, what in ((node.size.width, "width"), (node.size.height, "height")):
        if not 1 <= value <= MAX_WORLD:
            message = f"the world's {what} is {value:g}, outside of 1 to {MAX_WORLD}"
            report.add("E301", node.size.span, message)
            return None
    return World(int(node.size.width), int(node.size.height))


def _background(node: n.BackgroundNode, report: Report) -> str | None:
    name = node.name.text
    if name in BACKGROUNDS:
        return name
    hint = did_you_mean(name, BACKGROUNDS)
    report.add("E208", node.name.span, f"there is no background {name}", hint)
    return None


def _travel(node: n.TravelNode, report: Report) -> float | None:
    return length_mm(node.height, "the travel height", MIN_TRAVEL_MM, MAX_TRAVEL_MM, report)


def _places(node: n.EnvironmentNode, report: Report) -> tuple[Place, ...] | None:
    places = [part for part in node.parts if isinstance(part, n.PlaceNode)]
    nothing = [part for part in node.parts if isinstance(part, n.NothingNode)]
    if nothing and (places or len(nothing) > 1):
        message = f"`place nothing` is not all that {node.name.text} places"
        report.add("E204", nothing[0].span, message, "remove it or the other places")
    if not places and not nothing:
        return None
    found = [_place(part, report) for part in places]
    return tuple(place for place in found if place is not None)


def _place(node: n.PlaceNode, report: Report) -> Place | None:
    low, high = _counts(node, report)
    where = spot(node.spot, report)
    if isinstance(node.spot, n.RandomNode):
        which = selector(node.blocks, report)
    else:
        which = definite_selector(node.blocks, "a block at a fixed point", report)
    yaw_deg = quarter_turn_deg(node.turn, report)
    if low is None or high is None or which is None or where is None:
        return None
    return Place(which, low, high, where, yaw_deg, node.span)


def _counts(node: n.PlaceNode, report: Report) -> tuple[int | None, int | None]:
    if node.low is None or node.high is None:
        return 1, 1
    low = whole(node.low, "the number of blocks", 0, MAX_SLOTS, report)
    high = whole(node.high, "the number of blocks", 0, MAX_SLOTS, report)
    if low is not None and high is not None and low > high:
        span = node.low.span.to(node.high.span)
        report.add("E306", span, f"{low} to {high} goes backwards", f"write `{high} to {low}`")
        return None, None
    return low, high


def _requirements(node: n.EnvironmentNode, report: Report) -> tuple[Requirement, ...] | None:
    parts = [p for p in node.parts if isinstance(p, n.GapNode | n.DistanceNode | n.RegionNode)]
    if not parts:
        return None
    found = [check_requirement(part, report, is_in_goal=False) for part in parts]
    return tuple(requirement for requirement in found if requirement is not None)
