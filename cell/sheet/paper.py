"""From a drawing to pages: on one paper of its own size, or tiled on smaller ones.

Neighbouring tiles overlap, so that a cut may be a little off. Crop marks tell where to cut;
arrow heads in the margin tell where the next page's cut edge has to lie: pages of a row are
joined first, then row to row. Every page has its own check rulers, because a printer scales
each page by itself.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from cell.sheet.drawing import Colour, Drawing, Figure, Line, Polygon, Text
from cell.sheet.errors import SheetError
from cell.sheet.pdf import Page, Window

MARGIN_MM = 10.0
"""White edge of every page: printers cannot print on it, or crop marks are there."""
OVERLAP_MM = 8.0
CHECK_MM = 100.0
"""Length of the check rulers."""
_MOST_PAGES = 200
_GREY: Colour = (110, 110, 110)

_NAMED = {"a4": (210.0, 297.0), "a3": (297.0, 420.0)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Paper:
    """Paper of a size, either way round.

    Attributes:
        width_mm: One side.
        height_mm: The other side.
    """

    width_mm: float
    height_mm: float


def paper_of(text: str) -> Paper:
    """Return the paper of a name (`a4`, `a3`) or a size in millimetres (`610x420`).

    Raises:
        SheetError: It is no name and no size, or the paper has no room for anything.
    """
    named = _NAMED.get(text.lower())
    if named is not None:
        return Paper(width_mm=named[0], height_mm=named[1])
    size = re.fullmatch(r"(\d+(?:\.\d+)?)\s*[xX]\s*(\d+(?:\.\d+)?)", text)
    if size is None:
        raise SheetError(
            f"there is no paper {text!r}; there are a4, a3, or a size in mm such as 610x420"
        )
    paper = Paper(width_mm=float(size[1]), height_mm=float(size[2]))
    least = 2 * MARGIN_MM + CHECK_MM + 20.0
    if min(paper.width_mm, paper.height_mm) < least or max(size[1], size[2]) == "inf":
        raise SheetError(
            f"paper of {text} mm is too small: each side needs {least:g} mm at least; "
            "sizes are millimetres, not centimetres"
        )
    return paper


def pages_of(drawing: Drawing, paper: Paper | None = None) -> tuple[Page, ...]:
    """Return the pages that show a whole drawing at its true size.

    Args:
        drawing: What to print.
        paper: What to print on; None for one page of the drawing's size with margins.

    Raises:
        SheetError: It would take more than 200 pages.
    """
    if paper is None:
        paper = Paper(
            width_mm=drawing.width_mm + 2 * MARGIN_MM, height_mm=drawing.height_mm + 2 * MARGIN_MM
        )
        return _tiled(drawing, paper)
    upright = Paper(width_mm=paper.width_mm, height_mm=paper.height_mm)
    across = Paper(width_mm=paper.height_mm, height_mm=paper.width_mm)
    best = min((upright, across), key=lambda one: math.prod(_counts(drawing, one)))
    count = math.prod(_counts(drawing, best))
    if count > _MOST_PAGES:
        raise SheetError(
            f"the sheet of {drawing.width_mm:g} x {drawing.height_mm:g} mm would take {count} "
            "pages of that paper; take a larger one"
        )
    return _tiled(drawing, best)


def _counts(drawing: Drawing, paper: Paper) -> tuple[int, int]:
    """Return columns and rows of tiles."""
    return (
        _count(drawing.width_mm, paper.width_mm - 2 * MARGIN_MM),
        _count(drawing.height_mm, paper.height_mm - 2 * MARGIN_MM),
    )


def _count(whole_mm: float, window_mm: float) -> int:
    if whole_mm <= window_mm + 1e-6:
        return 1
    return math.ceil((whole_mm - OVERLAP_MM - 1e-6) / (window_mm - OVERLAP_MM))


def _tiled(drawing: Drawing, paper: Paper) -> tuple[Page, ...]:
    columns, rows = _counts(drawing, paper)
    lefts = _begins(paper.width_mm - 2 * MARGIN_MM, columns)
    tops = _begins(paper.height_mm - 2 * MARGIN_MM, rows)
    pages: list[Page] = []
    for row, top in enumerate(tops):
        for column, left in enumerate(lefts):
            window = Window(
                drawing=drawing,
                left_mm=left,
                top_mm=top,
                width_mm=min(paper.width_mm - 2 * MARGIN_MM, drawing.width_mm - left),
                height_mm=min(paper.height_mm - 2 * MARGIN_MM, drawing.height_mm - top),
                at_mm=(MARGIN_MM, MARGIN_MM),
            )
            label = f"page {len(pages) + 1} of {rows * columns}"
            if rows * columns > 1:
                label += f": row {row + 1}, column {column + 1}"
            marks = (
                *_crop_marks(window),
                *_join_marks(window, lefts[column + 1 :], tops[row + 1 :]),
                *_labels(window, label),
            )
            pages.append(
                Page(width_mm=paper.width_mm, height_mm=paper.height_mm, window=window, marks=marks)
            )
    return tuple(pages)


def _begins(window_mm: float, count: int) -> tuple[float, ...]:
    """Return where tiles begin; the last is as short as what is left."""
    return tuple(index * (window_mm - OVERLAP_MM) for index in range(count))


def _crop_marks(window: Window) -> list[Figure]:
    """Return marks in the margin at the window's edges: cut from mark to mark."""
    x, y = window.at_mm
    marks: list[Figure] = []
    near, far = 1.5, 7.0
    for at in (x, x + window.width_mm):
        for edge, way in ((y, -1.0), (y + window.height_mm, 1.0)):
            marks.append(
                Line(x1_mm=at, y1_mm=edge + way * near, x2_mm=at, y2_mm=edge + way * far,
                     width_mm=0.2)
            )  # fmt: skip
    for at in (y, y + window.height_mm):
        for edge, way in ((x, -1.0), (x + window.width_mm, 1.0)):
            marks.append(
                Line(x1_mm=edge + way * near, y1_mm=at, x2_mm=edge + way * far, y2_mm=at,
                     width_mm=0.2)
            )  # fmt: skip
    return marks


