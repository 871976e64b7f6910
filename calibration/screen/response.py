"""How bright the screen appears: the grey that no camera clips, and the screen's gamma."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.verdict import Finding, Grade

Pixels = NDArray[np.uint8]

_FULL_LEVEL = 225.0
_CLIPPED_LEVEL = 245.0
_GAMMAS = np.linspace(1.0, 3.2, 45)
_LEAST_SWING = 30.0
_LIT_SHARE = 0.4
_LEAST_LIT = 0.02
_BRIGHT_LAMPS_LEVEL = 140.0
_STANDARD_GAMMA = 2.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """How a camera sees grey fields of the screen.

    Attributes:
        bright: Brightest value, 0 to 255, that stays below what the camera can tell.
        gamma: Light goes with (value / 255) to this power.
        black: Level of the black screen.
        findings: What is wrong.
    """

    bright: int
    gamma: float
    black: float
    findings: tuple[Finding, ...] = ()


def read_response(camera: str, fields: Mapping[int, Pixels]) -> Response:
    """Return how a camera sees grey fields.

    Args:
        camera: Its name, for what is found.
        fields: Pictures (h, w, 3) of the screen by the value shown on it, 0 and 255 among them.
    """
    values = sorted(fields)
    brightest = {value: fields[value].max(axis=2) for value in values}
    rise = brightest[values[-1]].astype(np.int16) - brightest[values[0]]
    most = float(np.percentile(rise, 99.0))
    lit = rise > max(_LIT_SHARE * most, 1.0)
    if most < _LEAST_SWING or float(lit.mean()) < _LEAST_LIT:
        return _dark(camera, most, float(np.median(brightest[values[0]])))
    levels = np.array([float(np.percentile(brightest[value][lit], 99.5)) for value in values])
    usable = levels < _CLIPPED_LEVEL
    black = float(np.median(brightest[values[0]][lit]))
    shares = np.array(values) / 255.0
    if int(usable.sum()) < 3:
        return Response(
            bright=values[1],
            gamma=_STANDARD_GAMMA,
            black=black,
            findings=(_clips(camera, values[1]),),
        )
    gamma, offset, slope = _power(shares[usable], levels[usable])
    share = min(max((_FULL_LEVEL - offset) / slope, 0.0), 1.0)
    bright = round(255.0 * share ** (1.0 / gamma))
    findings: tuple[Finding, ...] = ()
    if black > _BRIGHT_LAMPS_LEVEL:
        findings = (
            Finding(
                code="lights-too-bright",
                grade=Grade.DEGRADED,
                text=f"camera {camera} sees the black screen at level {black:.0f} of 255: the "
                "lights or their reflection in the glass leave little for the pattern",
                hint="dim the lights, or move the lamp that is mirrored in the screen",
            ),
        )
    return Response(bright=bright, gamma=gamma, black=black, findings=findings)


def _power(shares: NDArray[np.float64], levels: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return gamma, offset and slope of level = offset + slope · share^gamma."""
    best = (np.inf, _STANDARD_GAMMA, 0.0, 1.0)
    for gamma in _GAMMAS:
        basis = np.column_stack([np.ones_like(shares), shares**gamma])
        solved, *_ = np.linalg.lstsq(basis, levels, rcond=None)
        off = float(np.sum((basis @ solved - levels) ** 2))
        if off < best[0]:
            best = (off, float(gamma), float(solved[0]), float(solved[1]))
    return best[1:]


def _clips(camera: str, value: int) -> Finding:
    return Finding(
        code="picture-clips",
        grade=Grade.BAD,
        text=f"camera {camera} clips as soon as the screen shows more than grey {value} of 255",
        hint="shorten its shutter or lower its gain, dim the lights, and lower the screen's "
        "backlight",
    )


def _dark(camera: str, rise: float, black: float) -> Response:
    if black > _BRIGHT_LAMPS_LEVEL:
        found = Finding(
            code="lights-too-bright",
            grade=Grade.BAD,
            text=f"camera {camera} tells white from black on the screen by {rise:.0f} levels only, "
            f"and its picture lies at {black:.0f} of 255 already",
            hint="dim the lights or shorten the camera's shutter",
        )
    else:
        found = Finding(
            code="screen-not-seen",
            grade=Grade.BAD,
            text=f"camera {camera} tells white from black on the screen by {rise:.0f} levels only",
            hint="see whether the television is on and shows the page, and whether the camera's "
            "lens is free",
        )
    return Response(bright=255, gamma=_STANDARD_GAMMA, black=black, findings=(found,))
