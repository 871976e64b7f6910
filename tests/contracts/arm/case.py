"""An arm under the arm contract: its kind, the places it can go to, the hands beside it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic

from cell.devices.arm import Arm, Interpolation
from cell.geometry import JointPositions, Pose
from tests.contracts.harness import Kind, R


@dataclass(frozen=True, kw_only=True)
class Place:
    """A place that an arm can go to, and how near it gets to it."""

    pose: Pose
    joints: JointPositions
    within_mm: float = 0.0
    within: float = 0.0
    """How far a joint may be off, in deg or mm."""


@dataclass(frozen=True, kw_only=True)
class ArmCase(Generic[R]):
    """Figures and hands of one arm for the contract.

    What an arm does not have is None, and the tests that need it are not made for that arm:
    `arms_with` in test_arm_contract.py says which tests those are.

    Attributes:
        kind: How emulator and driver are made.
        identity: A part of the text that `open` returns.
        start: Joints at which a fresh arm stands.
        above: A place to work from, reached by a joint move.
        beside: Another place, reached from `above` by `interpolation`.
        interpolation: The way of moving that the arm can do between the two.
        posture: The posture of both places.
        out_of_reach: A pose that the driver or the controller refuses, or None.
        beyond_limits: Joints that are refused, or None where nothing but the guard does.
        refusal: A regular expression for the message of either refusal.
        output: An output that can be switched, or None; `output + 1` stays off.
        is_speed_sent: Whether `set_speed` talks to the controller.
        press_stop: Presses the emergency stop, or None where there is none to be seen.
        release_stop: Unlocks it.
        teach: Turns the key switch to teaching, or None.
        silence: Cuts the wire: nothing is answered any more.
    """

    kind: Kind[R, Arm]
    identity: str
    start: JointPositions
    above: Place
    beside: Place
    interpolation: Interpolation
    posture: int
    out_of_reach: Pose | None
    beyond_limits: JointPositions | None
    refusal: str = "."
    output: int | None = None
    is_speed_sent: bool = True
    press_stop: Callable[[R], None] | None = None
    release_stop: Callable[[R], None] | None = None
    teach: Callable[[R], None] | None = None
    silence: Callable[[R], None]
