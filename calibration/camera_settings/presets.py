"""Settings that the cell's own documents give."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from cell.devices.camera import CameraSettings

TABLE_SOURCE: Final = "Dubec 2011, table C.1"

TABLE_C1: Final[Mapping[str, CameraSettings]] = MappingProxyType(
    {
        "top": CameraSettings(
            exposure_ev=1.757,
            shutter_ms=16.020,
            gain_db=-4.012,
            white_balance_red=597,
            white_balance_blue=839,
        ),
        "oblique": CameraSettings(
            exposure_ev=0.539,
            shutter_ms=149.869,
            gain_db=6.053,
            white_balance_red=480,
            white_balance_blue=693,
        ),
        "gripper": CameraSettings(
            exposure_ev=1.398,
            shutter_ms=172.678,
            gain_db=9.678,
            white_balance_red=519,
            white_balance_blue=752,
        ),
    }
)
"""Settings by camera; what they have in common is the default of `CameraSettings`."""
