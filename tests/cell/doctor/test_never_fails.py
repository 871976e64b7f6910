"""Whatever comes together, an examination ends with a report: no traceback, no endless wait."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import pytest

from cell.doctor import Report
from cell.links.base import Link
from cell.twin.wire_faults import WireFault
from tests.cell.doctor.seeds import SEEDS
from tests.cell.doctor.ward import Ward

MIXTURES = 150
LONGEST_S = 120.0
"""Simulated time that the worst examination may take: every wait has a deadline."""


class _Chaos:
    """A line that answers with anything: bytes of the device, spoiled, or none at all."""

    def __init__(self, link: Link, seed: int) -> None:
        self._link = link
        self._random = random.Random(seed)

    @property
    def name(self) -> str:
        return self._link.name

    def write(self, data: bytes) -> None:
        self._link.write(data)

    def read(self, timeout_s: float) -> bytes:
        data = self._link.read(timeout_s)
        match self._random.randrange(8):
            case 0:
                return b""
            case 1:
                return self._random.randbytes(self._random.randrange(40))
            case 2 if data:
                at = self._random.randrange(len(data))
                return data[:at] + self._random.randbytes(1) + data[at + 1 :]
            case 3:
                return data[: len(data) // 2]
            case _:
                return data

    def close(self) -> None:
        self._link.close()


def require_told(report: Report, ward: Ward, seed: str) -> None:
    assert report.findings, seed
    assert all(f.problem and f.fix for f in report.findings), seed
    ranks = [finding.cause.rank for finding in report.findings]
    assert ranks == sorted(ranks), seed
    assert ward.now_s < LONGEST_S, seed


@pytest.mark.parametrize("number", range(MIXTURES))
def test_several_faults_at_once_end_in_a_report(number: int) -> None:
    rng = random.Random(number)
    ward = Ward(seed=number)
    if rng.random() < 0.5:
        ward.in_service()
    cell, now_s = ward.cell, ward.now_s
    controller, module, television = (
        cell.behind.controller,
        cell.behind.module,
        cell.behind.television,
    )
    faults: tuple[Callable[[], None], ...] = (
        lambda: controller.press_emergency_stop(now_s),
        lambda: controller.set_key_switch(now_s, is_automatic=False),
        lambda: controller.hold_right_by_panel(now_s, is_held=True),
        lambda: controller.raise_alarm(rng.randrange(10_000), now_s),
        lambda: controller.fall_silent(is_silent=True),
        lambda: controller.replace_next_reply(rng.randbytes(rng.randrange(60)) + b"\r"),
        lambda: controller.replace_next_reply(b"QoK" + rng.randbytes(30) + b"\r"),
        lambda: module.raise_error(rng.randrange(256)),
        lambda: module.raise_warning(rng.randrange(256)),
        lambda: module.corrupt_next_reply(rng.randrange(1, 9)),
        lambda: module.go_silent(),
        lambda: television.unplug(now_s),
        lambda: television.press_power(now_s),
        lambda: television.corrupt_next_reply(rng.randrange(1, 9)),
        lambda: cell.behind.wires[rng.choice(("arm", "gripper", "display"))].inject(
            rng.choice(tuple(WireFault)), delay_s=rng.uniform(0.1, 4.0)
        ),
    )
    for fault in rng.sample(faults, rng.randrange(2, 6)):
        fault()
    ward.surroundings.free = 10  # So that there surely is a finding.
    ward.surroundings.state_folder = Path("/")
    report = ward.examine()
    require_told(report, ward, f"seed {number}")


@pytest.mark.parametrize("number", range(40))
def test_lines_that_answer_anything_end_in_a_report(number: int) -> None:
    ward = Ward(seed=number)
    if number % 2:
        ward.in_service()
    for device in ("arm", "gripper", "display"):
        opener = ward.line(device)
        ward.lines[device] = lambda opener=opener: _Chaos(opener(), number)  # type: ignore[misc]
    require_told(ward.examine(), ward, f"seed {number}")


@pytest.mark.parametrize("number", range(25))
def test_two_seeded_faults_are_both_in_the_report_or_one_hides_the_other(
    number: int, tmp_path: Path
) -> None:
    rng = random.Random(number)
    seed = rng.choice([s for s in SEEDS if not s.cause.startswith(("camera", "lamp", "lights"))])
    ward = seed.arrange(tmp_path)
    ward.cell.behind.controller.press_emergency_stop(ward.now_s)
    report = ward.examine()
    require_told(report, ward, f"seed {number}: {seed.name} and an emergency stop")
