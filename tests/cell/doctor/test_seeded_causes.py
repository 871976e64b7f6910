"""Every seeded fault: the doctor names its cause first, with evidence, and tells what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from cell.doctor import CAUSES, report_of_invalid_profile
from cell.errors import ProfileError
from tests.cell.doctor.seeds import SEEDS, Seed

LEAST_NAMED_FIRST = 38 / 40


@pytest.fixture(scope="module")
def named() -> dict[str, tuple[str, ...]]:
    return {}


@pytest.mark.parametrize("seed", SEEDS, ids=lambda seed: seed.name)
def test_an_examination_of_a_seeded_fault_ends_with_findings_that_help(
    seed: Seed, tmp_path: Path, named: dict[str, tuple[str, ...]]
) -> None:
    report = seed.arrange(tmp_path).examine(seed.only)
    named[seed.name] = tuple(finding.cause.id for finding in report.findings)
    assert report.findings, f"nothing was found although {seed.name}"
    for finding in report.findings:
        assert finding.problem
        assert finding.fix
        assert all(finding.facts)
        assert finding.facts


def test_the_seeded_cause_comes_first(
    named: dict[str, tuple[str, ...]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    for seed in SEEDS:
        # Those that another process tested are not known in this one.
        if seed.name not in named:
            folder = tmp_path_factory.mktemp("seed")
            report = seed.arrange(folder).examine(seed.only)
            named[seed.name] = tuple(finding.cause.id for finding in report.findings)
    right = [seed for seed in SEEDS if named[seed.name][:1] == (seed.cause,)]
    print(f"named first: {len(right)} of {len(SEEDS)} seeded faults")
    wrong = [f"{s.name}: {s.cause}, found {named[s.name]}" for s in SEEDS if s not in right]
    assert len(SEEDS) >= 40
    assert len(right) >= LEAST_NAMED_FIRST * len(SEEDS), "\n".join(wrong)
    assert not wrong, "\n".join(wrong)


def test_every_cause_is_seeded() -> None:
    seeded = {seed.cause for seed in SEEDS} | {"profile-invalid"}
    assert seeded == {cause.id for cause in CAUSES}


def test_a_profile_that_cannot_be_read_is_the_only_finding() -> None:
    report = report_of_invalid_profile(ProfileError("mash.toml: arm.joint_min_deg: too short"))
    assert [finding.cause.id for finding in report.findings] == ["profile-invalid"]
    assert "joint_min_deg" in report.findings[0].facts[0]
