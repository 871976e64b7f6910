"""The course of a bring-up: one step after the other, repeated, skipped, resumed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from cell.bringup.step import Looked, Step

Outcome = Literal["open", "done", "confirmed", "skipped", "failed"]
"""How a step stands: not looked at, measured, told by the person, left out, not done."""

SETTLED: frozenset[Outcome] = frozenset({"done", "confirmed"})


@dataclass(frozen=True, slots=True, kw_only=True)
class StepResult:
    """How one step stands.

    Attributes:
        step: Id of the step.
        outcome: How it stands.
        evidence: What was measured when it was looked at last.
        problem: What is missing.
        fix: What to do about it.
        link: Page that explains the cause.
        reason: Why it was skipped.
    """

    step: str
    outcome: Outcome = "open"
    evidence: tuple[str, ...] = ()
    problem: str = ""
    fix: str = ""
    link: str = ""
    reason: str = ""


@dataclass(frozen=True, slots=True)
class BringUpReport:
    """Everything a bring-up came to; steps in their order."""

    results: tuple[StepResult, ...]

    @property
    def is_ready(self) -> bool:
        """Whether every step is done, by measure or by the person's word."""
        return all(result.outcome in SETTLED for result in self.results)

    @property
    def missing(self) -> tuple[StepResult, ...]:
        """The steps that are not done."""
        return tuple(result for result in self.results if result.outcome not in SETTLED)


class BringUp:
    """A bring-up under way; whoever plays it shows `current` and calls what the person chose.

    Args:
        steps: The steps in their order.
        kept: Results of an earlier run. What a person told or skipped still holds; what can
            be measured is measured again.
    """

    def __init__(self, steps: Sequence[Step], kept: Mapping[str, StepResult] | None = None) -> None:
        self._steps = tuple(steps)
        kept = kept or {}
        self._results = {
            step.id: kept[step.id]
            if step.id in kept and kept[step.id].outcome in ("confirmed", "skipped")
            else StepResult(step=step.id)
            for step in self._steps
        }
        self._at = 0
        self._pass_settled()

    @property
    def current(self) -> Step | None:
        """The step that is to be looked at next; None when all were."""
        return self._steps[self._at] if self._at < len(self._steps) else None

    @property
    def position(self) -> tuple[int, int]:
        """Number of the current step, from 1, and how many there are."""
        return min(self._at + 1, len(self._steps)), len(self._steps)

    def look(self) -> StepResult:
        """Look at the current step; go on if it is done, stay if it is not.

        Calling it again repeats the check.

        Raises:
            LookupError: There is no step left.
        """
        step = self._require_current()
        looked = step.look()
        result = _result(step, looked)
        self._results[step.id] = result
        if result.outcome == "done":
            self._go_on()
        return result

    def confirm(self) -> StepResult:
        """Take the person's word that the current step is done; go on.

        Raises:
            LookupError: There is no step left.
        """
        return self._settle(self._require_current(), "confirmed", "")

    def skip(self, reason: str) -> StepResult:
        """Leave the current step out for a reason; go on.

        Raises:
            LookupError: There is no step left.
            ValueError: No reason was given.
        """
        if not reason.strip():
            raise ValueError("a step is skipped for a reason; say which")
        return self._settle(self._require_current(), "skipped", reason.strip())

    def give_up(self) -> None:
        """Leave the current step not done; go on, so that the report is whole.

        Raises:
            LookupError: There is no step left.
        """
        self._require_current()
        self._go_on()

    def report(self) -> BringUpReport:
        """Return how every step stands."""
        return BringUpReport(tuple(self._results[step.id] for step in self._steps))

    def _settle(self, step: Step, outcome: Outcome, reason: str) -> StepResult:
        before = self._results[step.id]
        result = StepResult(step=step.id, outcome=outcome, evidence=before.evidence, reason=reason)
        self._results[step.id] = result
        self._go_on()
        return result

    def _go_on(self) -> None:
        self._at += 1
        self._pass_settled()

    def _pass_settled(self) -> None:
        """Go past what an earlier run has settled."""
        while (step := self.current) is not None and self._results[step.id].outcome != "open":
            self._at += 1

    def _require_current(self) -> Step:
        step = self.current
        if step is None:
            raise LookupError("every step of the bring-up was taken")
        return step


def _result(step: Step, looked: Looked) -> StepResult:
    if looked.verdict == "done":
        return StepResult(step=step.id, outcome="done", evidence=looked.evidence)
    return StepResult(
        step=step.id,
        outcome="failed" if looked.verdict == "not done" else "open",
        evidence=looked.evidence,
        problem=looked.problem,
        fix=looked.fix,
        link=looked.link,
    )
