"""Drawings as PDF 1.4, by hand: vectors, base fonts, exact millimetres.

A page's content is in points (1/72 inch) with y upwards; one matrix at its beginning turns
that into the drawing's millimetres with y down, so that all figures keep their numbers.
Nothing depends on the day or the machine: the same pages give the same bytes. The viewer
is told not to scale when it prints.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

from cell.sheet.drawing import (
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
from cell.sheet.fonts import text_width_mm

POINTS_PER_MM = 72.0 / 25.4

_ARC = 0.5522847498
"""Length of a Bézier handle of a quarter circle of radius 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Window:
    """A part of a drawing on a page.

    Attributes:
        drawing: The drawing.
        left_mm: Drawing x of the part's left edge.
        top_mm: Drawing y of its upper edge.
        width_mm: Width of the part.
        height_mm: Height of the part.
        at_mm: Where on the page its upper left corner is, from the page's.
    """

    drawing: Drawing
    left_mm: float
    top_mm: float
    width_mm: float
    height_mm: float
    at_mm: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """One page.

    Attributes:
        width_mm: Width of the paper.
        height_mm: Height of the paper.
        window: What of the drawing is on it.
        marks: What is printed around it, in millimetres of the page.
    """

    width_mm: float
    height_mm: float
    window: Window
    marks: tuple[Figure, ...] = ()


def pdf_bytes(pages: Sequence[Page], title: str) -> bytes:
    """Return pages as a PDF file.

    Args:
        pages: The pages, the first first.
        title: What viewers show as the document's name.
    """
    first_page = 6
    kids = " ".join(f"{first_page + 2 * i} 0 R" for i in range(len(pages)))
    bodies = [
        b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences "
        b"<< /PrintScaling /None /DisplayDocTitle true >> >>",
        f"<< /Type /Pages /Count {len(pages)} /Kids [{kids}] >>".encode(),
        _font("Helvetica"),
        _font("Helvetica-Bold"),
        b"<< /Title (" + _escaped(title) + b") >>",
    ]
    for index, page in enumerate(pages):
        content = _content(page)
        size = f"{_number(page.width_mm * POINTS_PER_MM)} {_number(page.height_mm * POINTS_PER_MM)}"
        bodies.append(
            (
                f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {size}] "
                "/Resources << /Font << /F1 3 0 R /F2 4 0 R >> >> "
                f"/Contents {first_page + 2 * index + 1} 0 R >>"
            ).encode()
        )
        head = f"<< /Length {len(content)} >>\nstream\n".encode()
        bodies.append(head + content + b"\nendstream")
    return _file(bodies)


