"""A MELFA controller behind the R3 text protocol."""

from cell.twin.emulators.melfa_r3.controller import MelfaController
from cell.twin.emulators.melfa_r3.settings import ControllerSettings
from cell.twin.emulators.melfa_r3.stand import ArmKinematics

__all__ = ["ArmKinematics", "ControllerSettings", "MelfaController"]
