"""The check before anything moves again after a stop: controller, pose, grip, clearance.

First what can be brought back is brought back (session, right, servos, the gripper's
power), without moving anything. Then each point is checked, the first that fails is told.
"""

from __future__ import annotations

from collections.abc import Callable

from cell.devices.arm import ArmState, OpenableArm
from cell.devices.gripper import Gripper, GripperState
from cell.errors import (
    CellError,
    DeviceError,
    LinkError,
    MotionRefused,
    ResumeRefused,
    UnreachablePose,
)
from cell.geometry import JointPositions, Pose
from cell.motion.hold import Hold
from cell.motion.motion_guard import MotionGuard
from cell.profile import Profile
from cell.recovery.whereabouts import strays_from, strays_from_stand
from cell.reporting import FaultReporter

_READINGS = 3
_AGREE_MM = 2.0


class ResumeCheck:
    """Implements `cell.motion.hold.ResumeGate` for an arm with a gripper.

    Args:
        profile: The cell's profile.
        arm: The arm itself.
        guard: The guard that every motion passes.
        gripper: The gripper itself.
        grip_problem: Told the gripper's state, says what is wrong with the grip; a block
            that turns out to be lost is noted by it.
        reporter: Told what was brought back.
    """

    def __init__(
        self,
        profile: Profile,
        *,
        arm: OpenableArm,
        guard: MotionGuard,
        gripper: Gripper,
        grip_problem: Callable[[GripperState], str],
        reporter: FaultReporter,
    ) -> None:
        self._profile = profile
        self._arm = arm
        self._guard = guard
        self._gripper = gripper
        self._grip_problem = grip_problem
        self._reporter = reporter

    def check(self, hold: Hold) -> str:
        """Check everything; return what was found.

        Raises:
            ResumeRefused: A point is not as it must be.
        """
        state = self._ready_state()
        self._require_ready(state)
        joints, pose = self._place()
        self._require_in_limits(joints)
        self._require_on_path(hold, joints, pose)
        grip = self._require_grip()
        clearance = self._require_clearance(joints, pose)
        return f"controller ready, pose {pose}, {grip}, {clearance}"

    # The controller

    def _ready_state(self) -> ArmState:
        """Return the state of a controller that can move, opening it anew if it must be."""
        try:
            state = self._arm.read_state()
            if _is_ready(state):
                return state
        except (DeviceError, LinkError):
            pass
        try:
            self._arm.open()
            self._switch_outputs_on()
            state = self._arm.read_state()
        except CellError as error:
            raise ResumeRefused(f"the arm is not ready: {error}") from error
        self._reporter.recovered("arm", "opened again")
        return state

    def _switch_outputs_on(self) -> None:
        outputs = self._profile.outputs
        self._arm.set_output(outputs.gripper_power, is_on=True)
        self._arm.set_output(outputs.lights, is_on=True)

    @staticmethod
    def _require_ready(state: ArmState) -> None:
        if state.is_emergency_stopped:
            raise ResumeRefused("an emergency stop is pressed: release it")
        if not state.is_automatic:
            raise ResumeRefused("the key switch stands at TEACH: turn it to AUTO")
        if state.alarm:
            raise ResumeRefused(
                f"alarm {state.alarm} is active ({state.alarm_text}): remove its cause"
            )
        if not state.has_right:
            raise ResumeRefused("somebody else has the operation right: give it back at the panel")
        if not state.is_servo_on:
            raise ResumeRefused("the servos are off: see the controller's panel")
        if state.is_moving:
            raise ResumeRefused("the arm moves though nobody sent it: press the emergency stop")

    # Where the arm stands

    def _place(self) -> tuple[JointPositions, Pose]:
        """Read joints and pose until they belong together: a bit may turn over on the wire."""
        for _ in range(_READINGS):
            joints, pose = self._arm.read_joints(), self._arm.read_pose()
            if _apart_mm(self._guard.arm.forward(joints), pose) <= _AGREE_MM:
                return joints, pose
        raise ResumeRefused(
            f"joint angles and pose do not belong together ({joints}; {pose}): check the "
            "controller's tool setting"
        )

    def _require_in_limits(self, joints: JointPositions) -> None:
        arm = self._profile.arm
        for number, (value, low, high) in enumerate(
            zip(joints.values, arm.joint_min_deg, arm.joint_max_deg, strict=True), 1
        ):
            if not low <= value <= high:
                raise ResumeRefused(
                    f"J{number} stands at {value:.1f} deg, outside {low:.0f} to {high:.0f} deg: "
                    "bring it back with the teach pendant"
                )

    def _require_on_path(self, hold: Hold, joints: JointPositions, pose: Pose) -> None:
        off = ""
        if hold.move is not None:
            start_pose = self._guard.arm.forward(hold.move.start)
            off = strays_from(hold.move, start_pose, joints, pose)
        elif hold.stand is not None:
            off = strays_from_stand(joints, hold.stand)
        if off:
            raise ResumeRefused(
                f"the arm is {off}: it was moved by hand or its place is told wrong; end the "
                "session, look at it, and begin a new one"
            )

    # What the fingers hold

    def _require_grip(self) -> str:
        state = self._gripper_state()
        if state.has_error:
            raise ResumeRefused(
                f"the gripper has an error that stays ({state.error_text}): remove its cause"
            )
        problem = self._grip_problem(state)
        if problem:
            raise ResumeRefused(problem)
        if not state.is_referenced:
            return "fingers not referenced"
        return f"fingers at {state.position_mm:.1f} mm"

    def _gripper_state(self) -> GripperState:
        try:
            state = self._gripper.read_state()
            if state.has_error:
                self._gripper.acknowledge()
                state = self._gripper.read_state()
            if state.is_referenced:
                return state
            # It was without power, and has forgotten more than its zero.
        except (DeviceError, LinkError):
            pass
        try:
            self._arm.set_output(self._profile.outputs.gripper_power, is_on=True)
            self._gripper.close()
            self._gripper.open(may_move=False)
            state = self._gripper.read_state()
        except CellError as error:
            raise ResumeRefused(f"nobody knows what the fingers hold: {error}") from error
        self._reporter.recovered("gripper", "opened again")
        return state

    # Whether the hand comes away

    def _require_clearance(self, joints: JointPositions, pose: Pose) -> str:
        service_mm = self._profile.heights.service_mm
        if pose.z_mm >= service_mm:
            return "hand above everything"
        try:
            self._guard.check_linear(
                joints,
                pose.at_height(service_mm),
                posture=self._profile.arm.posture,
                speed_mm_s=self._profile.arm.linear_speed_mm_s,
                holds_block=True,
            )
        except (MotionRefused, UnreachablePose) as refusal:
            raise ResumeRefused(
                f"the hand cannot rise straight up ({refusal}): free it with the teach pendant"
            ) from refusal
        return "hand free to rise"


def _is_ready(state: ArmState) -> bool:
    return (
        state.is_servo_on
        and state.is_automatic
        and state.has_right
        and not (state.is_emergency_stopped or state.alarm)
    )


def _apart_mm(one: Pose, other: Pose) -> float:
    return max(abs(one.x_mm - other.x_mm), abs(one.y_mm - other.y_mm), abs(one.z_mm - other.z_mm))