def _join_marks(
    window: Window, next_lefts: tuple[float, ...], next_tops: tuple[float, ...]
) -> list[Figure]:
    """Return arrow heads where the next column's left and the next row's upper edge lie."""
    x, y = window.at_mm
    marks: list[Figure] = []
    if next_lefts:
        at = x + next_lefts[0] - window.left_mm
        for edge, way in ((y, -1.0), (y + window.height_mm, 1.0)):
            tip = edge + way * 0.5
            foot = tip + way * 2.5
            marks.append(Polygon(points_mm=((at, tip), (at - 1.0, foot), (at + 1.0, foot))))
    if next_tops:
        at = y + next_tops[0] - window.top_mm
        for edge, way in ((x, -1.0), (x + window.width_mm, 1.0)):
            tip = edge + way * 0.5
            foot = tip + way * 2.5
            marks.append(Polygon(points_mm=((tip, at), (foot, at - 1.0), (foot, at + 1.0))))
    return marks


def _labels(window: Window, label: str) -> list[Figure]:
    """Return the page's label and its check rulers, in the margin below and at the left."""
    x, y = window.at_mm
    below = y + window.height_mm + 3.5
    ruler = [
        *_check_ruler(x + 6.0, below, is_upright=False),
        Text(
            x_mm=x + 6.0,
            y_mm=below + 4.6,
            size_mm=2.6,
            colour=_GREY,
            text="must measure 100.0 mm: else print at 100 %, not fitted to the page",
        ),
        *_check_ruler(x - 3.5, y + 6.0, is_upright=True),
    ]
    where = f"{label}; sheet x {window.left_mm:.1f}, y {window.top_mm:.1f} mm at its upper left"
    ruler.append(Text(x_mm=x + 8.0, y_mm=y - 3.0, size_mm=3.2, text=where, colour=_GREY))
    return ruler


def _check_ruler(x_mm: float, y_mm: float, *, is_upright: bool) -> list[Figure]:
    marks: list[Figure] = []
    for step in range(11):
        at, half = 10.0 * step, 1.5 if step % 10 == 0 else 0.8
        ends = (
            (x_mm - half, y_mm + at, x_mm + half, y_mm + at)
            if is_upright
            else (x_mm + at, y_mm - half, x_mm + at, y_mm + half)
        )
        marks.append(_line(*ends))
    end = (x_mm, y_mm + CHECK_MM) if is_upright else (x_mm + CHECK_MM, y_mm)
    marks.append(_line(x_mm, y_mm, *end))
    return marks


def _line(x1_mm: float, y1_mm: float, x2_mm: float, y2_mm: float) -> Line:
    return Line(x1_mm=x1_mm, y1_mm=y1_mm, x2_mm=x2_mm, y2_mm=y2_mm, width_mm=0.2)
