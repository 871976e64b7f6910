"""The twin's world: blocks, arm, fingers, screen and lights, and the truth about them.

The emulators act on it through the bodies of `cell.twin.bodies`; cameras look at
it through `scene`. Time is told by the clock; what moves is settled whenever
somebody looks or acts, never by a thread of its own.

A block that the fingers hold is carried with the tool. A low finger, or a low
block in the fingers, pushes what it runs into. A released block falls and lies
where it fell, scattered as the profile says.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cell.clock import Clock
from cell.geometry import JointPositions, Pose
from cell.profile import Profile
from cell.twin.blocks import BlockField, Shove, TwinBlock
from cell.twin.bodies import FingerMotion, JointPath, JointTuple
from cell.twin.hand import Hand, Held, Meeting
from cell.twin.harm import LANDING_MM, PUSH_LIMIT_MM_S, Harm
from cell.twin.scene import Scene, SceneBlock

_SWEEP_STEP_S = 0.02
_HIGH_MM = 30.0
_SMALL_TURN_DEG = 15.0


class ToolKinematics(Protocol):
    """What the world needs to know of the arm."""

    def forward(self, joints: JointPositions) -> Pose:
        """Return the pose of the tool point."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Closing:
    """A finger motion under way, with what it will do at its end."""

    start_s: float
    start_mm: float
    motion: FingerMotion
    takes: TwinBlock | None


