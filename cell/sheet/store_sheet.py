"""Draws the store's sheet: what a person needs to set blocks, and a camera to find it.

Inside each slot it is white but for its number: so a camera tells an empty slot from one
with a block of any colour. Colours are named, too, for those who print in grey.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from cell.sheet.drawing import (
    BLACK,
    WHITE,
    Bitmap,
    Circle,
    Colour,
    Drawing,
    Figure,
    Line,
    Polygon,
    Rectangle,
    Text,
)
from cell.sheet.fiducials import marker_rows
from cell.sheet.fonts import CAPITAL_SHARE, text_width_mm
from cell.sheet.layout import LABEL_MM, RULER_MM, PrintedSlot, SheetLayout
from cell.sheet.room import Area

INKS: Final[dict[str, Colour]] = {
    "natural": (214, 178, 128),
    "red": (206, 44, 40),
    "green": (30, 132, 62),
    "blue": (28, 70, 170),
    "yellow": (250, 206, 20),
}
"""What colours are printed in; five different greys when printed without colour."""

_UNKNOWN_INK: Colour = (128, 128, 128)
_GREY: Colour = (90, 90, 90)
_RING_MM = 4.5
_ADVICE = "must measure 100.0 mm: else print at 100 %, not fitted to the page"


def draw_sheet(layout: SheetLayout, *, name: str = "", angle_deg: float = 0.0) -> Drawing:
    """Return the drawing of a sheet.

    Args:
        layout: What lies where.
        name: Name of the store, for the title.
        angle_deg: How plan x is turned from robot x, for the arrow's words.
    """
    figures: list[Figure] = [
        Rectangle(
            x_mm=0.25,
            y_mm=0.25,
            width_mm=layout.width_mm - 0.5,
            height_mm=layout.height_mm - 0.5,
            stroke=_GREY,
            stroke_mm=0.5,
        ),
        *_origin(),
    ]
    letters = kind_letters([one.slot.kind for one in layout.slots])
    for one in layout.slots:
        figures += _slot(one, letters[one.slot.kind])
    for marker in layout.fiducials:
        half = marker.size_mm / 2
        figures.append(
            Bitmap(
                x_mm=marker.x_mm - half,
                y_mm=marker.y_mm - half,
                size_mm=marker.size_mm,
                rows=marker_rows(marker.marker_id),
            )
        )
    if layout.ruler_x is not None:
        figures += _ruler_x(layout.ruler_x)
    if layout.ruler_y is not None:
        figures += _ruler_y(layout.ruler_y)
    if layout.title is not None:
        figures += _title(layout, layout.title, name, angle_deg)
    return Drawing(
        width_mm=layout.width_mm, height_mm=layout.height_mm, figures=tuple(figures)
    )  # fmt: skip


def kind_letters(kinds: Sequence[str]) -> dict[str, str]:
    """Return the shortest beginning of each kind's name that no other kind has."""
    names = sorted(set(kinds))
    letters = {}
    for kind in names:
        others = [other for other in names if other != kind]
        length = next(
            (n for n in range(1, len(kind)) if not any(o.startswith(kind[:n]) for o in others)),
            len(kind),
        )
        letters[kind] = kind[:length].capitalize()
    return letters


def _slot(printed: PrintedSlot, letter: str) -> list[Figure]:
    slot, outline = printed.slot, printed.outline
    ink = INKS.get(slot.colour, _UNKNOWN_INK)
    x, y = slot.x_mm, slot.y_mm
    figures: list[Figure] = []
    if printed.size.shape == "cylinder":
        radius = outline.width_mm / 2
        figures.append(Circle(x_mm=x, y_mm=y, radius_mm=radius, fill=ink))
        figures.append(Circle(x_mm=x, y_mm=y, radius_mm=radius - _RING_MM, fill=WHITE))
        figures.append(
            Circle(x_mm=x, y_mm=y, radius_mm=radius - 0.15, stroke=BLACK, stroke_mm=0.3)
        )  # fmt: skip
    else:
        for inset, fill in ((0.0, ink), (_RING_MM, WHITE)):
            figures.append(_inset(outline, inset, fill=fill))
        figures.append(_inset(outline, 0.15, stroke=BLACK))
    top, low = outline.y_mm, outline.y_mm + outline.height_mm
    for edge, way in ((top, 1.0), (low, -1.0)):
        tip = (x, edge + way * 4.0)
        figures.append(Polygon(points_mm=((x - 3.0, edge), (x + 3.0, edge), tip)))
    number = str(slot.number)
    figures.append(
        Text(x_mm=x, y_mm=y + 2.2, size_mm=9.5, text=number, anchor="middle", bold=True)
    )  # fmt: skip
    figures.append(Text(x_mm=x, y_mm=y + 7.4, size_mm=4.6, text=letter, anchor="middle"))
    figures.append(
        Text(x_mm=outline.x_mm, y_mm=outline.y_mm - 1.2, size_mm=LABEL_MM, text=printed.label)
    )
    return figures


