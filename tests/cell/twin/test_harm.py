"""What the twin counts as harm to blocks, and what not."""

from __future__ import annotations

import pytest

from tests.cell.twin.test_world import GRIP_Z, HIGH_Z, Bench, StraightPath, block


def go(bench: Bench, x: float, y: float, z: float, seconds: float) -> None:
    now = bench.clock.now_s()
    end = (x, y, z, 180.0, 0.0, 0.0)
    bench.world.follow(StraightPath(bench.world.joints_deg(now), end, now, now + seconds))
    bench.clock.sleep(seconds)
    bench.world.scene()


def kinds(bench: Bench) -> list[str]:
    return [harm.kind for harm in bench.world.harms]


def test_fingers_that_come_down_beside_a_block_and_take_it_harm_nothing() -> None:
    bench = Bench(block("a", 0.0, 0.0), block("b", 40.0, 0.0))
    bench.move(0.0, 0.0, GRIP_Z)
    bench.fingers(0.0)
    bench.move(0.0, 0.0, HIGH_Z)
    bench.move(200.0, 0.0, GRIP_Z)
    bench.fingers(60.0)
    assert bench.world.harms == ()


def test_a_finger_that_comes_down_on_a_block_harms_it() -> None:
    bench = Bench(block("a", 0.0, 30.0))
    bench.move(0.0, 0.0, GRIP_Z)
    (harm,) = bench.world.harms
    assert (harm.kind, harm.block) == ("landed", "a")
    assert harm.figure > 0.5


def test_a_held_block_that_comes_down_on_another_harms_it() -> None:
    bench = Bench(block("a", 0.0, 0.0), block("b", 200.0, 10.0, kind="bridge", yaw_deg=90.0))
    bench.move(0.0, 0.0, GRIP_Z)
    bench.fingers(0.0)
    bench.move(0.0, 0.0, HIGH_Z)
    bench.move(200.0, 0.0, HIGH_Z)
    bench.move(200.0, 0.0, GRIP_Z)
    assert "landed" in kinds(bench)


@pytest.mark.parametrize(("seconds", "harmed"), [(5.0, False), (0.5, True)])
def test_a_slow_push_harms_nothing_and_a_fast_one_does(seconds: float, harmed: bool) -> None:
    bench = Bench(block("a", 60.0, 0.0), block("b", 93.5, 0.0))
    bench.fingers(0.0)
    go(bench, 0.0, 0.0, GRIP_Z, 1.0)
    go(bench, 100.0, 0.0, GRIP_Z, seconds)
    assert bench.where("a").x_mm == pytest.approx(100.0 + 10.0 + 16.5, abs=0.1)
    assert bench.where("b").x_mm >= bench.where("a").x_mm + 32.99
    assert ("rammed" in kinds(bench)) is harmed
    assert set(kinds(bench)) <= {"rammed"}


def test_two_blocks_between_closing_fingers_are_pinched() -> None:
    bench = Bench(block("a", 0.0, 0.0, kind="cube"))
    bench.world.blocks.put(block("b", 0.0, 0.0))
    bench.move(0.0, 0.0, GRIP_Z)
    bench.fingers(0.0)
    assert kinds(bench) == ["pinched", "pinched"]
