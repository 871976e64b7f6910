"""What is said of learned looks, each finding fired by samples that deserve it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from calibration.errors import FitFailed
from calibration.player import play
from calibration.recognition.fitting import fit_colours, fit_kinds, try_held_out
from calibration.recognition.judge import colour_findings, kind_findings, sample_findings
from calibration.recognition.procedure import learn_recognition
from calibration.recognition.samples import BlockSample
from calibration.requests import Answer, Ask, Point, Request, Value
from cell.stop import StopToken
from cell.vision.learned import recognition_model
from tests.calibration.camera_settings.bench import PLAN, Answers, Bench

RED, GREEN, BLUE = (180.0, 50.0, 40.0), (80.0, 140.0, 60.0), (40.0, 60.0, 120.0)


def seen(
    slot: int, colour: str, rgb: tuple[float, float, float], *, kind: str = "cube",
    area_px: int = 3000, circularity: float = 0.78, seed: int = 0, spread: float = 0.01,
) -> list[BlockSample]:  # fmt: skip
    """Return four looks at a block."""
    random = np.random.default_rng([slot, seed])
    looks = []
    for number in range(4):
        r, g, b = (float(c) for c in np.array(rgb) * np.exp(random.normal(0.0, spread, 3)))
        looks.append(
            BlockSample(
                slot=slot, kind=kind, colour=colour, label=f"look {number}", u_px=100.0, v_px=100.0,
                mean_rgb=(r, g, b), area_px=area_px + int(random.integers(-20, 20)),
                circularity=circularity + float(random.normal(0.0, 0.003)),
            )
        )  # fmt: skip
    return looks


def told(samples: list[BlockSample]) -> dict[str, str]:
    """Return codes and grades of what is said of colours."""
    found = colour_findings(fit_colours(samples, "a test"), try_held_out(samples))
    return {finding.code: finding.grade.value for finding in found}


def three_colours() -> list[BlockSample]:
    return [
        *seen(1, "red", RED), *seen(2, "red", RED), *seen(3, "green", GREEN),
        *seen(4, "green", GREEN), *seen(5, "blue", BLUE), *seen(6, "blue", BLUE),
    ]  # fmt: skip


def test_sound_samples_are_not_accused() -> None:
    assert told(three_colours()) == {}
    assert list(sample_findings(three_colours(), ())) == []


def test_blocks_that_are_clipped_are_named() -> None:
    samples = [*three_colours(), *seen(9, "red", (255.0, 253.0, 60.0), spread=0.0)]
    (finding,) = sample_findings(samples, ())
    assert (finding.code, finding.grade.value) == ("clipped-blocks", "BAD")
    assert "slots 9" in finding.text


@pytest.mark.parametrize(("share", "grade"), [(1.05, "BAD"), (1.24, "DEGRADED"), (3.0, None)])
def test_colours_that_lie_too_near_are_named(share: float, grade: str | None) -> None:
    other = (RED[0], RED[1] * share, RED[2] * share)
    samples = [*seen(1, "red", RED), *seen(2, "red", RED), *seen(3, "orange", other),
               *seen(4, "orange", other)]  # fmt: skip
    assert told(samples).get("colours-too-near") == grade


def test_a_block_that_gets_another_colour_when_held_out_is_named() -> None:
    samples = [*three_colours(), *seen(7, "red", GREEN)]
    assert told(samples)["wrong-when-held-out"] == "BAD"


def test_blocks_that_get_no_colour_when_held_out_are_named() -> None:
    # Two reds that have nothing in common: neither is told from the other.
    samples = [
        *seen(1, "red", RED), *seen(2, "red", (220.0, 15.0, 90.0)), *seen(3, "green", GREEN),
        *seen(4, "green", GREEN),
    ]  # fmt: skip
    found = told(samples)
    assert found["unsure-when-held-out"] == "DEGRADED"
    assert "wrong-when-held-out" not in found


def test_kinds_that_neither_area_nor_roundness_tells_apart_are_named() -> None:
    cubes = seen(1, "red", RED)
    cylinders = seen(2, "red", RED, kind="cylinder", area_px=2300, circularity=0.97)
    assert list(kind_findings(fit_kinds([*cubes, *cylinders]))) == []
    alike = seen(3, "red", RED, kind="cylinder")
    (finding,) = kind_findings(fit_kinds([*cubes, *alike]))
    assert (finding.code, finding.grade.value) == ("kinds-overlap", "BAD")
    assert "cube and cylinder" in finding.text


def test_one_sample_of_each_colour_tells_nothing() -> None:
    with pytest.raises(FitFailed, match="one sample of each colour"):
        fit_colours([seen(1, "red", RED)[0], seen(3, "green", GREEN)[0]], "a test")


SLOTS = (1, 4, 7, 10, 13, 2, 5, 8, 11, 14)


@dataclass
class Person(Answers):
    """Lays blocks where they are asked for, elsewhere each round, and points at each."""

    bench: Bench | None = None
    rounds: int = 0

    def answer(self, ask: Ask) -> Answer:
        if not ask.key.startswith("laid_"):
            return super().answer(ask)
        assert self.bench is not None
        blocks = {block.block: block for block in self.bench.cell.world.whereabouts()}
        for index, number in enumerate(SLOTS):
            column, row = (index + 3 * self.rounds) % 5, (index + 3 * self.rounds) // 5 % 2
            self.bench.cell.world.blocks.put(
                replace(
                    blocks[f"slot {number}"], x_mm=380.0 + 220.0 * row,
                    y_mm=-260.0 + 120.0 * column, yaw_deg=17.0 * index,
                    z_mm=self.bench.profile.heights.surface_mm,
                )
            )  # fmt: skip
        self.rounds += 1
        return True

    def point(self, point: Point) -> Answer:
        assert self.bench is not None
        number = point.key.split("_")[1]
        block = next(b for b in self.bench.cell.world.whereabouts() if b.block == f"slot {number}")
        view = self.bench.profile.cameras["top"].view(71.5)
        assert view is not None
        u, v = view.to_picture(np.array([[block.x_mm, block.y_mm]]), 71.5)[0]
        return float(u) + 4.0, float(v) - 3.0


def test_blocks_that_a_person_lays_and_points_at_are_learned_as_by_the_arm() -> None:
    bench = Bench()
    bench.cell.open()
    given: dict[str, Value] = {
        "slots": tuple(float(n) for n in SLOTS),
        "rounds": 2.0,
        "way": "by-hand",
    }
    person = Person(given, bench=bench)
    asked: list[Request] = []

    def note(request: Request, answer: Answer) -> None:
        asked.append(request)

    found = play(learn_recognition(bench.site()), hands=bench, asker=person, stop=StopToken(),
                 on_answer=note)  # fmt: skip
    assert found.grade.value != "BAD", found.findings
    assert not any(type(request).__name__ == "PutBlock" for request in asked)
    assert sum(isinstance(request, Point) for request in asked) == 2 * len(SLOTS)
    assert {sample.label.split(",")[0].split()[1] for sample in found.samples} == {
        str(number) for number in SLOTS
    }
    colours = found.details["colours"]
    assert isinstance(colours, dict)
    assert set(colours) == {PLAN.slot(number).colour for number in SLOTS}
    assert "recognition" in found.values
    assert recognition_model(bench.profile, "top") is not None
