"""What the doctor says of ledger and history: only a damaged file is moved away."""

from __future__ import annotations

from pathlib import Path

from cell.doctor import Finding
from tests.cell.doctor.seeds import SEEDS


def first_of(name: str, folder: Path) -> Finding:
    seed = next(seed for seed in SEEDS if seed.name == name)
    return seed.arrange(folder).examine("computer").findings[0]


def test_a_full_disk_is_named_before_the_ledger_that_it_hides(tmp_path: Path) -> None:
    seed = next(s for s in SEEDS if s.name == "a full disk keeps the ledger from being read")
    findings = seed.arrange(tmp_path).examine("computer").findings
    assert [one.cause.id for one in findings] == ["disk-nearly-full", "ledger-out-of-reach"]
    assert all("move ledger" not in one.fix for one in findings)


def test_a_ledger_that_another_program_writes_is_kept(tmp_path: Path) -> None:
    finding = first_of("another program writes the ledger", tmp_path)
    assert "stop the other program" in finding.fix
    assert "intact" in finding.fix


def test_a_damaged_history_says_that_reports_wait_in_it(tmp_path: Path) -> None:
    finding = first_of("the watchdog's history is damaged", tmp_path)
    assert "reports that wait" in finding.problem
    assert "copy" in finding.fix
