"""What a look at the playground told, as a table, as data and as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from console.exits import ConsoleError, Exit

if TYPE_CHECKING:
    from cell.cleaning.look import Look
    from cell.cleaning.report import CleaningPlan, SeenOne

HEADINGS = ("turn", "what", "at mm", "yaw deg", "grip")


def plan_rows(plan: CleaningPlan) -> list[tuple[str, ...]]:
    """Return a row for everything that was seen."""
    return [_row(one) for one in plan.seen]


def plan_data(plan: CleaningPlan) -> dict[str, object]:
    """Return everything that was seen, and the push that would come first, as data."""
    push = plan.push
    return {
        "seen": [_data(one) for one in plan.seen],
        "push": None
        if push is None
        else {
            "block": push.block.name,
            "from_mm": [push.start.x_mm, push.start.y_mm],
            "to_mm": [push.end.x_mm, push.end.y_mm],
            "frees": push.frees,
        },
    }


def push_text(plan: CleaningPlan) -> str:
    """Return the push that would come first as a sentence, empty if there is none."""
    push = plan.push
    if push is None:
        return ""
    return (
        f"first the {push.block.name} at {push.block.where} is pushed from "
        f"({push.start.x_mm:.0f}, {push.start.y_mm:.0f}) to "
        f"({push.end.x_mm:.0f}, {push.end.y_mm:.0f}) mm, which frees {push.frees}"
    )


def picture_path(name: str) -> Path:
    """Return where a picture shall go.

    Raises:
        ConsoleError: It is no PNG, or its folder does not exist.
    """
    path = Path(name)
    if path.suffix.lower() != ".png":
        raise ConsoleError(
            f"--picture-out {path}: the picture is written as PNG; let the name end in .png"
        )
    if not path.parent.is_dir():
        raise ConsoleError(f"--picture-out {path}: the folder {path.parent} does not exist")
    return path


def write_picture(path: Path, view: Look) -> None:
    """Write the picture with what was found in it.

    Raises:
        ConsoleError: It cannot be written.
    """
    from cell.vision.overlay import draw_recognition
    from sessions.views import encode_png

    try:
        path.write_bytes(encode_png(draw_recognition(view.black, view.recognition)))
    except OSError as error:
        raise ConsoleError(
            f"--picture-out {path} cannot be written ({error.strerror or error}); name another",
            Exit.ENVIRONMENT,
        ) from error


def _row(one: SeenOne) -> tuple[str, ...]:
    turn = "-" if one.turn is None else str(one.turn)
    if one.block is None:
        where = "" if one.strange is None else f"({one.strange.x_mm:.1f}, {one.strange.y_mm:.1f})"
        return turn, "something unknown", where, "-", one.why_not
    body = one.block.body
    return (
        turn,
        one.block.name,
        f"({body.x_mm:.1f}, {body.y_mm:.1f})",
        "-" if body.is_round else f"{body.yaw_deg:.1f}",
        _grip(one),
    )


def _grip(one: SeenOne) -> str:
    grip = one.grip
    if grip is None:
        return one.why_not
    off = f", {grip.along_mm:+.0f} mm off its middle" if grip.along_mm else ""
    return (
        f"along {grip.place.yaw_deg:.0f} deg{off}, open {grip.opening_mm:.0f} mm, "
        f"{grip.clearance_mm:.1f} mm room"
    )


def _data(one: SeenOne) -> dict[str, object]:
    block, grip = one.block, one.grip
    if block is not None:
        at_mm = [block.body.x_mm, block.body.y_mm]
    else:
        at_mm = [] if one.strange is None else [one.strange.x_mm, one.strange.y_mm]
    return {
        "turn": one.turn,
        "kind": None if block is None else block.kind,
        "colour": None if block is None else block.colour,
        "at_mm": at_mm,
        "yaw_deg": None if block is None or block.body.is_round else block.body.yaw_deg,
        "deviation_mm": None if block is None else block.deviation_mm,
        "grip": None
        if grip is None
        else {
            "yaw_deg": grip.place.yaw_deg,
            "along_mm": grip.along_mm,
            "opening_mm": grip.opening_mm,
            "clearance_mm": grip.clearance_mm,
        },
        "why_not": one.why_not,
    }
