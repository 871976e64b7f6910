"""Whether the blocks of every task have room, whatever the seed.

What an environment lays out is checked by itself, then with each goal that changes
it. Fixed blocks are compared pair by pair; for those that the seed places the search of
a running task is tried with the fewest and with the most blocks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

from dsl.diagnostics import Report
from dsl.draws import Draws
from dsl.kinds import LATTICE_STEP_MM, border_steps, clash, shape_of
from dsl.layout.blame import blame
from dsl.layout.demand import Demand, stock_of
from dsl.layout.pieces import (
    Piece,
    block_pieces,
    broken_by_pair,
    broken_by_piece,
    places_of,
    requirements_of,
    start_piece,
    withheld_sorts,
)
from dsl.layout.search import Search
from dsl.program import Action, Environment, Goal, Place, Spot, Store, World
from dsl.spans import Span
from dsl.teacher import distances
from dsl.words import enumerate_words

_BUDGET = 20_000


def check_layouts(
    store: Store,
    actions: Mapping[str, Action],
    environments: Mapping[str, Environment],
    goals: Mapping[str, Goal],
    report: Report,
) -> None:
    """Report every environment and every goal in it that has no layout."""
    sound = set()
    for environment in environments.values():
        errors = report.count()
        _Layouts(store, environment, None, report).check()
        if report.count() == errors:
            sound.add(environment.name)
    for goal in goals.values():
        for name in goal.environments:
            if name in sound:
                layouts = _Layouts(store, environments[name], goal, report)
                layouts.check()
                layouts.check_way(actions)


class _Layouts:
    """The layouts of an environment, alone or with a goal."""

    def __init__(
        self, store: Store, environment: Environment, goal: Goal | None, report: Report
    ) -> None:
        self._store = store
        self._environment = environment
        self._world = environment.world
        self._goal = goal
        self._report = report
        self._places = places_of(environment, goal)
        self._requirements = requirements_of(environment, goal)

    def check(self) -> None:
        """Report what keeps the layouts from existing; later checks need earlier ones."""
        errors = self._report.count()
        self._check_points()
        if self._goal is not None:
            self._check_target(self._goal)
        if self._report.count() > errors or not self._is_new or not self._check_store():
            return
        self._check_fixed()
        if self._report.count() == errors:
            self._check_search()

    @property
    def _is_new(self) -> bool:
        """Whether the layouts are other than those of the environment alone."""
        goal = self._goal
        return (
            goal is None
            or goal.target.spot is not None
            or goal.start.is_random
            or bool(goal.requirements)
            or any(not place.selector.is_definite for place in self._places)
        )

    @property
    def _where(self) -> str:
        """How messages name the environment, where the place in the source does not."""
        return f"in {self._environment.name} " if self._goal is not None else ""

    # ------------------------------------------------------------ points and target

    def _check_points(self) -> None:
        if self._goal is not None:
            self._check_spot(self._goal.start, None)
        for place in self._places:
            if self._goal is None or place.spot is self._goal.target.spot:
                shape = shape_of(place.selector.kind or "cube", place.yaw_deg)
                self._check_spot(place.spot, shape)

    def _check_spot(self, spot: Spot, shape: tuple[str, bool] | None) -> None:
        """Report a point outside the world, or a block that would stick out there."""
        point = spot.within(self._world)
        if point is None:
            return
        side, end = (0, 0) if shape is None else border_steps(shape)
        right, top = self._world.width - 1, self._world.height - 1
        if side <= point[0] <= right - side and end <= point[1] <= top - end:
            return
        if shape is not None and self._world.holds(*point):
            message = (
                f"a {shape[0]} at ({point[0]}, {point[1]}) sticks out of the playground of "
                f"{self._environment.name}"
            )
            hint = f"keep it {max(side, end)} steps from the border"
            self._report.add("E401", spot.span, message, hint)
            return
        message = (
            f"({point[0]}, {point[1]}) lies outside the world of {self._environment.name}, "
            f"{self._world}"
        )
        self._report.add("E401", spot.span, message, f"its corners are (0, 0) and ({right}, {top})")

    def _check_target(self, goal: Goal) -> None:
        if goal.target.spot is not None:
            return
        target, name = goal.target, self._environment.name
        which = f"{target.kind} {target.colour}"
        same = [
            p for p in self._places
            if p.selector.is_definite and p.selector.matches(target.kind, target.colour)
        ]  # fmt: skip
        low, high = sum(p.low for p in same), sum(p.high for p in same)
        hint = f"let the goal place it, such as `target {which} at random`"
        if low == 0:
            how = "may lay out no" if high else "lays out no"
            self._report.add("E501", target.span, f"{name} {how} {which}", hint)
        elif high > 1:
            how = "lays out" if low > 1 else "may lay out"
            message = f"{name} {how} {high} blocks `{which}`: which one is the target?"
            self._report.add("E502", target.span, message, hint)

    # ------------------------------------------------------------ the store

    def _check_store(self) -> bool:
        wanted = [place.selector for place in self._places for _ in range(place.high)]
        if not self._store.slots and wanted:
            message = "the script has no store to take blocks from"
            hint = "declare one: `store toys { slot 1 cube red at (55, 50) }`"
            self._report.add("E404", self._places[0].span, message, hint)
            return False
        stock = stock_of(self._store.slots)
        withheld = withheld_sorts(self._environment, self._goal, stock)
        shortage = Demand(wanted, stock, withheld).shortage()
        if shortage is None:
            return True
        wanting = [p for p in self._places if p.selector in shortage.wanted]
        place = max(reversed(wanting), key=lambda p: p.high)
        hint = "ask for fewer or add slots"
        if withheld and not place.selector.is_definite:
            left_out = enumerate_words(sorted(" ".join(sort) for sort in withheld), "and")
            hint += f"; open places take no {left_out} here"
        self._report.add("E404", place.span, f"{self._where}{shortage}".strip(), hint)
        return False

    # ------------------------------------------------------------ fixed blocks

    def _check_fixed(self) -> None:
        pieces = [p for p in self._pieces(self._counts(is_most=False)) if p.point is not None]
        for piece in pieces:
            self._check_alone(piece)
        for first, second in combinations(pieces, 2):
            self._check_pair(first, second)

    def _check_alone(self, piece: Piece) -> None:
        for requirement in self._requirements:
            if piece.point is not None and broken_by_piece(requirement, piece, *piece.point):
                message = f"{self._where}{piece} does not keep `{requirement}`"
                self._report.add("E407", piece.span, message, "move it or change the requirement")

    def _check_pair(self, first: Piece, second: Piece) -> None:
        if first.point is None or second.point is None:
            return
        dx, dy = second.point[0] - first.point[0], second.point[1] - first.point[1]
        if first.role == second.role == "block":
            step = LATTICE_STEP_MM
            trouble = clash(first.shape, second.shape, dx * step, dy * step)
            if trouble == "overlap":
                message = f"{self._where}{second} and {first} overlap"
                self._report.add("E402", second.span, message, self._free_points(second))
                return
            if trouble == "fingers":
                message = f"{self._where}{second} and {first} leave no room for the fingers"
                self._report.add("E403", second.span, message, self._free_points(second))
                return
        for requirement in self._requirements:
            if broken_by_pair(requirement, first, second, dx, dy):
                message = f"{self._where}{second} and {first} do not keep `{requirement}`"
                self._report.add("E407", second.span, message, "move one or change the requirement")

    def _free_points(self, moved: Piece) -> str:
        """Return a hint with the points nearest to a fixed piece that it could take."""
        if moved.point is None:
            return ""
        others = [
            p for p in self._pieces(self._counts(is_most=False)) if p.point is not None
            and p != moved
        ]  # fmt: skip
        free = Piece(
            moved.role, moved.kind, moved.colour, moved.yaw_deg, moved.is_target, None, moved.span
        )
        x, y = moved.point
        points = Search(self._world, [*others, free], self._requirements).points_left(len(others))
        points.sort(key=lambda p: ((p[0] - x) ** 2 + (p[1] - y) ** 2, p))
        if not points:
            return f"no point of {self._world} is free for it"
        return "nearest free points for it: " + ", ".join(f"({px}, {py})" for px, py in points[:3])

    # ------------------------------------------------------------ the seed's blocks

    def _check_search(self) -> None:
        fewest, most = self._counts(is_most=False), self._counts(is_most=True)
        reason = self._impossible(fewest)
        if reason is not None:
            message = f"{self._where}no layout exists: {reason}"
            self._report.add("E405", self._anchor(), message, "ask for fewer blocks or less room")
        elif fewest != most:
            reason = self._impossible(most)
            if reason is not None:
                message = f"{self._where}not every seed has a layout: {reason}"
                self._report.add("W406", self._anchor(), message, "lower the largest number")

    def _impossible(self, counts: Sequence[int]) -> str | None:
        """Say why so many blocks have no layout, or None if they have or it is open."""
        pieces = self._pieces(counts)
        if all(piece.point is not None for piece in pieces):
            return None
        search = Search(self._world, pieces, self._requirements)
        if search.surely_succeeds() or search.run(Draws(0), _BUDGET).verdict != "impossible":
            return None
        return blame(self._world, pieces, self._requirements)

    def _anchor(self) -> Span:
        """Return the statement that is shown for a layout as a whole."""
        if self._goal is not None:
            return self._goal.target.span
        return next(
            (p.span for p in reversed(self._places) if p.spot.is_random), self._environment.span
        )

    def _counts(self, *, is_most: bool) -> list[int]:
        return [place.high if is_most else place.low for place in self._places]

    def _pieces(self, counts: Sequence[int]) -> list[Piece]:
        """Return all pieces, kind and colour of the open blocks unknown."""
        sorts = [
            (place.selector.kind, place.selector.colour)
            for place, count in zip(self._places, counts, strict=True)
            for _ in range(count)
        ]
        pieces = block_pieces(self._places, counts, sorts, self._world, self._goal)
        if self._goal is not None:
            pieces.append(start_piece(self._goal.start, self._world))
        return pieces

    # ------------------------------------------------------------ the way

    def check_way(self, actions: Mapping[str, Action]) -> None:
        """Warn of a start at the target, and of one that no way leads from."""
        goal, world = self._goal, self._world
        if goal is None or any(name not in actions for name in self._environment.actions):
            return
        start = goal.start.within(world)
        target = _target_point(goal, self._places, world)
        if start is None or target is None or not (world.holds(*start) and world.holds(*target)):
            return
        name = self._environment.name
        if start == target:
            message = f"in {name} the gripper starts above the target"
            self._report.add("W506", goal.start.span, message, "start elsewhere")
            return
        moves = tuple((actions[a].dx, actions[a].dy) for a in self._environment.actions)
        if distances(world, moves, target)[start[1] * world.width + start[0]] < 0:
            message = f"in {name} no actions lead from {start} to the target at {target}"
            self._report.add("W507", goal.start.span, message, "add an action or move the start")


def _target_point(goal: Goal, places: Sequence[Place], world: World) -> tuple[int, int] | None:
    """Return where the target lies for every seed, or None where the seed decides."""
    which = (goal.target.kind, goal.target.colour)
    for place in places:
        if (place.selector.kind, place.selector.colour) == which:
            return place.spot.within(world)
    return None