def _file(bodies: Sequence[bytes]) -> bytes:
    """Return the file: header, numbered objects, their places, trailer."""
    out = bytearray(b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n")
    places = []
    for number, body in enumerate(bodies, start=1):
        places.append(len(out))
        out += f"{number} 0 obj\n".encode() + body + b"\nendobj\n"
    begin = len(out)
    name = hashlib.sha256(bytes(out)).hexdigest()[:32]
    out += f"xref\n0 {len(bodies) + 1}\n0000000000 65535 f \n".encode()
    out += b"".join(f"{place:010d} 00000 n \n".encode() for place in places)
    out += (
        f"trailer\n<< /Size {len(bodies) + 1} /Root 1 0 R /Info 5 0 R "
        f"/ID [<{name}> <{name}>] >>\nstartxref\n{begin}\n%%EOF\n"
    ).encode()
    return bytes(out)


def _font(name: str) -> bytes:
    return (
        f"<< /Type /Font /Subtype /Type1 /BaseFont /{name} /Encoding /WinAnsiEncoding >>"
    ).encode()


def _content(page: Page) -> bytes:
    window = page.window
    lines: list[bytes] = [
        # From here on millimetres of the page, y down.
        f"{_number(POINTS_PER_MM)} 0 0 {_number(-POINTS_PER_MM)} 0 "
        f"{_number(page.height_mm * POINTS_PER_MM)} cm".encode(),
        b"q",
        _box(*window.at_mm, window.width_mm, window.height_mm) + b" W n",
        f"1 0 0 1 {_number(window.at_mm[0] - window.left_mm)} "
        f"{_number(window.at_mm[1] - window.top_mm)} cm".encode(),
    ]
    lines += [_figure(figure) for figure in window.drawing.figures]
    lines.append(b"Q")
    lines += [_figure(figure) for figure in page.marks]
    return b"\n".join(lines)


def _figure(figure: Figure) -> bytes:
    match figure:
        case Rectangle():
            path = _box(figure.x_mm, figure.y_mm, figure.width_mm, figure.height_mm)
            return _painted(figure, path)
        case Circle():
            return _painted(figure, _circle(figure))
        case Line():
            ends = f"{_xy(figure.x1_mm, figure.y1_mm)} m {_xy(figure.x2_mm, figure.y2_mm)} l S"
            return f"{_rgb(figure.colour)} RG {_number(figure.width_mm)} w {ends}".encode()
        case Polygon():
            first, *others = figure.points_mm
            corners = f"{_xy(*first)} m " + " ".join(f"{_xy(*point)} l" for point in others)
            return f"{_rgb(figure.fill)} rg {corners} h f".encode()
        case Bitmap():
            # One path, so that no viewer draws hairlines between the rows.
            boxes = [_box(r.x_mm, r.y_mm, r.width_mm, r.height_mm) for r in figure.runs()]
            return b"0 0 0 rg " + b" ".join(boxes) + b" f"
        case Text():
            return _text(figure)


def _text(text: Text) -> bytes:
    width = text_width_mm(text.text, text.size_mm, bold=text.bold)
    back = {"start": 0.0, "middle": 0.5, "end": 1.0}[text.anchor] * width
    if text.turned:
        matrix = f"0 -1 -1 0 {_xy(text.x_mm, text.y_mm + back)}"
    else:
        matrix = f"1 0 0 -1 {_xy(text.x_mm - back, text.y_mm)}"
    font = "F2" if text.bold else "F1"
    return (
        f"BT {_rgb(text.colour)} rg /{font} {_number(text.size_mm)} Tf {matrix} Tm (".encode()
        + _escaped(text.text)
        + b") Tj ET"
    )


def _painted(figure: Rectangle | Circle, path: bytes) -> bytes:
    parts = []
    if figure.fill is not None:
        parts.append(f"{_rgb(figure.fill)} rg".encode())
    if figure.stroke is not None:
        parts.append(f"{_rgb(figure.stroke)} RG {_number(figure.stroke_mm)} w".encode())
    verb = {(True, True): b"B", (True, False): b"f", (False, True): b"S", (False, False): b"n"}
    end = verb[figure.fill is not None, figure.stroke is not None]
    return b" ".join([*parts, path, end])


def _box(x: float, y: float, wide: float, tall: float) -> bytes:
    return f"{_xy(x, y)} {_xy(wide, tall)} re".encode()


def _circle(circle: Circle) -> bytes:
    x, y, r, k = circle.x_mm, circle.y_mm, circle.radius_mm, circle.radius_mm * _ARC
    quarters = (
        ((x + r, y + k), (x + k, y + r), (x, y + r)),
        ((x - k, y + r), (x - r, y + k), (x - r, y)),
        ((x - r, y - k), (x - k, y - r), (x, y - r)),
        ((x + k, y - r), (x + r, y - k), (x + r, y)),
    )
    curves = " ".join(" ".join(_xy(*point) for point in quarter) + " c" for quarter in quarters)
    return f"{_xy(x + r, y)} m {curves} h".encode()


def _escaped(text: str) -> bytes:
    data = text.encode("cp1252", errors="replace")
    for special in (b"\\", b"(", b")"):
        data = data.replace(special, b"\\" + special)
    return data


def _rgb(colour: Colour) -> str:
    return " ".join(_number(channel / 255.0) for channel in colour)


def _xy(x: float, y: float) -> str:
    return f"{_number(x)} {_number(y)}"


def _number(value: float) -> str:
    """Return a number as PDF writes it: no exponent, no tail of zeros, no minus zero."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text
