"""Values of space: poses, transforms, the lattice map and the plane map.

Frozen values only; who fits them lives in `calibration`.
"""

from cell.geometry.lattice import LatticeMap
from cell.geometry.plane import PlaneMap
from cell.geometry.pose import JointPositions, Pose
from cell.geometry.transform import Transform

__all__ = ["JointPositions", "LatticeMap", "PlaneMap", "Pose", "Transform"]
