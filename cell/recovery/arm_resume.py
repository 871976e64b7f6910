"""The check before an arm without a playground moves again after a stop.

Like `cell.recovery.resume`, but for controllers that forget where the arm is when they were
off, and for fingers that measure nothing. Nothing moves in here: an arm that has lost its
place has to be closed and opened again by somebody who looks at it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cell.devices.arm import ArmSignals, ArmState
from cell.devices.gripper import Gripper
from cell.errors import (
    CellError,
    DeviceError,
    DeviceRestarted,
    LinkError,
    MotionRefused,
    ResumeRefused,
    UnreachablePose,
)
from cell.geometry import JointPositions, Pose
from cell.kinematics.arm import ArmKinematics
from cell.motion.hold import Hold
from cell.motion.motion_guard import MotionFigures, MotionGuard
from cell.recovery.whereabouts import (
    ON_PATH_DEG,
    ON_PATH_MM,
    away_from_joint_path_deg,
    away_from_line_mm,
)
from cell.reporting import FaultReporter

_READINGS = 3
_AGREE_MM = 2.0
_LIMIT_SLACK = 0.1
_OPEN_WITHIN_MM = 1.0
_AGAIN = "see that the arm is free, then close the arm and open it again"


@dataclass(frozen=True, slots=True, kw_only=True)
class Straying:
    """How far from its path a stopped arm may stand.

    Attributes:
        within_mm: Distance of the tool point from its line.
        within: Distance of any joint from its path or stand, in the joint's unit.
    """

    within_mm: float = ON_PATH_MM
    within: float = ON_PATH_DEG


@dataclass(frozen=True, slots=True, kw_only=True)
class BlindFingers:
    """Fingers that measure nothing.

    Attributes:
        gripper: The gripper itself.
        open_mm: Opening at which they hold nothing.
        limp_is_empty: Whether fingers that are not referenced cannot hold anything, because
            they are limp; otherwise nobody knows.
    """

    gripper: Gripper
    open_mm: float
    limp_is_empty: bool

    def holding(self) -> str:
        """Return what they may hold, as words; empty if they hold nothing.

        Raises:
            DeviceError: They do not answer.
        """
        state = self.gripper.read_state()
        if not state.is_referenced:
            return "" if self.limp_is_empty else "nothing tells how the fingers stand"
        if state.position_mm >= self.open_mm - _OPEN_WITHIN_MM:
            return ""
        return f"the fingers were told to stand at {state.position_mm:.1f} mm"

    def may_hold(self) -> bool:
        """Return whether something may be between them; silence means yes."""
        try:
            return bool(self.holding())
        except (DeviceError, LinkError):
            return True


class ArmResumeCheck:
    """Implements `cell.motion.hold.ResumeGate` for an arm without a playground.

    Args:
        figures: The arm's figures in the profile.
        arm: The arm, to be asked.
        reopen: Brings the arm back into service without moving it; raises `DeviceRestarted`
            when it has lost its place.
        kinematics: The arm's limits.
        guard: The guard that every motion passes.
        fingers: Its fingers, None if it has none.
        straying: How far from its path it may stand.
        reporter: Told what was brought back.
    """

    def __init__(
        self,
        figures: MotionFigures,
        *,
        arm: ArmSignals,
        reopen: Callable[[], None],
        kinematics: ArmKinematics,
        guard: MotionGuard,
        fingers: BlindFingers | None,
        straying: Straying,
        reporter: FaultReporter,
    ) -> None:
        self._figures = figures
        self._arm = arm
        self._reopen = reopen
        self._kinematics = kinematics
        self._guard = guard
        self._fingers = fingers
        self._straying = straying
        self._reporter = reporter
        self._is_grip_confirmed = False

    def confirm_grip(self) -> None:
        """Say that somebody looked at the fingers; holds for the next check that is clear."""
        self._is_grip_confirmed = True

    def check(self, hold: Hold) -> str:
        """Check everything; return what was found.

        Raises:
            ResumeRefused: A point is not as it must be.
        """
        _require_ready(self._ready_state())
        joints, pose = self._place()
        self._require_in_limits(joints)
        self._require_on_path(hold, joints, pose)
        grip = self._require_grip()
        clearance = self._require_clearance(joints, pose)
        self._is_grip_confirmed = False
        return f"controller ready, pose {pose}, {grip}, {clearance}"

    def _ready_state(self) -> ArmState:
        """Return the state of a controller that can move, taken into service if it must be."""
        try:
            state = self._arm.read_state()
            if state.is_servo_on or state.is_emergency_stopped:
                return state
        except (DeviceError, LinkError):
            pass
        try:
            self._reopen()
            state = self._arm.read_state()
        except DeviceRestarted as error:
            raise ResumeRefused(f"nobody knows where the arm stands: {error.problem}; {_AGAIN}") \
                from error  # fmt: skip
        except CellError as error:
            raise ResumeRefused(f"the arm is not ready: {error}") from error
        self._reporter.recovered("arm", "opened again")
        return state

    def _place(self) -> tuple[JointPositions, Pose]:
        """Read joints and pose until they belong together: a bit may turn over on the wire."""
        for _ in range(_READINGS):
            joints, pose = self._arm.read_joints(), self._arm.read_pose()
            there = self._guard.arm.forward(joints)
            apart_mm = max(
                abs(there.x_mm - pose.x_mm),
                abs(there.y_mm - pose.y_mm),
                abs(there.z_mm - pose.z_mm),
            )
            if apart_mm <= _AGREE_MM:
                return joints, pose
        raise ResumeRefused(
            f"joints and pose do not belong together ({joints}; {pose}): check the line"
        )

    def _require_in_limits(self, joints: JointPositions) -> None:
        arm = self._kinematics
        for number, (value, low, high, unit) in enumerate(
            zip(joints.values, arm.joint_min, arm.joint_max, arm.joint_units, strict=True), 1
        ):
            if not low - _LIMIT_SLACK <= value <= high + _LIMIT_SLACK:
                raise ResumeRefused(
                    f"J{number} stands at {value:.1f} {unit}, outside {low:.0f} to {high:.0f} "
                    f"{unit}: bring it back by hand"
                )

    def _require_on_path(self, hold: Hold, joints: JointPositions, pose: Pose) -> None:
        off = self._strays(hold, joints, pose)
        if off:
            raise ResumeRefused(
                f"the arm is {off}: it was moved by hand or its place is told wrong; {_AGAIN}"
            )

    def _strays(self, hold: Hold, joints: JointPositions, pose: Pose) -> str:
        move, allowed = hold.move, self._straying
        if move is not None and move.interpolation == "linear":
            start = self._guard.arm.forward(move.start)
            off_mm = away_from_line_mm(pose, start, move.end_pose)
            return f"{off_mm:.0f} mm off the line it was on" if off_mm > allowed.within_mm else ""
        if move is not None:
            off = away_from_joint_path_deg(joints, move.start, move.end)
            return f"{off:.1f} deg or mm off its path" if off > allowed.within else ""
        if hold.stand is not None:
            off = away_from_joint_path_deg(joints, hold.stand, hold.stand)
            return f"{off:.1f} deg or mm from where it stood" if off > allowed.within else ""
        return ""

    def _require_grip(self) -> str:
        if self._fingers is None:
            return "no fingers"
        try:
            holding = self._fingers.holding()
        except (DeviceError, LinkError) as error:
            raise ResumeRefused(f"nobody knows what the fingers hold: {error}") from error
        if not holding:
            return "fingers open"
        if not self._is_grip_confirmed:
            raise ResumeRefused(
                f"nobody knows what the fingers hold ({holding}; nothing measures them): look, "
                "and confirm the grip"
            )
        return f"{holding}, looked at"

    def _require_clearance(self, joints: JointPositions, pose: Pose) -> str:
        """Return how the hand comes away: straight up, or at least by its guard's leave."""
        rest_mm = self._guard.arm.forward(JointPositions(self._figures.rest_deg)).z_mm
        if pose.z_mm >= rest_mm:
            return "hand as high as at rest"
        try:
            self._guard.check_linear(
                joints,
                pose.at_height(rest_mm),
                posture=self._figures.posture,
                speed_mm_s=self._figures.linear_speed_mm_s,
                holds_block=True,
            )
        except (MotionRefused, UnreachablePose) as rising:
            self._require_may_stay(joints, rising)
            return "hand free where it is, not straight up"
        return "hand free to rise"

    def _require_may_stay(self, joints: JointPositions, rising: CellError) -> None:
        try:
            self._guard.check_joint(
                joints, joints, percent=self._figures.joint_speed_percent, holds_block=True
            )
        except MotionRefused as refusal:
            raise ResumeRefused(
                f"the hand can neither rise ({rising}) nor stay ({refusal}): free it by hand"
            ) from refusal


def _require_ready(state: ArmState) -> None:
    if state.is_emergency_stopped:
        raise ResumeRefused("an emergency stop is pressed: release it")
    if state.alarm:
        raise ResumeRefused(f"alarm {state.alarm} is active ({state.alarm_text}): remove its cause")
    if not state.is_servo_on:
        raise ResumeRefused(f"the arm is not in service: {_AGAIN}")
    if state.is_moving:
        raise ResumeRefused("the arm moves though nobody sent it: cut its power")
