"""What goes wrong when corners of a sheet are touched, each by its own name."""

from __future__ import annotations

import math

import numpy as np

from calibration.statistics import chi_square_quantile
from calibration.store_place.fitting import CORNERS, PlaceFit, Touched, distances_mm
from calibration.verdict import Finding, Grade
from cell.profile import StoreProfile

_UNIT_SLACK = 0.03
_SAME_MM = 10.0
_SCALE_SLACK = 0.002
_SIDE_SLACK = 0.02
_TURNED_DEG = 135.0
_ASKEW_DEG = 45.0
_CERTAIN = 0.999


def named_mistake(touched: Touched, was: StoreProfile) -> Finding | None:
    """Return the mistake that the touched corners show, if it is one with a name.

    Args:
        touched: The corners.
        was: Where the sheet is believed to lie until now.
    """
    apart = distances_mm(touched.points_mm)
    wanted = distances_mm(touched.plan_mm) * touched.scale
    if float(apart.min()) < _SAME_MM:
        index = int(np.argmin(apart))
        return _bad(
            "same-corner",
            f"{CORNERS[index]} and {CORNERS[index + 1]} were touched {apart[index]:.1f} mm from "
            f"each other; the sheet's side is {wanted[index]:.0f} mm",
            "touch each corner at its own place",
            index,
        )
    return _unit_mistake(apart, wanted) or _order_mistake(touched, apart, wanted, was)


def scale_finding(scale: float) -> Finding | None:
    """Return what the sheet's ruler says of the print."""
    if abs(scale - 1.0) <= _SCALE_SLACK:
        return None
    return Finding(
        code="printed-scale",
        grade=Grade.BAD,
        text=f"the sheet's ruler measures {100 * scale:.1f} mm: it is printed at "
        f"{100 * scale:.1f} %, and slots are off by up to {500 * abs(scale - 1):.1f} mm for each "
        "500 mm",
        hint="print it again at 100 %, not fitted to the page",
    )


def misfit_finding(touched: Touched, fitted: PlaceFit) -> Finding | None:
    """Return whether the corners fit together worse than touches are off."""
    total = float((fitted.residuals_mm**2).sum()) / touched.noise_mm**2
    freedom = fitted.residuals_mm.size - 3
    if total <= chi_square_quantile(_CERTAIN, freedom):
        return None
    far = np.linalg.norm(fitted.residuals_mm, axis=1)
    worst = int(np.argmax(far))
    if len(far) == 2:
        apart = float(distances_mm(touched.points_mm)[0])
        wanted = touched.size_mm[0] * touched.scale
        text = f"the two corners are {apart:.1f} mm apart and should be {wanted:.1f} mm"
    else:
        text = f"corner {CORNERS[worst]} lies {far[worst]:.1f} mm from where the others have it"
    return _bad(
        "corners-disagree",
        text,
        "touch the corners again, measure the ruler, and see that the sheet lies flat and is "
        "the one of this plan",
        worst,
    )


def _unit_mistake(apart: np.ndarray, wanted: np.ndarray) -> Finding | None:
    ratio = apart / wanted
    for factor, text in ((0.1, "centimetres"), (0.001, "metres"), (1 / 25.4, "inches")):
        if (np.abs(ratio / factor - 1.0) < _UNIT_SLACK).all():
            return _bad(
                "wrong-unit",
                f"the corners are {apart[0]:.2f} apart where {wanted[0]:.0f} mm are expected: "
                f"they look like {text}",
                "give millimetres",
            )
    return None


def _order_mistake(
    touched: Touched, apart: np.ndarray, wanted: np.ndarray, was: StoreProfile
) -> Finding | None:
    """Return whether corners were touched in another order than asked for."""
    points = touched.points_mm
    if len(points) > 2:
        first, second = points[1] - points[0], points[2] - points[1]
        if first[0] * second[1] - first[1] * second[0] > 0:
            return _bad(
                "mirrored",
                "the corners go round the sheet the other way: they were touched "
                "counter-clockwise, or the sheet is printed mirrored",
                "begin at the black triangle and go clockwise; see that the writing is readable",
            )
    tall = touched.size_mm[1] * touched.scale
    is_wide = abs(apart[0] / wanted[0] - 1.0) < _SIDE_SLACK
    if not is_wide and abs(apart[0] / tall - 1.0) < _SIDE_SLACK:
        return _bad(
            "wrong-corner",
            f"the second corner is {apart[0]:.0f} mm from the first, which is the sheet's "
            f"height; its upper right corner is {wanted[0]:.0f} mm away",
            "touch upper left, by the black triangle, then upper right, where the arrow points",
            1,
        )
    diagonal = math.hypot(wanted[0], tall)
    if not is_wide and abs(apart[0] / diagonal - 1.0) < _SIDE_SLACK:
        return _bad(
            "wrong-corner",
            f"the second corner is {apart[0]:.0f} mm from the first, which is the sheet's "
            f"diagonal; its upper right corner is {wanted[0]:.0f} mm away",
            "touch upper left, by the black triangle, then upper right, where the arrow points",
            1,
        )
    along = points[1] - points[0]
    turned = math.degrees(
        math.remainder(math.atan2(along[1], along[0]) - math.radians(was.angle_deg), math.tau)
    )
    if abs(turned) > _TURNED_DEG and is_wide:
        return _bad(
            "swapped-corners",
            f"the sheet would be turned by {turned:.0f} deg from before: upper left and upper "
            "right were taken for each other, or the sheet lies the wrong way round",
            "touch the corner by the black triangle first; if it was, turn the sheet",
        )
    if abs(turned) > _ASKEW_DEG and is_wide:
        return Finding(
            code="turned",
            grade=Grade.DEGRADED,
            text=f"the sheet is turned by {turned:.0f} deg from before",
            hint="if it was not laid anew, touch the corners again",
        )
    return None


def _bad(code: str, text: str, hint: str, *corners: int) -> Finding:
    return Finding(
        code=code,
        grade=Grade.BAD,
        text=text,
        hint=hint,
        samples=tuple(CORNERS[index] for index in corners),
    )
