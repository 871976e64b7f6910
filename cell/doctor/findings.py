"""What the doctor says: causes, findings, what is fine, what was not checked and why."""

from __future__ import annotations

from dataclasses import dataclass

PAGE = "docs/reference/causes.md"


@dataclass(frozen=True, slots=True, kw_only=True)
class Cause:
    """One thing that can be wrong with a cell, as the page of causes explains it.

    Attributes:
        id: Its name, and its anchor on the page, such as `arm-key-at-teach`.
        title: What is wrong, in a few words.
        group: Part of the cell under which the page lists it.
        rank: Place in the order of root causes; what explains others has the lower number.
        see: What people notice.
        why: How it comes about.
        fix: What to do, in a sentence.
        found: How the doctor tells it from others.
        undo: How to take the fix back; empty where nothing needs to be.
    """

    id: str
    title: str
    group: str
    rank: int
    see: str
    why: str
    fix: str
    found: str
    undo: str = ""

    @property
    def link(self) -> str:
        """Where the page explains it."""
        return f"{PAGE}#{self.id}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A cause that the doctor believes to be at work, with what was measured.

    Attributes:
        cause: The cause.
        component: Device or part of the cell, such as `arm` or `camera top`.
        facts: What was measured, short and without judgement.
        problem: What is wrong, in a sentence.
        fix: What to do about it here.
        undo: How to take the fix back, empty where nothing needs to be.
    """

    cause: Cause
    component: str
    facts: tuple[str, ...]
    problem: str
    fix: str
    undo: str = ""


@dataclass(frozen=True, slots=True)
class Fine:
    """Something that was checked and is as it should be."""

    component: str
    what: str


@dataclass(frozen=True, slots=True)
class Unchecked:
    """Something that was not checked, and why."""

    component: str
    what: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Everything one examination came to.

    Attributes:
        findings: What is wrong, the most likely root cause first.
        fine: What was checked and is as it should be.
        unchecked: What was not checked, and why.
    """

    findings: tuple[Finding, ...]
    fine: tuple[Fine, ...]
    unchecked: tuple[Unchecked, ...]

    @property
    def is_healthy(self) -> bool:
        """Whether nothing is wrong as far as it was checked."""
        return not self.findings