class World:
    """Everything physical in the twin; implements the arm, finger and display bodies."""

    def __init__(
        self,
        profile: Profile,
        kinematics: ToolKinematics,
        clock: Clock,
        blocks: Iterable[TwinBlock],
        *,
        seed: int = 0,
    ) -> None:
        self._profile = profile
        self._kinematics = kinematics
        self._clock = clock
        self.blocks = BlockField(blocks, profile.blocks, profile.heights.surface_mm)
        self._hand = Hand(profile)
        self._generator = random.Random(seed)
        self._joints: JointTuple = profile.arm.rest_deg
        self._tool_joints: JointTuple = self._joints
        self._tool_pose = kinematics.forward(JointPositions(self._joints))
        self._path: JointPath | None = None
        self._swept_s = 0.0
        self._opening_mm = profile.gripper.open_mm
        self._closing: _Closing | None = None
        self.held: Held | None = None
        self._harms: list[Harm] = []
        self._are_fingers_jammed = False
        self._is_lamp_dead = False
        self.outputs: dict[int, bool] = {}
        self._asked_reference: Callable[[], bool] = _unreferenced
        self._is_lit = False
        self._input = 0
        self._picture = "black"
        self._pixels: NDArray[np.uint8] | None = None
        self._scene: Scene | None = None
        self._on_change: Callable[[], None] | None = None

    def reseed(self, seed: int) -> None:
        """Start the sequence of scatter anew, so that a session can be repeated."""
        self._generator = random.Random(seed)

    def on_change(self, callback: Callable[[], None]) -> None:
        """Call back whenever a block was moved or taken, so that it can be kept."""
        self._on_change = callback

    # What cameras see

    def scene(self) -> Scene:
        """Return what there is to see now; the same object while nothing changes."""
        now_s = self._clock.now_s()
        self._settle(now_s)
        joints = self.joints_deg(now_s)
        opening_mm = self.opening_mm(now_s)
        picture = self.picture
        is_lit = self.outputs.get(self._profile.outputs.lights, False) and not self._is_lamp_dead
        last = self._scene
        blocks = self._scene_blocks(now_s)
        if (
            last is not None
            and last.joints_deg == joints
            and last.opening_mm == opening_mm
            and last.picture == picture
            and last.are_lights_on == is_lit
            and last.blocks == blocks
        ):
            return last
        self._scene = Scene(
            revision=0 if last is None else last.revision + 1,
            blocks=blocks,
            joints_deg=joints,
            opening_mm=opening_mm,
            picture=picture,
            are_lights_on=is_lit,
            pixels=None if picture is None else self._pixels,
        )
        return self._scene

    @property
    def picture(self) -> str | None:
        """The picture on the panel, None while it is dark or shows another input."""
        is_shown = self._is_lit and self._input == self._profile.display.input
        return self._picture if is_shown else None

    def set_picture(self, name: str, pixels: NDArray[np.uint8] | None = None) -> None:
        """Set the picture that the computer sends to the television.

        Args:
            name: Name of the picture; of one of its own pixels, another one for each content.
            pixels: The picture, None for one that `cell.pictures` has by name.
        """
        self._picture, self._pixels = name, pixels

    @property
    def sent_picture(self) -> str:
        """The picture that the computer sends, seen or not."""
        return self._picture

    @property
    def sent_pixels(self) -> NDArray[np.uint8] | None:
        """Its pixels; None for one that `cell.pictures` has by name."""
        return self._pixels

    def _scene_blocks(self, now_s: float) -> tuple[SceneBlock, ...]:
        return tuple(
            SceneBlock(
                block=b.block, kind=b.kind, colour=b.colour,
                x_mm=b.x_mm, y_mm=b.y_mm, z_mm=b.z_mm, yaw_deg=b.yaw_deg,
            )
            for b in self._placed(now_s)
        )  # fmt: skip

    def _placed(self, now_s: float) -> tuple[TwinBlock, ...]:
        """Return every block where it is, a held one where it hangs."""
        held = self.held
        if held is None:
            return self.blocks.all()
        tool = self._tool(self.joints_deg(now_s))
        return tuple(
            self._hand.carried(b, held, tool) if b.block == held.block else b
            for b in self.blocks.all()
        )

    # The arm's mechanics

    def joints_deg(self, now_s: float) -> JointTuple:
        """Return where the joints are."""
        if self._path is not None:
            return self._path.at(now_s)
        return self._joints

    def follow(self, path: JointPath) -> None:
        """Start a motion now; it replaces one under way."""
        self._settle(path.start_s)
        self._joints = self.joints_deg(path.start_s)
        self._path = path
        self._swept_s = path.start_s

    def halt(self, now_s: float) -> None:
        """Stand still: the arm where its joints are, the motion forgotten."""
        self._settle(now_s)
        self._joints = self.joints_deg(now_s)
        self._path = None

    def is_moving(self, now_s: float) -> bool:
        """Return whether an arm motion is under way."""
        return self._path is not None and now_s < self._path.end_s

    def set_output(self, bit: int, *, is_on: bool, now_s: float) -> None:
        """Switch whatever hangs on an output of the arm controller."""
        self._settle(now_s)
        if self.outputs.get(bit, False) != is_on:
            self.outputs[bit] = is_on
            self._changed()

    # The gripper's mechanics

    def is_powered(self) -> bool:
        """Return whether the gripper has power."""
        return self.outputs.get(self._profile.outputs.gripper_power, False)

    def ask_reference(self, asked: Callable[[], bool]) -> None:
        """Ask the gripper from now on whether it knows its zero."""
        self._asked_reference = asked

    @property
    def is_gripper_referenced(self) -> bool:
        """Whether the gripper knows its zero; without power it forgets it."""
        return self.is_powered() and self._asked_reference()

    def opening_mm(self, now_s: float) -> float:
        """Return the opening between the fingers."""
        closing = self._closing
        if closing is None:
            return self._opening_mm
        if now_s >= closing.motion.end_s:
            return closing.motion.end_mm
        whole_s = closing.motion.end_s - closing.start_s
        share = (now_s - closing.start_s) / whole_s if whole_s > 0 else 1.0
        return closing.start_mm + share * (closing.motion.end_mm - closing.start_mm)

    def begin(
        self, target_mm: float, speed_mm_s: float, acceleration_mm_s2: float, now_s: float
    ) -> FingerMotion:
        """Start the fingers towards an opening; a block between them stops them."""
        self._settle(now_s)
        start_mm = self.opening_mm(now_s)
        target_mm = min(max(target_mm, 0.0), self._profile.gripper.stroke_mm)
        meeting = Meeting(end_mm=target_mm, takes=None, is_blocked=False)
        if self._are_fingers_jammed:
            meeting = Meeting(end_mm=start_mm, takes=None, is_blocked=target_mm != start_mm)
        elif target_mm > start_mm:
            self._let_go()
        elif self.held is not None:
            meeting = Meeting(end_mm=start_mm, takes=None, is_blocked=target_mm < start_mm)
        else:
            tool = self._tool(self.joints_deg(now_s))
            meeting = self._hand.meet(self.blocks, tool, start_mm, target_mm)
            self._harms += [
                Harm(kind="pinched", block=name, time_s=now_s, figure=meeting.end_mm)
                for name in meeting.pinched
            ]
        end_mm = meeting.end_mm
        duration_s = _travel_s(abs(end_mm - start_mm), speed_mm_s, acceleration_mm_s2)
        motion = FingerMotion(
            end_s=now_s + duration_s, end_mm=end_mm, is_blocked=meeting.is_blocked
        )
        self._closing = _Closing(
            start_s=now_s, start_mm=start_mm, motion=motion, takes=meeting.takes
        )
        return motion

    def halt_fingers(self, now_s: float) -> None:
        """Stop the fingers at their present opening."""
        self._settle(now_s)
        self._opening_mm = self.opening_mm(now_s)
        self._closing = None

    def burn_out_lamps(self) -> None:
        """Let the lamps stay dark from now on, whatever their output is."""
        self._is_lamp_dead = True

    def jam_fingers(self, *, are_jammed: bool) -> None:
        """Have something block the fingers both ways, or take it away."""
        self._are_fingers_jammed = are_jammed

    def slip(self, now_s: float) -> bool:
        """Let the held block slip from the fingers, which close; return whether one was held."""
        self._settle(now_s)
        if self.held is None:
            return False
        self._let_go()
        self._opening_mm, self._closing = 0.0, None
        return True

    # The television's panel

    def set_lit(self, *, is_lit: bool, input_number: int, now_s: float) -> None:
        """Say whether the panel is lit and which input it shows."""
        self._is_lit = is_lit
        self._input = input_number

    # Truth, for keeping and for tests

    def whereabouts(self) -> tuple[TwinBlock, ...]:
        """Return the truth about every block now; a held one where it hangs."""
        now_s = self._clock.now_s()
        self._settle(now_s)
        return self._placed(now_s)

    @property
    def harms(self) -> tuple[Harm, ...]:
        """What would have harmed blocks since the world was made; see `cell.twin.harm`."""
        return tuple(self._harms)

    def restore(
        self,
        *,
        blocks: Iterable[TwinBlock],
        joints_deg: JointTuple,
        opening_mm: float,
        held: Held | None,
        outputs: dict[int, bool],
        is_gripper_referenced: bool,
    ) -> None:
        """Put the world into a state that was kept."""
        surface_mm = self._profile.heights.surface_mm
        revision = self.blocks.revision + 1
        self.blocks = BlockField(blocks, self._profile.blocks, surface_mm)
        self.blocks.revision = revision
        self._joints, self._path = joints_deg, None
        self._opening_mm, self._closing = opening_mm, None
        self.held = held
        self.outputs = dict(outputs)
        self._asked_reference = lambda: is_gripper_referenced

    # Physics

    def _changed(self) -> None:
        if self._on_change is not None:
            self._on_change()

    def _tool(self, joints: JointTuple) -> Pose:
        """Return the tool point's pose; the last one asked for is remembered."""
        if joints != self._tool_joints:
            self._tool_joints = joints
            self._tool_pose = self._kinematics.forward(JointPositions(joints))
        return self._tool_pose

    def _settle(self, now_s: float) -> None:
        """Bring fingers and arm up to `now_s`."""
        closing = self._closing
        if closing is not None and now_s >= closing.motion.end_s:
            self._closing = None
            self._opening_mm = closing.motion.end_mm
            self._finish_closing(closing, now_s)
        path = self._path
        if path is not None:
            self._sweep(path, min(now_s, path.end_s))
            if now_s >= path.end_s:
                self._joints, self._path = path.at(path.end_s), None
                if self.held is not None:
                    self._changed()

    def _finish_closing(self, closing: _Closing, now_s: float) -> None:
        tool = self._tool(self.joints_deg(now_s))
        if closing.takes is not None:
            self.held = self._hand.take(self.blocks, closing.takes, tool)
        elif (
            closing.motion.end_mm > closing.start_mm
            and self._hand.tip_mm(tool) < self.blocks.highest_mm()
        ):
            self._hand.push_aside(self.blocks, tool, closing.motion.end_mm, self.held)
        self._changed()

    def _let_go(self) -> None:
        """Drop what the fingers hold: it falls and lies where it fell."""
        held = self.held
        if held is None:
            return
        now_s = self._clock.now_s()
        tool = self._tool(self.joints_deg(now_s))
        self.blocks.put(self._hand.carried(self.blocks.get(held.block), held, tool))
        self.held = None
        twin = self._profile.twin
        self.blocks.drop(
            held.block, self._generator, twin.placement_scatter_mm, twin.placement_scatter_deg
        )
        self._changed()

    def _sweep(self, path: JointPath, until_s: float) -> None:
        """Push aside what the fingers, or a block in them, ran into since last time."""
        since_s, self._swept_s = self._swept_s, until_s
        if until_s <= since_s:
            return
        clear_mm = self.blocks.highest_mm() + self._hand.reach_below_mm(self.held)
        if self._stays_above(path, since_s, until_s, clear_mm):
            return
        before = self.blocks.revision
        steps = max(1, math.ceil((until_s - since_s) / _SWEEP_STEP_S))
        step_s = (until_s - since_s) / steps
        last = self._tool(path.at(since_s))
        for step in range(1, steps + 1):
            tool = self._tool(path.at(since_s + step_s * step))
            if tool.z_mm < clear_mm:
                shoved = self._hand.push_aside(self.blocks, tool, self._opening_mm, self.held)
                self._judge(shoved, last, tool, since_s + step_s * step, step_s)
            last = tool
        if self.blocks.revision != before:
            self._changed()

    def _judge(
        self, shoved: Iterable[Shove], last: Pose, tool: Pose, time_s: float, step_s: float
    ) -> None:
        """Note what harms the blocks that a moving hand has pushed."""
        speed_mm_s = math.hypot(tool.x_mm - last.x_mm, tool.y_mm - last.y_mm) / step_s
        for one in shoved:
            came_from_above = one.low_mm + last.z_mm - tool.z_mm >= one.top_mm - 1.0
            if came_from_above and one.overlap_mm > LANDING_MM:
                self._harms.append(
                    Harm(kind="landed", block=one.block, time_s=time_s, figure=one.overlap_mm)
                )
            elif speed_mm_s > PUSH_LIMIT_MM_S:
                self._harms.append(
                    Harm(kind="rammed", block=one.block, time_s=time_s, figure=speed_mm_s)
                )
            if one.is_jammed:
                self._harms.append(
                    Harm(kind="jammed", block=one.block, time_s=time_s, figure=one.overlap_mm)
                )

    def _stays_above(
        self, path: JointPath, since_s: float, until_s: float, clear_mm: float
    ) -> bool:
        """Return whether a path surely stays above a height: its ends and its middle.

        The middle counts with a little less room, and not at all between high ends
        with little turning: there a path cannot sag that far.
        """
        first, last = path.at(since_s), path.at(until_s)
        start_z_mm = self._tool(first).z_mm
        lowest_mm = min(start_z_mm, self._tool(last).z_mm)
        if lowest_mm < clear_mm:
            return False
        if lowest_mm >= clear_mm + _HIGH_MM and _most_turn_deg(first, last) < _SMALL_TURN_DEG:
            return True
        middle = path.at(0.5 * (since_s + until_s))
        return self._tool(middle).z_mm >= clear_mm + 5.0


def _most_turn_deg(first: JointTuple, last: JointTuple) -> float:
    """Return how far the joint turns that turns most."""
    return max(abs(a - b) for a, b in zip(first, last, strict=True))


def _unreferenced() -> bool:
    """Answer for a gripper that was never referenced."""
    return False


def _travel_s(distance_mm: float, speed_mm_s: float, acceleration_mm_s2: float) -> float:
    """Return how long a trapezoidal motion from rest to rest takes."""
    if distance_mm <= 0:
        return 0.0
    ramp_mm = speed_mm_s**2 / acceleration_mm_s2
    if distance_mm < ramp_mm:
        return 2.0 * math.sqrt(distance_mm / acceleration_mm_s2)
    return distance_mm / speed_mm_s + speed_mm_s / acceleration_mm_s2
