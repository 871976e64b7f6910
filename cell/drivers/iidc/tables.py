"""Where an IIDC 1.31 camera keeps each feature.

Addresses are bytes from the start of the 1394 register space, 0xFFFFF0000000. The source
gives gain and auto exposure by name of the maker; the other places are the IIDC standard's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from cell.devices.camera_features import FeatureName

COMMAND_BASE = 0xF00000
"""Where the command registers begin; a camera's configuration ROM names it."""

INQUIRY = COMMAND_BASE + 0x500
ABSOLUTE_INQUIRY = COMMAND_BASE + 0x700
CONTROL = COMMAND_BASE + 0x800

WHITE_BALANCE = 0x0C
"""Slot of the one register that holds two features."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Slot:
    """Where one feature lies.

    Attributes:
        offset: Bytes from the start of the inquiry, absolute and control blocks alike.
        scale: What one unit of the camera's absolute value is in ours, as a power of ten:
            shutters are in seconds there and in milliseconds here.
    """

    offset: int
    scale: int = 0


SLOTS: Mapping[FeatureName, Slot] = MappingProxyType(
    {
        "brightness": Slot(offset=0x00),
        "exposure": Slot(offset=0x04),
        "sharpness": Slot(offset=0x08),
        "white_balance_blue": Slot(offset=WHITE_BALANCE),
        "white_balance_red": Slot(offset=WHITE_BALANCE),
        "hue": Slot(offset=0x10),
        "saturation": Slot(offset=0x14),
        "gamma": Slot(offset=0x18),
        "shutter": Slot(offset=0x1C, scale=3),
        "gain": Slot(offset=0x20),
        "frame_rate": Slot(offset=0x3C),
        "pan": Slot(offset=0x84),
        "tilt": Slot(offset=0x88),
    }
)
