"""AXIS network cameras: stills, streams, pan, tilt and zoom by VAPIX over HTTP."""

from cell.drivers.axis_vapix.driver import AxisCamera
from cell.drivers.axis_vapix.replies import HeadLimits, HeadPosition
from cell.drivers.axis_vapix.settings import AxisSettings
from cell.drivers.axis_vapix.stream import AxisStream, WebPicture

__all__ = [
    "AxisCamera",
    "AxisSettings",
    "AxisStream",
    "HeadLimits",
    "HeadPosition",
    "WebPicture",
]
