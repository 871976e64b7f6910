"""The twin's cameras: rendered pictures of the cell behind the `Camera` protocol.

`TwinCamera` draws what lies on the table in one plane as a warped picture (the
backdrop, kept while it does not change) and everything that stands out of it as
shaded solids over it, through one model of lens and sensor.
"""

from cell.twin.cameras.arm_shape import ArmSkeleton
from cell.twin.cameras.camera import TwinCamera
from cell.twin.cameras.optics import Lens, lens_for_mode

__all__ = ["ArmSkeleton", "Lens", "TwinCamera", "lens_for_mode"]
