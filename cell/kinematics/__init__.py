"""Forward and inverse kinematics of the supported arms. Radians live only here."""

from cell.kinematics.closed_form import Joints, LinkPoints, Point
from cell.kinematics.geometry import RV_6SD, RV_6SDL, SixAxisGeometry
from cell.kinematics.rotation import Matrix34, matrix_from_pose, pose_from_matrix
from cell.kinematics.six_axis import SixAxisArm
from cell.kinematics.solutions import IkSolution, LimitViolation, ReachProblem

__all__ = [
    "RV_6SD",
    "RV_6SDL",
    "IkSolution",
    "Joints",
    "LimitViolation",
    "LinkPoints",
    "Matrix34",
    "Point",
    "ReachProblem",
    "SixAxisArm",
    "SixAxisGeometry",
    "matrix_from_pose",
    "pose_from_matrix",
]
