"""Values of space: poses, transforms, lens, lattice map, plane map and camera views.

Frozen values only; who fits them lives in `calibration`.
"""

from cell.geometry.lattice import LatticeMap
from cell.geometry.lens import LensModel
from cell.geometry.plane import PlaneMap
from cell.geometry.pose import JointPositions, Pose
from cell.geometry.table_view import CameraView, PlaneView, TableView
from cell.geometry.transform import Transform

__all__ = [
    "CameraView",
    "JointPositions",
    "LatticeMap",
    "LensModel",
    "PlaneMap",
    "PlaneView",
    "Pose",
    "TableView",
    "Transform",
]
