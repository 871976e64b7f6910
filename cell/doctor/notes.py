"""What the checks write down while they work, and the order in which it is told."""

from __future__ import annotations

from cell.doctor.causes import cause_of
from cell.doctor.findings import Finding, Fine, Report, Unchecked


class Notes:
    """Collects findings, what is fine, and what could not be checked."""

    def __init__(self) -> None:
        self._findings: list[Finding] = []
        self._fine: list[Fine] = []
        self._unchecked: list[Unchecked] = []
        self._repeats: dict[str, str] = {}

    def find(
        self,
        cause_id: str,
        component: str,
        problem: str,
        *facts: str,
        fix: str = "",
        undo: str = "",
    ) -> None:
        """Write down that a cause is at work.

        Args:
            cause_id: Id of the cause.
            component: Device or part of the cell.
            problem: What is wrong, in a sentence.
            facts: What was measured.
            fix: What to do here; the cause's own advice unless given.
            undo: How to take it back; the cause's own unless given.
        """
        cause = cause_of(cause_id)
        self._findings.append(
            Finding(
                cause=cause,
                component=component,
                facts=facts,
                problem=problem,
                fix=fix or cause.fix,
                undo=undo or cause.undo,
            )
        )

    def fine(self, component: str, what: str) -> None:
        """Write down what was checked and is as it should be."""
        self._fine.append(Fine(component, what))

    def skip(self, component: str, what: str, why: str) -> None:
        """Write down what was not checked, and why."""
        self._unchecked.append(Unchecked(component, what, why))

    def repeated(self, device: str, problem: str) -> None:
        """Write down that a request had to be sent again, and why."""
        self._repeats.setdefault(device, problem)

    def judge_repeats(self) -> None:
        """Say of each line with repeated requests that it is unreliable.

        Where the device itself is in trouble, that is why it had to be asked again.
        """
        for device, problem in self._repeats.items():
            if not self.is_troubled(device):
                words = f"requests to the {device} had to be sent again"
                self.find("line-unreliable", device, words, problem)

    def has(self, *cause_ids: str, component: str | None = None) -> bool:
        """Return whether one of these causes was found (at this component, if one is given)."""
        return any(
            finding.cause.id in cause_ids and component in (None, finding.component)
            for finding in self._findings
        )

    def is_troubled(self, component: str) -> bool:
        """Return whether anything was found at a component."""
        return any(finding.component == component for finding in self._findings)

    def report(self) -> Report:
        """Return everything, root causes first; equals in the order in which they were found."""
        ordered = sorted(self._findings, key=lambda finding: finding.cause.rank)
        return Report(
            findings=tuple(ordered), fine=tuple(self._fine), unchecked=tuple(self._unchecked)
        )
