"""An SSC-32 servo controller with hobby servos, as an emulator behind a link."""

from cell.twin.emulators.ssc32.controller import KeptController, Ssc32Controller
from cell.twin.emulators.ssc32.mechanics import LynxMechanics, Sag
from cell.twin.emulators.ssc32.servos import ServoBank, ServoErrors, TwinServo
from cell.twin.emulators.ssc32.settings import Ssc32ControllerSettings

__all__ = [
    "KeptController",
    "LynxMechanics",
    "Sag",
    "ServoBank",
    "ServoErrors",
    "Ssc32Controller",
    "Ssc32ControllerSettings",
    "TwinServo",
]
