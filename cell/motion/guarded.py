"""The arm as the rest of the cell may use it: every motion passes the guard first."""

from __future__ import annotations

from collections.abc import Callable

from cell.devices.arm import Arm
from cell.errors import CellError, DeviceError, MotionRefused, UnreachablePose
from cell.events import DeviceFailed, EventBus, MotionFinished, MotionRejected
from cell.geometry import JointPositions, Pose
from cell.motion.guard import Guard, GuardedMove
from cell.profile import MelfaProfile
from cell.stop import StopToken


class GuardedArm:
    """Moves an arm through its guard, and knows where it stands.

    The joint angles are read from the controller when the arm is opened and
    after any fault; in between each move starts where the last one ended.
    """

    def __init__(
        self, arm: Arm, guard: Guard, profile: MelfaProfile, events: EventBus, stop: StopToken
    ) -> None:
        self._arm = arm
        self._guard = guard
        self._profile = profile
        self._events = events
        self._stop = stop
        self._joints: JointPositions | None = None
        self._pose: Pose | None = None
        self._speed_mm_s = profile.linear_speed_mm_s
        self._percent = profile.joint_speed_percent

    @property
    def arm(self) -> Arm:
        """The arm itself, for everything but motion."""
        return self._arm

    def open(self) -> str:
        """Bring the controller up and read where the arm stands; return its identity."""
        identity = self._arm.open()
        self._joints = self._pose = None
        self._arm.set_speed(self._speed_mm_s, self._percent)
        return identity

    def close(self) -> None:
        """Let the controller go."""
        self._joints = self._pose = None
        self._arm.close()

    def set_speed(self, speed_mm_s: float, joint_percent: float) -> None:
        """Set the speed of later moves.

        Raises:
            MotionRefused: The speed is beyond the profile's limit.
        """
        limit_mm_s = self._profile.max_linear_speed_mm_s
        if not 0 < speed_mm_s <= limit_mm_s:
            raise MotionRefused(
                "linear speed", value=speed_mm_s, limit=limit_mm_s,
                nearest=min(max(speed_mm_s, 1.0), limit_mm_s), unit="mm/s", why="is out of range",
            )  # fmt: skip
        if not 0 < joint_percent <= 100:
            raise MotionRefused(
                "joint speed", value=joint_percent, limit=100.0,
                nearest=min(max(joint_percent, 1.0), 100.0), unit="%", why="is out of range",
            )  # fmt: skip
        self._arm.set_speed(speed_mm_s, joint_percent)
        self._speed_mm_s, self._percent = speed_mm_s, joint_percent

    def joints(self) -> JointPositions:
        """Return where the joints stand."""
        if self._joints is None:
            self._joints = self._arm.read_joints()
        return self._joints

    def pose(self) -> Pose:
        """Return where the tool point stands."""
        if self._pose is None:
            self._pose = self._arm.read_pose()
        return self._pose

    def raise_to(self, z_mm: float, *, holds_block: bool = False) -> None:
        """Lift the tool point straight up to a height, unless it is above."""
        here = self.pose()
        if here.z_mm < z_mm:
            self.move_linear(here.at_height(z_mm), holds_block=holds_block)

    def move_linear(self, target: Pose, *, holds_block: bool = False) -> None:
        """Move the tool point along a straight line.

        Raises:
            MotionRefused: The guard turned it down; nothing was sent.
            DeviceError: The arm did not get there; it was stopped.
        """
        start = self.joints()
        posture = self._profile.posture
        move = self._guarded(
            lambda: self._guard.check_linear(
                start, target, posture=posture, speed_mm_s=self._speed_mm_s, holds_block=holds_block
            )
        )
        self._go(move, target)

    def move_joint(self, target: Pose, *, holds_block: bool = False) -> None:
        """Move to a pose with all joints at once; the path between is a curve.

        Raises:
            MotionRefused: The guard turned it down; nothing was sent.
            DeviceError: The arm did not get there; it was stopped.
        """
        start = self.joints()
        posture = self._profile.posture
        move = self._guarded(
            lambda: self._guard.check_pose_joint(
                start, target, posture=posture, percent=self._percent, holds_block=holds_block
            )
        )
        self._go(move, target)

    def move_joints(self, target: JointPositions, *, holds_block: bool = False) -> None:
        """Move every joint to an angle.

        Raises:
            MotionRefused: The guard turned it down; nothing was sent.
            DeviceError: The arm did not get there; it was stopped.
        """
        start = self.joints()
        move = self._guarded(
            lambda: self._guard.check_joint(
                start, target, percent=self._percent, holds_block=holds_block
            )
        )
        self._run(move, lambda: self._arm.move_joints(target, expected_s=move.duration_s))

    def rest(self) -> None:
        """Stand aside, out of every camera's way."""
        rest = JointPositions(self._profile.rest_deg)
        if self.joints() != rest:
            self.move_joints(rest)

    def _guarded(self, check: Callable[[], GuardedMove]) -> GuardedMove:
        self._stop.check()
        try:
            return check()
        except (MotionRefused, UnreachablePose) as refusal:
            self._events.emit(MotionRejected(str(refusal)))
            raise

    def _go(self, move: GuardedMove, target: Pose) -> None:
        """Send the arm to a pose, the way that the guard has passed."""
        self._run(
            move,
            lambda: self._arm.move(
                target,
                interpolation=move.interpolation,
                posture=move.posture,
                turns=move.turns,
                expected_s=move.duration_s,
            ),
        )

    def _run(self, move: GuardedMove, send: Callable[[], None]) -> None:
        self._joints = self._pose = None
        try:
            send()
        except CellError:
            self._halt()
            raise
        self._joints, self._pose = move.end, move.end_pose
        self._events.emit(MotionFinished(move.end_pose))

    def _halt(self) -> None:
        """Stop the arm after a fault; a second fault here must not hide the first."""
        try:
            self._arm.stop()
        except DeviceError as error:
            self._events.emit(DeviceFailed("arm", f"could not be stopped: {error.problem}"))
