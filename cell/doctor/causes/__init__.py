"""The causes that the doctor knows, as data; the page of causes is made of them."""

from __future__ import annotations

from cell.doctor.causes.arm import ARM
from cell.doctor.causes.cameras import CALIBRATION, CAMERAS
from cell.doctor.causes.computer import COMPUTER
from cell.doctor.causes.display import DISPLAY, LIGHTS
from cell.doctor.causes.gripper import GRIPPER
from cell.doctor.causes.lines import LINES
from cell.doctor.causes.profile import PROFILE
from cell.doctor.causes.store import STORE
from cell.doctor.findings import Cause

CAUSES: tuple[Cause, ...] = (
    *PROFILE,
    *COMPUTER,
    *LINES,
    *ARM,
    *GRIPPER,
    *DISPLAY,
    *LIGHTS,
    *CAMERAS,
    *CALIBRATION,
    *STORE,
)
"""Every cause, in the order of the page."""

_BY_ID = {cause.id: cause for cause in CAUSES}


def cause_of(cause_id: str) -> Cause:
    """Return a cause by its id."""
    return _BY_ID[cause_id]
