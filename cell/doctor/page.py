"""The page of causes, made of the causes themselves, so that every link holds."""

from __future__ import annotations

from itertools import groupby

from cell.doctor.causes import CAUSES
from cell.doctor.findings import Cause

_HEAD = """\
# Causes

What `cell doctor` can find, one section a cause. It is written from the program's
own table (`cell/doctor/causes/`); a test keeps both the same.

The doctor moves nothing. What it opens it closes. The operation right it takes only
where it is free, and gives it back. While it looks at the gripper it switches the
gripper's power on, and while it looks through the cameras it switches the lights on;
both go back to how they were. A session of the arm controller it ends only if it began
it. Opening a serial port raises its control lines for a moment. `cell doctor --learn` is
another matter: it brings the whole cell up and lets the arm stand aside, in order to keep
what healthy pictures look like.

Findings are ordered by root cause: what explains others comes first (an emergency stop
before servos that are off, a cable that is out before everything of that device).
"""


def page_of_causes() -> str:
    """Return the page as Markdown; each cause's heading is its id, so that links reach it."""
    parts = [_HEAD]
    for group, causes in groupby(CAUSES, key=lambda cause: cause.group):
        parts.append(f"\n## {group}\n")
        parts.extend(_section(cause) for cause in causes)
    return "".join(parts)


def _section(cause: Cause) -> str:
    undo = f"\n- To undo: {cause.undo}." if cause.undo else ""
    return (
        f"\n### {cause.id}\n\n**{cause.title}.**\n\n"
        f"- What you see: {cause.see}\n- Why: {cause.why}\n- What to do: {cause.fix}."
        f"{undo}\n- How it is found: {cause.found}\n"
    )
