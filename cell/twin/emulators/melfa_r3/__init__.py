"""A MELFA controller behind the R3 text protocol."""

from cell.twin.emulators.melfa_r3.controller import MelfaController
from cell.twin.emulators.melfa_r3.planner import ArmKinematics
from cell.twin.emulators.melfa_r3.settings import ControllerSettings

__all__ = ["ArmKinematics", "ControllerSettings", "MelfaController"]
