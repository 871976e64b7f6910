"""What the emulated body does by itself: automatic shutter, gain and white balance.

After each picture the body looks at its mean colour. Shutter first, then gain, bring its
brightness to the exposure target; the white balance makes the mean grey, whatever there is
to see: the false colours for which the cell's cameras are set by hand.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cell.devices.camera_features import FeatureName
from cell.twin.cameras.flea2 import SHUTTER_FRAME_PERIODS, Flea2Registers

_FULL_TARGET_EV = 2.4
"""Exposure value whose target is the full level."""

_FULL_LEVEL = 255.0
_DEAD_BAND = 0.02
_SLOWEST_STEP, _FASTEST_STEP = 0.5, 2.0
_STRIDE_PX = 8

METERED: tuple[FeatureName, ...] = ("shutter", "gain", "white_balance_red")


def is_metering(registers: Flea2Registers) -> bool:
    """Return whether pictures change any setting."""
    return any(registers.is_auto(name) for name in METERED)


def meter(registers: Flea2Registers, pixels: NDArray[np.uint8]) -> None:
    """Let the body adjust what is automatic after a picture (height, width, 3)."""
    red, green, blue = (float(k) for k in pixels[::_STRIDE_PX, ::_STRIDE_PX].mean(axis=(0, 1)))
    target = _FULL_LEVEL * 2.0 ** (registers.absolute("exposure") - _FULL_TARGET_EV)
    factor = _factor(target, (red + green + blue) / 3.0)
    if registers.is_auto("shutter"):
        factor = _turn_shutter(registers, factor)
    if registers.is_auto("gain") and factor != 1.0:
        registers.adjust("gain", registers.absolute("gain") + 20.0 * math.log10(factor))
    if registers.is_auto("white_balance_red"):
        registers.adjust_white_balance(
            {
                "white_balance_red": _factor(green, red),
                "white_balance_blue": _factor(green, blue),
            }
        )


def _turn_shutter(registers: Flea2Registers, factor: float) -> float:
    """Adjust the shutter; return the factor that is left for the gain."""
    before = registers.absolute("shutter")
    longest_s = SHUTTER_FRAME_PERIODS / registers.absolute("frame_rate")
    registers.adjust("shutter", before * factor)
    is_at_end = before >= longest_s and factor > 1.0
    return factor if is_at_end else 1.0


def _factor(wanted: float, seen: float) -> float:
    """Return by what to multiply, in bounds; 1 when it is near enough."""
    factor = wanted / max(seen, 1.0)
    if abs(factor - 1.0) < _DEAD_BAND:
        return 1.0
    return min(max(factor, _SLOWEST_STEP), _FASTEST_STEP)
