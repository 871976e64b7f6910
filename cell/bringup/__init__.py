"""Bring-up as data: the guide's steps and our own checks, played by whoever asks the person.

Nothing here knows a terminal. A `BringUp` says which step it is at, looks by itself whether
the step is done, and takes the person's word where nothing can be measured.
"""

from __future__ import annotations

from cell.bringup.connecting import Connected, connect_devices
from cell.bringup.play import BringUp, BringUpReport, StepResult
from cell.bringup.progress import ProgressFile
from cell.bringup.step import Looked, Step, Verdict
from cell.bringup.steps import bring_up_steps

__all__ = [
    "BringUp",
    "BringUpReport",
    "Connected",
    "Looked",
    "ProgressFile",
    "Step",
    "StepResult",
    "Verdict",
    "bring_up_steps",
    "connect_devices",
]