def _inset(
    area: Area, by_mm: float, fill: Colour | None = None, stroke: Colour | None = None
) -> Rectangle:
    return Rectangle(
        x_mm=area.x_mm + by_mm,
        y_mm=area.y_mm + by_mm,
        width_mm=area.width_mm - 2 * by_mm,
        height_mm=area.height_mm - 2 * by_mm,
        fill=fill,
        stroke=stroke,
    )


def _origin() -> list[Figure]:
    """Return the mark of the plan's corner, which is measured when the sheet is laid."""
    return [
        Polygon(points_mm=((0.0, 0.0), (9.0, 0.0), (0.0, 9.0))),
        Text(x_mm=1.2, y_mm=12.6, size_mm=2.6, text="(0, 0)"),
    ]


def _ruler_x(area: Area) -> list[Figure]:
    left, base = area.x_mm + 6.0, area.y_mm + 5.0
    figures: list[Figure] = [_stroke(left, base, left + RULER_MM, base)]
    for step in range(0, 101, 5):
        tall = 3.0 if step % 50 == 0 else 2.0 if step % 10 == 0 else 1.0
        figures.append(_stroke(left + step, base, left + step, base - tall))
    for step in (0, 50, 100):
        figures.append(
            Text(x_mm=left + step, y_mm=base + 3.0, size_mm=2.6, text=str(step), anchor="middle")
        )
    figures.append(Text(x_mm=left, y_mm=base + 6.4, size_mm=2.9, text=_ADVICE))
    return figures


def _ruler_y(area: Area) -> list[Figure]:
    base, top = area.x_mm + 5.0, area.y_mm + 6.0
    figures: list[Figure] = [_stroke(base, top, base, top + RULER_MM)]
    for step in range(0, 101, 5):
        tall = 3.0 if step % 50 == 0 else 2.0 if step % 10 == 0 else 1.0
        figures.append(_stroke(base, top + step, base - tall, top + step))
    for step in (0, 50, 100):
        figures.append(
            Text(x_mm=base + 1.0, y_mm=top + step + 0.9, size_mm=2.6, text=str(step))
        )  # fmt: skip
    figures.append(
        Text(x_mm=base + 7.4, y_mm=top + RULER_MM, size_mm=2.9, text=_ADVICE, turned=True)
    )
    return figures


def _title(layout: SheetLayout, area: Area, name: str, angle_deg: float) -> list[Figure]:
    wide = area.width_mm
    title = f"Store plan {name}".strip()
    size = min(7.0, 7.0 * (wide - 4.0) / text_width_mm(title, 7.0, bold=True))
    facts = (
        f"{layout.width_mm} x {layout.height_mm} mm, {len(layout.slots)} slots, "
        f"print {layout.identity[:8]}"
    )
    turned = "robot x" if angle_deg == 0 else f"robot x turned by {angle_deg:g} deg"
    base = area.y_mm + 17.5
    arrow_left = area.x_mm + 2.0
    return [
        Text(
            x_mm=area.x_mm + 2.0,
            y_mm=area.y_mm + 1.0 + size * CAPITAL_SHARE,
            size_mm=size,
            text=title,
            bold=True,
        ),
        Text(x_mm=area.x_mm + 2.0, y_mm=area.y_mm + 11.5, size_mm=3.8, text=facts),
        _stroke(arrow_left, base, arrow_left + 34.0, base, 1.0),
        Polygon(
            points_mm=(
                (arrow_left + 40.0, base),
                (arrow_left + 33.0, base - 2.5),
                (arrow_left + 33.0, base + 2.5),
            )
        ),
        Text(
            x_mm=arrow_left + 43.0, y_mm=base + 1.3, size_mm=3.8, text=f"plan x: along {turned}"
        ),
    ]  # fmt: skip


def _stroke(x1: float, y1: float, x2: float, y2: float, width_mm: float = 0.25) -> Line:
    return Line(x1_mm=x1, y1_mm=y1, x2_mm=x2, y2_mm=y2, width_mm=width_mm)
