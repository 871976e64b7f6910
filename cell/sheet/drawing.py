"""A drawing that knows no file format: figures in millimetres, written to SVG, PDF or pixels.

x runs to the right, y down, from the drawing's upper left corner. What comes first lies
below what comes later.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Colour = tuple[int, int, int]
"""Red, green and blue, 0..255."""

BLACK: Colour = (0, 0, 0)
WHITE: Colour = (255, 255, 255)

Anchor = Literal["start", "middle", "end"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rectangle:
    """A rectangle along the axes.

    Attributes:
        x_mm: Its left edge, in the middle of the stroke.
        y_mm: Its upper edge.
        width_mm: Its width.
        height_mm: Its height.
        fill: Colour inside; None leaves what is below.
        stroke: Colour of the edge; None for none.
        stroke_mm: Width of the edge.
    """

    x_mm: float
    y_mm: float
    width_mm: float
    height_mm: float
    fill: Colour | None = None
    stroke: Colour | None = None
    stroke_mm: float = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class Circle:
    """A circle.

    Attributes:
        x_mm: Its centre.
        y_mm: Its centre.
        radius_mm: Radius to the middle of the stroke.
        fill: Colour inside; None leaves what is below.
        stroke: Colour of the edge; None for none.
        stroke_mm: Width of the edge.
    """

    x_mm: float
    y_mm: float
    radius_mm: float
    fill: Colour | None = None
    stroke: Colour | None = None
    stroke_mm: float = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A straight stroke with flat ends.

    Attributes:
        x1_mm: Where it begins.
        y1_mm: Where it begins.
        x2_mm: Where it ends.
        y2_mm: Where it ends.
        colour: Its colour.
        width_mm: Its width.
    """

    x1_mm: float
    y1_mm: float
    x2_mm: float
    y2_mm: float
    colour: Colour = BLACK
    width_mm: float = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class Polygon:
    """A filled area.

    Attributes:
        points_mm: Its corners.
        fill: Its colour.
    """

    points_mm: tuple[tuple[float, float], ...]
    fill: Colour = BLACK


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """A line of text in Helvetica.

    Attributes:
        x_mm: Where `anchor` is.
        y_mm: Its base line.
        size_mm: Height of the font's body; capitals are 0.72 of it.
        text: What it says.
        anchor: What of the line lies at `x_mm`.
        bold: Whether it is bold.
        colour: Its colour.
        turned: Whether it runs upwards instead of to the right.
    """

    x_mm: float
    y_mm: float
    size_mm: float
    text: str
    anchor: Anchor = "start"
    bold: bool = False
    colour: Colour = BLACK
    turned: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Bitmap:
    """A square pattern of black and white modules, such as a marker.

    Attributes:
        x_mm: Its left edge.
        y_mm: Its upper edge.
        size_mm: Its side.
        rows: Modules from the top, each row from the left; True is black.
    """

    x_mm: float
    y_mm: float
    size_mm: float
    rows: tuple[tuple[bool, ...], ...]

    def runs(self) -> tuple[Rectangle, ...]:
        """Return the black modules as rectangles, each as long as its row allows."""
        step = self.size_mm / len(self.rows)
        found = []
        for index, row in enumerate(self.rows):
            begin: int | None = None
            for column, is_black in enumerate((*row, False)):
                if is_black and begin is None:
                    begin = column
                elif not is_black and begin is not None:
                    found.append(
                        Rectangle(
                            x_mm=self.x_mm + begin * step,
                            y_mm=self.y_mm + index * step,
                            width_mm=(column - begin) * step,
                            height_mm=step,
                            fill=BLACK,
                        )
                    )
                    begin = None
        return tuple(found)


Figure = Rectangle | Circle | Line | Polygon | Text | Bitmap


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawing:
    """Figures on a white sheet.

    Attributes:
        width_mm: Width of the sheet.
        height_mm: Height of the sheet.
        figures: What is drawn, the lowest first.
    """

    width_mm: float
    height_mm: float
    figures: tuple[Figure, ...]
