"""The twin's physics, with an arm that moves along straight axes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest

from cell.clock import SimulatedClock
from cell.geometry import JointPositions, Pose
from cell.profile import Profile, load_profile
from cell.twin.blocks import TwinBlock
from cell.twin.bodies import JointTuple
from cell.twin.keeping import dump_world, load_world
from cell.twin.world import World

GRIP_Z = 55.0
HIGH_Z = 200.0


class StraightArm:
    """Joints are x, y, z and the turn about the vertical, the tool pointing down."""

    def forward(self, joints: JointPositions) -> Pose:
        x, y, z, c, _, _ = joints.values
        return Pose(x, y, z, 180.0, 0.0, c)


@dataclass(frozen=True)
class StraightPath:
    start: JointTuple
    end: JointTuple
    start_s: float
    end_s: float

    def at(self, time_s: float) -> JointTuple:
        share = min(max((time_s - self.start_s) / (self.end_s - self.start_s), 0.0), 1.0)
        a, b, c, d, e, f = (p + share * (q - p) for p, q in zip(self.start, self.end, strict=True))
        return a, b, c, d, e, f


def block(name: str, x: float, y: float, kind: str = "cube", yaw_deg: float = 0.0) -> TwinBlock:
    return TwinBlock(
        block=name, kind=kind, colour="red", x_mm=x, y_mm=y, z_mm=38.5, yaw_deg=yaw_deg
    )


class Bench:
    """A world with blocks, and an arm and fingers to act on it."""

    def __init__(self, *blocks: TwinBlock, scatter: bool = False) -> None:
        profile = load_profile("mash")
        if not scatter:
            twin = profile.twin.model_copy(
                update={"placement_scatter_mm": 0.0, "placement_scatter_deg": 0.0}
            )
            profile = profile.model_copy(update={"twin": twin})
        self.profile: Profile = profile
        self.clock = SimulatedClock()
        self.world = World(profile, StraightArm(), self.clock, blocks, seed=7)
        self.move(0.0, 0.0, HIGH_Z)

    def move(self, x: float, y: float, z: float, c: float = 180.0, *, part: float = 1.0) -> None:
        now = self.clock.now_s()
        path = StraightPath(self.world.joints_deg(now), (x, y, z, c, 0.0, 0.0), now, now + 1.0)
        self.world.follow(path)
        self.clock.sleep(part)
        self.world.scene()

    def fingers(self, opening_mm: float) -> bool:
        motion = self.world.begin(opening_mm, 60.0, 200.0, self.clock.now_s())
        self.clock.sleep(motion.end_s - self.clock.now_s())
        self.world.scene()
        return motion.is_blocked

    def where(self, name: str) -> TwinBlock:
        return next(b for b in self.world.whereabouts() if b.block == name)


def test_fingers_close_on_a_block_and_carry_it() -> None:
    bench = Bench(block("a", 3.0, 2.0))
    bench.move(0.0, 0.0, GRIP_Z)
    assert bench.fingers(0.0)
    assert bench.world.opening_mm(bench.clock.now_s()) == pytest.approx(33.0)
    assert bench.where("a").y_mm == pytest.approx(0.0), "closing fingers centre a block"
    assert bench.where("a").x_mm == pytest.approx(3.0), "but only along their own axis"
    bench.move(100.0, 50.0, HIGH_Z)
    carried = bench.where("a")
    assert (carried.x_mm, carried.y_mm) == pytest.approx((103.0, 50.0))
    assert carried.z_mm == pytest.approx(38.5 + HIGH_Z - GRIP_Z)


def test_fingers_close_on_nothing_above_a_block() -> None:
    bench = Bench(block("a", 0.0, 0.0))
    bench.move(0.0, 0.0, 95.0)
    assert not bench.fingers(0.0)
    assert bench.world.held is None
    assert bench.where("a").z_mm == 38.5


def test_fingers_close_on_nothing_beside_a_block() -> None:
    bench = Bench(block("a", 30.0, 0.0))
    bench.move(0.0, 0.0, GRIP_Z)
    assert not bench.fingers(0.0)
    assert bench.world.held is None


def test_a_turned_block_is_turned_flat_by_the_fingers() -> None:
    bench = Bench(block("a", 0.0, 0.0, yaw_deg=12.0))
    bench.move(0.0, 0.0, GRIP_Z)
    assert bench.fingers(0.0)
    assert bench.where("a").yaw_deg % 90.0 == pytest.approx(0.0, abs=1e-6)


def test_a_bridge_is_gripped_across_its_width_at_any_turn() -> None:
    bench = Bench(block("a", 0.0, 0.0, kind="bridge", yaw_deg=30.0))
    bench.move(0.0, 0.0, GRIP_Z, c=-150.0)
    assert bench.fingers(0.0)
    assert bench.world.opening_mm(bench.clock.now_s()) == pytest.approx(33.0)


def test_carrying_turns_the_block_with_the_tool() -> None:
    bench = Bench(block("a", 0.0, 0.0))
    bench.move(0.0, 0.0, GRIP_Z)
    bench.fingers(0.0)
    bench.move(0.0, 0.0, HIGH_Z)
    bench.move(0.0, 0.0, HIGH_Z, c=150.0)
    assert bench.where("a").yaw_deg == pytest.approx(-30.0)


def test_a_released_block_falls_to_the_surface_and_lies_there() -> None:
    bench = Bench(block("a", 0.0, 0.0))
    bench.move(0.0, 0.0, GRIP_Z)
    bench.fingers(0.0)
    bench.move(200.0, 0.0, HIGH_Z)
    bench.fingers(60.0)
    assert bench.where("a").z_mm == 38.5
    bench.move(0.0, 0.0, HIGH_Z)
    assert bench.where("a").x_mm == pytest.approx(200.0)


def test_a_high_fall_scatters_more_than_a_low_one() -> None:
    def spread(release_z: float) -> float:
        total = 0.0
        for seed in range(40):
            bench = Bench(block("a", 0.0, 0.0), scatter=True)
            bench.world.reseed(seed)
            bench.move(0.0, 0.0, GRIP_Z)
            bench.fingers(0.0)
            bench.move(0.0, 0.0, release_z)
            bench.fingers(60.0)
            total += math.hypot(bench.where("a").x_mm, bench.where("a").y_mm)
        return total / 40

    assert spread(GRIP_Z) < 1.0
    assert spread(HIGH_Z) > 4.0


def test_a_block_dropped_on_another_lies_on_top() -> None:
    bench = Bench(block("a", 0.0, 0.0), block("b", 200.0, 0.0))
    bench.move(0.0, 0.0, GRIP_Z)
    bench.fingers(0.0)
    bench.move(0.0, 0.0, HIGH_Z)
    bench.move(200.0, 0.0, HIGH_Z)
    bench.fingers(60.0)
    assert bench.where("a").z_mm == pytest.approx(38.5 + 33.0)
    assert bench.where("b").x_mm == 200.0


def test_low_fingers_push_a_block_along() -> None:
    bench = Bench(block("a", 0.0, 100.0))
    bench.move(0.0, 0.0, GRIP_Z)
    bench.move(0.0, 60.0, GRIP_Z)
    pushed = bench.where("a")
    assert pushed.y_mm == pytest.approx(60.0 + 38.0 + 16.5, abs=0.5)
    assert pushed.x_mm == pytest.approx(0.0, abs=1e-6)


def test_high_fingers_push_nothing() -> None:
    bench = Bench(block("a", 0.0, 100.0))
    bench.move(0.0, 200.0, 136.5)
    assert bench.where("a").y_mm == 100.0


def test_a_block_carried_low_pushes_others_and_they_push_on() -> None:
    bench = Bench(block("a", 0.0, 0.0), block("b", 60.0, 0.0), block("c", 94.0, 0.0))
    bench.move(0.0, 0.0, GRIP_Z)
    bench.fingers(0.0)
    bench.move(50.0, 0.0, GRIP_Z)
    assert bench.where("b").x_mm == pytest.approx(50.0 + 33.0, abs=1.0)
    assert bench.where("c").x_mm == pytest.approx(50.0 + 66.0, abs=1.0)


def test_opening_fingers_push_a_close_neighbour_away() -> None:
    bench = Bench(block("a", 0.0, 0.0), block("b", 0.0, 45.0))
    bench.move(0.0, 0.0, HIGH_Z)
    bench.fingers(34.0)
    bench.move(0.0, 0.0, GRIP_Z)
    bench.fingers(60.0)
    assert bench.where("b").y_mm == pytest.approx(38.0 + 16.5, abs=0.5)


def test_two_blocks_between_the_fingers_stop_them_but_neither_is_held() -> None:
    bench = Bench(block("a", -8.0, 0.0), block("b", 8.0, 0.0))
    bench.move(0.0, 0.0, GRIP_Z)
    assert bench.fingers(0.0)
    assert bench.world.held is None


def test_a_motion_broken_off_leaves_the_arm_where_it_was() -> None:
    bench = Bench()
    bench.move(100.0, 0.0, HIGH_Z, part=0.5)
    bench.world.halt(bench.clock.now_s())
    bench.clock.sleep(5.0)
    assert bench.world.joints_deg(bench.clock.now_s())[0] == pytest.approx(50.0)


def test_the_scene_is_the_same_object_while_nothing_changes() -> None:
    bench = Bench(block("a", 0.0, 0.0))
    first = bench.world.scene()
    bench.clock.sleep(10.0)
    assert bench.world.scene() is first
    bench.move(5.0, 0.0, HIGH_Z)
    second = bench.world.scene()
    assert second.revision > first.revision
    bench.world.set_output(bench.profile.outputs.lights, is_on=True, now_s=bench.clock.now_s())
    assert bench.world.scene().are_lights_on
    assert not second.are_lights_on


def test_the_picture_is_seen_only_on_a_lit_panel_with_the_right_input() -> None:
    bench = Bench()
    bench.world.set_picture("water")
    assert bench.world.scene().picture is None
    bench.world.set_lit(is_lit=True, input_number=2, now_s=0.0)
    assert bench.world.scene().picture is None
    bench.world.set_lit(is_lit=True, input_number=1, now_s=0.0)
    assert bench.world.scene().picture == "water"


def test_a_kept_world_comes_back_with_the_block_in_the_fingers() -> None:
    bench = Bench(block("a", 0.0, 0.0), block("b", 100.0, 0.0))
    bench.move(0.0, 0.0, GRIP_Z)
    bench.fingers(0.0)
    bench.move(0.0, 30.0, HIGH_Z)
    text = dump_world(bench.world, bench.clock.now_s())
    other = Bench(block("a", 0.0, 0.0), block("b", 100.0, 0.0))
    load_world(other.world, text, "test")
    assert other.where("a") == bench.where("a")
    assert dump_world(other.world, other.clock.now_s()) == text


def test_the_same_seed_scatters_the_same() -> None:
    def end(seed: int) -> TwinBlock:
        bench = Bench(block("a", 0.0, 0.0), scatter=True)
        bench.world.reseed(seed)
        bench.move(0.0, 0.0, GRIP_Z)
        bench.fingers(0.0)
        bench.fingers(60.0)
        return bench.where("a")

    assert end(3) == end(3)
    assert end(3) != end(4)
