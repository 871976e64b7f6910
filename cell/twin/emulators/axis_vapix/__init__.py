"""An emulated AXIS web camera: an HTTP server that speaks VAPIX."""

from cell.twin.emulators.axis_vapix.camera import EmulatedAxisCamera
from cell.twin.emulators.axis_vapix.faults import WebCameraFault
from cell.twin.emulators.axis_vapix.head import Head, HeadState
from cell.twin.emulators.axis_vapix.pictures import PictureSource, panorama
from cell.twin.emulators.axis_vapix.settings import AuthMode, EmulatedAxisSettings

__all__ = [
    "AuthMode",
    "EmulatedAxisCamera",
    "EmulatedAxisSettings",
    "Head",
    "HeadState",
    "PictureSource",
    "WebCameraFault",
    "panorama",
]
