"""One step of a bring-up: what a person does, and how it is seen that it was done."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Verdict = Literal["done", "not done", "cannot tell"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Looked:
    """What an automatic check saw.

    Attributes:
        verdict: Whether the step is done.
        evidence: What was measured.
        problem: What is missing, in a sentence; empty when the step is done.
        fix: What to do about it; empty when the step is done.
        link: Page that explains the cause, empty without one.
    """

    verdict: Verdict
    evidence: tuple[str, ...] = ()
    problem: str = ""
    fix: str = ""
    link: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One step.

    Attributes:
        id: Its name in progress files and reports.
        title: What is to be reached.
        instruction: What the person does.
        look: Looks whether it is done; moves nothing unless the instruction says so.
        guide: Number in the cell's own bring-up guide, 0 for a check of ours.
    """

    id: str
    title: str
    instruction: str
    look: Callable[[], Looked]
    guide: int = 0
