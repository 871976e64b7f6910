"""The speed of moves by hand, kept beside the state of the cell from command to command."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from console.places import cell_folder

if TYPE_CHECKING:
    from cell.profile import CellProfile

_FILE = "speed-by-hand.json"


def kept_speed(profile: CellProfile) -> tuple[float, float]:
    """Return the speed along lines in mm/s and the share of full speed in percent.

    Whatever is kept beyond the profile's limit, or cannot be read, is as if not kept.
    """
    arm = profile.arm
    own = (arm.linear_speed_mm_s, arm.joint_speed_percent)
    try:
        kept = json.loads((cell_folder(profile.name) / _FILE).read_text("utf-8"))
        line, share = float(kept["speed_mm_s"]), float(kept["joint_percent"])
    except (OSError, ValueError, KeyError, TypeError):
        return own
    is_allowed = 0 < line <= arm.max_linear_speed_mm_s and 0 < share <= 100
    return (line, share) if is_allowed else own


def keep_speed(profile: CellProfile, speed_mm_s: float, joint_percent: float) -> None:
    """Keep a speed for later commands."""
    folder = cell_folder(profile.name)
    folder.mkdir(parents=True, exist_ok=True)
    kept = {"speed_mm_s": speed_mm_s, "joint_percent": joint_percent}
    (folder / _FILE).write_text(json.dumps(kept), "utf-8")
