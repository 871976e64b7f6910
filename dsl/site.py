"""Checks that need a cell: whether a program fits one, going by its profile."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Protocol

from dsl.diagnostics import Diagnostic, Report
from dsl.program import Accuracy, Environment, Program, Slot, View
from dsl.words import did_you_mean


class Site(Protocol):
    """What a cell can tell before a task runs in it."""

    @property
    def kinds(self) -> Collection[str]:
        """Kinds of blocks that the cell knows."""

    @property
    def colours(self) -> Collection[str]:
        """Colours of blocks that the cell knows."""

    def reach(self, x: int, y: int, travel_mm: float) -> str | None:
        """Say why the arm cannot get above a lattice point and down to it, or None.

        Args:
            x: Lattice x.
            y: Lattice y.
            travel_mm: How far above the block tops it travels.
        """

    def reach_slot(self, slot: Slot) -> str | None:
        """Say why the arm cannot take a block from a slot, or None."""

    def sees(self, view: str, x: int, y: int) -> bool:
        """Whether a block on a lattice point is in a view; True where that varies."""

    def lattice_accuracy(self, limit_mm: float) -> str | None:
        """Say why it is not known to a limit where the lattice lies, or None."""

    def view_accuracy(self, view: str, limit_mm: float) -> str | None:
        """Say why it is not known to a limit where a view shows the table, or None.

        A view whose camera moves shows it now here, now there; that is None, too.
        """

    def has_camera(self, view: str) -> bool:
        """Whether the cell has a camera for a view."""


def check_on_site(program: Program, site: Site) -> tuple[Diagnostic, ...]:
    """Return what keeps a program from running in a cell.

    Args:
        program: A checked program.
        site: The cell.
    """
    report = Report()
    for slot in program.store.slots:
        _check_slot(slot, site, report)
    for environment in program.environments.values():
        _check_reach(environment, site, report)
        _check_views(environment, site, report)
        if environment.accuracy is not None:
            _check_accuracy(environment.accuracy, environment.views, site, report)
    for goal in program.goals.values():
        if goal.accuracy is not None:
            views = [v for e in goal.environments for v in program.environments[e].views]
            _check_accuracy(goal.accuracy, views, site, report)
    return report.diagnostics()


def _check_slot(slot: Slot, site: Site, report: Report) -> None:
    for what, word, known in (
        ("kind", slot.kind, site.kinds),
        ("colour", slot.colour, site.colours),
    ):
        if word not in known:
            message = f"this cell has no {what} `{word}`"
            report.add("E705", slot.span, message, did_you_mean(word, known))
    reason = site.reach_slot(slot)
    if reason is not None:
        message = f"the arm does not reach slot {slot.number}: {reason}"
        report.add("E702", slot.span, message, "mend the plan's place in the profile, or the slot")


def _check_reach(environment: Environment, site: Site, report: Report) -> None:
    reasons = {}
    for point in _points(environment):
        reason = site.reach(*point, environment.travel_mm)
        if reason is not None:
            reasons[point] = reason
    if reasons:
        (x, y), reason = next(iter(reasons.items()))
        message = (
            f"the arm does not reach {_share(reasons, environment)} of {environment.name}, "
            f"such as ({x}, {y}): {reason}"
        )
        hint = "make the world smaller, or mend the lattice in the profile"
        report.add("E701", environment.span, message, hint)


def _check_views(environment: Environment, site: Site, report: Report) -> None:
    for view in environment.views:
        if not site.has_camera(view.name):
            report.add("E704", view.span, f"this cell has no camera for {view.name}")
            continue
        unseen = [p for p in _points(environment) if not site.sees(view.name, *p)]
        if unseen:
            x, y = unseen[0]
            message = (
                f"{view.name} does not see {_share(unseen, environment)} of "
                f"{environment.name}, such as ({x}, {y})"
            )
            report.add("E703", view.span, message, "make the world smaller, or move the lattice")


def _check_accuracy(accuracy: Accuracy, views: Iterable[View], site: Site, report: Report) -> None:
    problems = [site.lattice_accuracy(accuracy.limit_mm)]
    for name in dict.fromkeys(view.name for view in views):
        problems.append(site.view_accuracy(name, accuracy.limit_mm))
    for problem in problems:
        if problem is not None:
            report.add("E706", accuracy.span, problem, "`cell calibrate` lists how")


def _points(environment: Environment) -> list[tuple[int, int]]:
    world = environment.world
    return [(x, y) for y in range(world.height) for x in range(world.width)]


def _share(points: Collection[tuple[int, int]], environment: Environment) -> str:
    whole = environment.world.width * environment.world.height
    return f"{len(points)} of the {whole} lattice points"
