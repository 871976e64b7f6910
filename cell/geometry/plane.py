"""From picture to a plane of the robot frame: a 2D homography."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PlaneMap:
    """Maps picture pixels to robot x and y on one horizontal plane.

    Attributes:
        rows: The 3 x 3 homography, picture to robot, row by row; applied to
            (u, v, 1) and divided by the third component (Hartley and Zisserman).
    """

    rows: tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]

    def to_robot(self, u_px: float, v_px: float) -> tuple[float, float]:
        """Return robot x and y in millimetres of a pixel.

        Raises:
            ValueError: The pixel lies on the map's horizon.
        """
        return _apply(self.rows, u_px, v_px)

    def to_picture(self, x_mm: float, y_mm: float) -> tuple[float, float]:
        """Return the pixel u, v of a robot point on the plane.

        Raises:
            ValueError: The map has no inverse, or the point lies on its horizon.
        """
        return _apply(_adjugate(self.rows), x_mm, y_mm)


_Rows = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]


def _apply(rows: _Rows, p: float, q: float) -> tuple[float, float]:
    w = rows[2][0] * p + rows[2][1] * q + rows[2][2]
    if abs(w) < 1e-12:
        raise ValueError(f"the point ({p:g}, {q:g}) lies on the horizon of the plane map")
    return (
        (rows[0][0] * p + rows[0][1] * q + rows[0][2]) / w,
        (rows[1][0] * p + rows[1][1] * q + rows[1][2]) / w,
    )


def _adjugate(rows: _Rows) -> _Rows:
    """Return the adjugate: the inverse up to a factor, which a homography ignores."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )
