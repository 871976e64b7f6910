"""Paths, ranges and words of VAPIX (AXIS HTTP API 2 and 3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

STILL_PATH: Final = "/axis-cgi/jpg/image.cgi"
STREAM_PATH: Final = "/axis-cgi/mjpg/video.cgi"
HEAD_PATH: Final = "/axis-cgi/com/ptz.cgi"
PARAMETER_PATH: Final = "/axis-cgi/param.cgi"

Direction: TypeAlias = Literal[
    "up", "down", "left", "right", "upleft", "upright", "downleft", "downright"
]
DIRECTIONS: Final[dict[Direction, tuple[int, int]]] = {
    "up": (0, 1),
    "down": (0, -1),
    "left": (-1, 0),
    "right": (1, 0),
    "upleft": (-1, 1),
    "upright": (1, 1),
    "downleft": (-1, -1),
    "downright": (1, -1),
}
"""Sign of pan and tilt of each direction."""


@dataclass(frozen=True, slots=True)
class Span:
    """An allowed range with its unit."""

    least: float
    most: float
    unit: str = ""

    def allows(self, value: float) -> bool:
        """Return whether a value lies in the range."""
        return self.least <= value <= self.most


PAN: Final = Span(-180.0, 180.0, "deg")
TILT: Final = Span(-180.0, 180.0, "deg")
RELATIVE_ANGLE: Final = Span(-360.0, 360.0, "deg")
LENS: Final = Span(1, 9999)
"""Zoom (1 is wide), focus, iris and brightness; very old units go to 999."""
RELATIVE_LENS: Final = Span(-9999, 9999)
PERCENT: Final = Span(-100, 100, "%")
SPEED: Final = Span(1, 100)
COMPRESSION: Final = Span(0, 100)
"""The higher, the smaller the file."""
