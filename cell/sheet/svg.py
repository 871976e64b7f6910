"""A drawing as SVG, one user unit a millimetre."""

from __future__ import annotations

from xml.sax.saxutils import escape

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


def svg_text(drawing: Drawing) -> str:
    """Return a drawing as an SVG document; the same drawing gives the same bytes."""
    wide, tall = _mm(drawing.width_mm), _mm(drawing.height_mm)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}mm" height="{tall}mm" '
        f'viewBox="0 0 {wide} {tall}">',
        f'<rect x="0" y="0" width="{wide}" height="{tall}" fill="#ffffff"/>',
        *(_figure(figure) for figure in drawing.figures),
        "</svg>",
        "",
    ]
    return "\n".join(lines)


def _figure(figure: Figure) -> str:
    match figure:
        case Rectangle():
            return (
                f'<rect x="{_mm(figure.x_mm)}" y="{_mm(figure.y_mm)}" '
                f'width="{_mm(figure.width_mm)}" height="{_mm(figure.height_mm)}" '
                f"{_paint(figure)}/>"
            )
        case Circle():
            return (
                f'<circle cx="{_mm(figure.x_mm)}" cy="{_mm(figure.y_mm)}" '
                f'r="{_mm(figure.radius_mm)}" {_paint(figure)}/>'
            )
        case Line():
            return (
                f'<line x1="{_mm(figure.x1_mm)}" y1="{_mm(figure.y1_mm)}" '
                f'x2="{_mm(figure.x2_mm)}" y2="{_mm(figure.y2_mm)}" '
                f'stroke="{_hex(figure.colour)}" stroke-width="{_mm(figure.width_mm)}"/>'
            )
        case Polygon():
            points = " ".join(f"{_mm(x)},{_mm(y)}" for x, y in figure.points_mm)
            return f'<polygon points="{points}" fill="{_hex(figure.fill)}"/>'
        case Bitmap():
            # Without this, a viewer's smoothing draws hairlines between the rows.
            inner = "".join(_figure(run) for run in figure.runs())
            return f'<g shape-rendering="crispEdges">{inner}</g>'
        case Text():
            return _text(figure)


def _text(text: Text) -> str:
    place = f'x="{_mm(text.x_mm)}" y="{_mm(text.y_mm)}"'
    turn = f' transform="rotate(-90 {_mm(text.x_mm)} {_mm(text.y_mm)})"' if text.turned else ""
    weight = ' font-weight="bold"' if text.bold else ""
    return (
        f'<text {place}{turn} font-family="Helvetica, Arial, sans-serif"{weight} '
        f'font-size="{_mm(text.size_mm)}" text-anchor="{text.anchor}" '
        f'fill="{_hex(text.colour)}">{escape(text.text)}</text>'
    )


def _paint(figure: Rectangle | Circle) -> str:
    fill = "none" if figure.fill is None else _hex(figure.fill)
    if figure.stroke is None:
        return f'fill="{fill}"'
    return f'fill="{fill}" stroke="{_hex(figure.stroke)}" stroke-width="{_mm(figure.stroke_mm)}"'


def _hex(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)


def _mm(value: float) -> str:
    """Return a number to a ten-thousandth, without a tail of zeros."""
    return f"{value:.4f}".rstrip("0").rstrip(".") or "0"
