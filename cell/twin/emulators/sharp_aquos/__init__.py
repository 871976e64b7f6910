"""A Sharp television as the other end of an AQUOS line."""

from cell.twin.emulators.sharp_aquos.settings import SharpTelevisionSettings
from cell.twin.emulators.sharp_aquos.television import SharpTelevision

__all__ = ["SharpTelevision", "SharpTelevisionSettings"]
