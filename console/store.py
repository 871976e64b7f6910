"""`cell store`: the blocks by hand, each transfer in the ledger."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from console.exits import ConsoleError, Exit
from console.figures import Figure, Whole
from console.hand import DEFAULTS, HandOptions, by_hand, tell
from console.hand_speed import kept_speed
from console.output import put_json, put_table, say
from console.seen import (
    HEADINGS,
    picture_path,
    plan_data,
    plan_rows,
    push_text,
    write_picture,
)
from console.store_plan import register as register_plan

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from cell.by_hand import ByHand
    from cell.store import TablePlace

app = App(name="store")
register_plan(app)
Yaw = Annotated[float, Parameter(help="Turn of the block's length from robot x, deg.")]


@app.command
def where(
    kind: str | None = None, colour: str | None = None, /, *, options: HandOptions = DEFAULTS
) -> int:
    """Tell where blocks belong and where they are: all, of a kind, or of a kind and colour.

    Args:
        kind: Kind of the blocks, such as cube.
        colour: Their colour.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        cell = hands.playground
        slots = [
            s for s in cell.plan.slots
            if kind in (None, s.kind) and colour in (None, s.colour)
        ]  # fmt: skip
        if not slots:
            kinds = sorted({f"{s.kind} {s.colour}" for s in cell.plan.slots})
            raise ConsoleError(f"the store has none of that sort; it has {', '.join(kinds)}")
        out = cell.ledger.blocks_out()
        told = []
        for slot in slots:
            own = cell.manipulator.slot_place(slot.number)
            now = out.get(slot.number)
            told.append(
                {
                    "slot": slot.number,
                    "kind": slot.kind,
                    "colour": slot.colour,
                    "slot_mm": [own.x_mm, own.y_mm],
                    "now_mm": None if now is None else [now.x_mm, now.y_mm],
                }
            )
        if options.as_json:
            put_json(told)
            return
        rows = [
            (str(t["slot"]), str(t["kind"]), str(t["colour"]), _mm(t["slot_mm"]), _mm(t["now_mm"]))
            for t in told
        ]
        put_table(("slot", "kind", "colour", "belongs at mm", "lies at mm"), rows)

    return by_hand(options, work)


@app.command
def grip(
    x_mm: Figure, y_mm: Figure, /, *, yaw: Yaw = 0.0, options: HandOptions = DEFAULTS
) -> int:  # fmt: skip
    """Grip the block at a place and lift it.

    Args:
        x_mm: Robot x of the block.
        y_mm: Robot y of the block.
        yaw: Turn of the block's length from robot x, deg.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        _bring_up(hands)
        slot = hands.playground.grip_at(_place(x_mm, y_mm, yaw))
        tell({"slot": slot}, f"holds the block of slot {slot}", options)

    return by_hand(options, work)


@app.command
def release(
    x_mm: Figure, y_mm: Figure, /, *, yaw: Yaw = 0.0, options: HandOptions = DEFAULTS
) -> int:  # fmt: skip
    """Put the gripped block down at a place.

    Args:
        x_mm: Robot x of the place.
        y_mm: Robot y of the place.
        yaw: Turn of the block's length from robot x, deg.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        _bring_up(hands)
        hands.playground.release_at(_place(x_mm, y_mm, yaw))
        tell({"released_mm": [x_mm, y_mm]}, f"put down at ({x_mm:g}, {y_mm:g}) mm", options)

    return by_hand(options, work)


