"""A PG-70 gripper as the other end of a SCHUNK Motion Protocol line."""

from cell.twin.emulators.schunk_smp.module import SchunkModule
from cell.twin.emulators.schunk_smp.settings import SchunkModuleSettings

__all__ = ["SchunkModule", "SchunkModuleSettings"]