@app.command
def deploy(
    slot: Whole, x_mm: Figure, y_mm: Figure, /, *, yaw: Yaw = 0.0, options: HandOptions = DEFAULTS
) -> int:  # fmt: skip
    """Bring a block from its slot to a place.

    Args:
        slot: Number of its slot.
        x_mm: Robot x of the place.
        y_mm: Robot y of the place.
        yaw: Turn of the block's length from robot x, deg.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.playground.plan.slot(slot)
        _bring_up(hands)
        hands.playground.deploy(slot, _place(x_mm, y_mm, yaw))
        tell({"slot": slot, "at_mm": [x_mm, y_mm]}, f"slot {slot} is laid out", options)

    return by_hand(options, work)


@app.command
def clean(
    *slots: int,
    picture: Annotated[
        bool, Parameter(negative="", help="By what the top camera sees, not by the ledger.")
    ] = False,
    plan: Annotated[
        bool, Parameter(negative="", help="With --picture: only look and tell what would be done.")
    ] = False,
    picture_out: Annotated[
        str | None, Parameter(help="With --picture: PNG file for what the camera saw last.")
    ] = None,
    options: HandOptions = DEFAULTS,
) -> int:
    """Bring blocks back to their slots: those of the slots given, or all that lie out.

    Args:
        slots: Numbers of the slots; all unless given.
        picture: Whether the top camera says what lies where, rather than the ledger.
        plan: Whether to only look and tell what would be done.
        picture_out: File for the last picture with what was found in it.
        options: Options of every command by hand.
    """
    if picture and slots:
        raise ConsoleError("--picture looks for every block; leave the slots out")
    if not picture and (plan or picture_out):
        raise ConsoleError("--plan and --picture-out tell what the camera sees; add --picture")
    out = None if picture_out is None else picture_path(picture_out)

    def work(hands: ByHand) -> int:
        for slot in slots:
            hands.playground.plan.slot(slot)
        _bring_up(hands)
        if picture:
            return _by_picture(hands, out, options, is_only_plan=plan)
        if slots:
            put_back = hands.playground.clean_objects(slots, _progress)
        else:
            put_back = hands.playground.clean(_progress)
        return _tell_cleaned(put_back, [], {}, options)

    return by_hand(options, work)


def _by_picture(
    hands: ByHand, out: Path | None, options: HandOptions, *, is_only_plan: bool
) -> int:
    cell = hands.playground
    hands.reach_display()
    cell.display.switch_on()
    cell.display.select_input(cell.profile.display.input)
    if is_only_plan:
        found = cell.plan_from_picture()
        if out is not None:
            write_picture(out, found.view)
        if options.as_json:
            put_json(plan_data(found))
        elif found.seen:
            put_table(HEADINGS, plan_rows(found))
            say(push_text(found) or "each is free at its turn, or left where it is")
        else:
            say("nothing lies on the playground")
        return Exit.DONE
    cleaning = cell.clean_from_picture(_progress)
    if out is not None and cleaning.last is not None:
        write_picture(out, cleaning.last)
    if cleaning.plan is not None:
        for row in plan_rows(cleaning.plan):
            say("  ".join(row))
    data: dict[str, object] = {} if cleaning.plan is None else plan_data(cleaning.plan)
    data |= {"pushes": cleaning.pushes, "looks": cleaning.looks}
    return _tell_cleaned(cleaning.home, cleaning.left, data, options)


def _tell_cleaned(
    put_back: Sequence[int], left: Sequence[str], data: dict[str, object], options: HandOptions
) -> int:
    text = ", ".join(f"slot {slot}" for slot in put_back)
    lines = [f"brought home: {text}" if text else "nothing was brought home", *left]
    told: dict[str, object] = {"brought_home": [*put_back], "left": [*left]}
    tell(told | data, "\n".join(lines), options)
    return Exit.FAILED if left else Exit.DONE


def _bring_up(hands: ByHand) -> None:
    """Bring up what moves blocks; the gripper keeps its power, so that it keeps its block."""
    say("bringing arm and gripper up ...")
    hands.bring_up_arm()
    hands.playground.set_speed(*kept_speed(hands.playground.profile))
    hands.bring_up_gripper(leave_on=True)
    say("moving ...")


def _progress(what: str, done: int, total: int) -> None:
    say(f"{what}: {done} of {total}")


def _place(x_mm: Figure, y_mm: Figure, yaw_deg: float) -> TablePlace:
    from cell.store import TablePlace

    return TablePlace(x_mm=x_mm, y_mm=y_mm, yaw_deg=yaw_deg)


def _mm(place: object) -> str:
    return f"({place[0]:.1f}, {place[1]:.1f})" if isinstance(place, list) else "-"
