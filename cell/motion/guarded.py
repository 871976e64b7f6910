"""The arm as the rest of the cell may use it: every motion passes the guard first.

After any fault the arm is held: nothing moves it again before the resume check was clear,
and so it is after the cell was opened, for nobody watched over it before. There is no way
around that, because every motion of the arm starts in `_guarded`, and whatever else moves
(the fingers) asks `ensure_clear` first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from cell.devices.absent import AbsentArm
from cell.devices.arm import Arm, ArmSignals, OpenableArm
from cell.errors import (
    CellError,
    DeviceError,
    MotionRefused,
    ResumeRefused,
    SafeStop,
    Stopped,
    UnreachablePose,
)
from cell.events import EventBus, MotionFinished, MotionRejected
from cell.geometry import JointPositions, Pose
from cell.motion.guard import GuardedMove
from cell.motion.hold import Hold, ResumeGate
from cell.motion.motion_guard import MotionFigures, MotionGuard
from cell.recovery.diagnosis import fault_of, fault_of_arm
from cell.recovery.faults import Deed, DeviceName
from cell.recovery.policy import deed_for
from cell.reporting import FaultReporter
from cell.stop import StopToken

_READINGS = 3
_FIT_MM = 2.0


class GuardedArm:
    """Moves an arm through its guard, and knows where it stands.

    The joint angles are read from the controller when the arm is opened and
    after any fault; in between each move starts where the last one ended.
    """

    def __init__(
        self,
        arm: Arm,
        guard: MotionGuard,
        profile: MotionFigures,
        events: EventBus,
        stop: StopToken,
    ) -> None:
        self._reporter = FaultReporter(events)
        self._arm = arm if profile.enabled else _absent(guard, profile, self._reporter)
        self._moves = profile.enabled
        self._guard = guard
        self._profile = profile
        self._events = events
        self._stop = stop
        self._gate: ResumeGate | None = None
        self._hold: Hold | None = None
        self._joints: JointPositions | None = None
        self._pose: Pose | None = None
        self._speed_mm_s = profile.linear_speed_mm_s
        self._percent = profile.joint_speed_percent

    @property
    def arm(self) -> ArmSignals:
        """The arm itself, for everything but motion."""
        return self._arm

    @property
    def guard(self) -> MotionGuard:
        """The guard that every motion passes."""
        return self._guard

    # After a fault

    @property
    def is_held(self) -> bool:
        """Whether a fault has stopped the arm, so that nothing may move before a check."""
        return self._hold is not None and self._hold.is_fault

    def pass_through(self, make_gate: Callable[[OpenableArm], ResumeGate]) -> None:
        """Have a gate decide from now on whether the arm may move again after a fault.

        Args:
            make_gate: Makes the gate for this arm, which it may open and ask, not move.
        """
        self._gate = make_gate(self._arm)

    def check_before_moving(self, reason: str) -> None:
        """Have the gate checked before the first motion, though no fault is known.

        Args:
            reason: Why, for people. A fault that holds the arm already stays the reason.
        """
        if self._hold is None and self._moves:
            self._hold = Hold(reason=reason, is_fault=False)

    def allow_resume(self) -> None:
        """Let the check decide even after a stop: a new task or a clean-up was asked for."""
        if self._hold is not None and self._hold.needs_restart:
            self._hold = replace(self._hold, needs_restart=False)

    def ensure_clear(self) -> None:
        """Return if something may move; after a fault, or an opening, check that first.

        Raises:
            ResumeRefused: The check says no, or nobody has asked to go on after a stop.
        """
        hold = self._hold
        if hold is None:
            return
        try:
            detail = self._passed(hold)
        except CellError as error:
            self._reporter.checked(is_clear=False, detail=str(error))
            if isinstance(error, ResumeRefused):
                raise
            raise ResumeRefused(f"nothing may move yet after a stop: {error}") from error
        self._joints = self._pose = None
        self._hold = None
        self._reporter.checked(is_clear=True, detail=detail, is_routine=not hold.is_fault)

    def _passed(self, hold: Hold) -> str:
        if hold.needs_restart:
            raise ResumeRefused(
                f"the cell was stopped ({hold.reason}); begin a new task, or run `cell clean`"
            )
        if self._gate is None:
            raise ResumeRefused("there is nobody to check whether the arm may move; open the cell")
        detail = self._gate.check(hold)
        self._arm.set_speed(self._speed_mm_s, self._percent)
        return detail

    def fail(
        self, device: DeviceName, error: CellError, move: GuardedMove | None = None
    ) -> CellError:
        """Stop the arm because of a fault of any device, and hold it until a check.

        Args:
            device: Whose fault it is.
            error: The fault.
            move: The motion that was under way.

        Returns:
            What to raise: the error itself, or a `SafeStop` after which the task is over.
        """
        if isinstance(error, SafeStop | ResumeRefused):
            return error
        self._halt()
        if device in ("arm", "lights"):
            deed = deed_for("arm", fault_of_arm(error, self._arm))
        else:
            deed = deed_for(device, fault_of(error))
        words = str(error)
        reason = words if words.startswith(device) else f"{device}: {words}"
        stand = self._joints if move is None else None
        before = self._hold if self.is_held else None
        is_final = deed is Deed.STOP or (before is not None and before.needs_restart)
        if before is not None:
            move, stand = before.move or move, before.stand if move is None else None
        self._hold = Hold(reason=reason, move=move, stand=stand, needs_restart=is_final)
        self._joints = self._pose = None
        self._reporter.held(reason)
        return SafeStop(error) if deed is Deed.STOP else error

    # Opening and closing

    def open(self) -> str:
        """Bring the controller up and read where the arm stands; return its identity."""
        identity = self._arm.open()
        self._joints = self._pose = None
        self._arm.set_speed(self._speed_mm_s, self._percent)
        return identity

    def close(self) -> None:
        """Let the controller go; whoever comes meanwhile may move the arm by hand."""
        self._joints = self._pose = None
        if self._hold is not None:
            self._hold = replace(self._hold, move=None, stand=None)
        self._arm.close()

    # Speed and place

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
            try:
                self._joints = self._sure_joints()
            except CellError as error:
                raise self.fail("arm", error) from error
        return self._joints

    def _sure_joints(self) -> JointPositions:
        """Read the joints, and hold them against the pose: a bit may have turned over.

        Raises:
            DeviceError: The two do not fit, however often they are read.
        """
        for _ in range(_READINGS):
            joints, pose = self._arm.read_joints(), self._arm.read_pose()
            if _fits(self._guard.arm.forward(joints), pose):
                self._pose = pose
                return joints
        raise DeviceError(
            "arm",
            f"tells joint angles and a pose that do not belong together ({joints}; {pose})",
            hint="check the controller's tool setting against the profile's tool_mm",
        )

    def pose(self) -> Pose:
        """Return where the tool point stands."""
        if self._pose is None:
            try:
                self._pose = self._arm.read_pose()
            except CellError as error:
                raise self.fail("arm", error) from error
        return self._pose

    def raise_to(self, z_mm: float, *, holds_block: bool = False) -> None:
        """Lift the tool point straight up to a height, unless it is above."""
        self.ensure_clear()
        here = self.pose()
        if here.z_mm < z_mm:
            self.move_linear(here.at_height(z_mm), holds_block=holds_block)

    def move_linear(self, target: Pose, *, holds_block: bool = False) -> None:
        """Move the tool point along a straight line.

        Raises:
            MotionRefused: The guard turned it down; nothing was sent.
            DeviceError: The arm did not get there; it was stopped.
        """
        posture = self._profile.posture
        move = self._guarded(
            lambda start: self._guard.check_linear(
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
        posture = self._profile.posture
        move = self._guarded(
            lambda start: self._guard.check_pose_joint(
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
        move = self._guarded(
            lambda start: self._guard.check_joint(
                start, target, percent=self._percent, holds_block=holds_block
            )
        )
        self._run(move, lambda: self._arm.move_joints(target, expected_s=move.duration_s))

    def rest(self) -> None:
        """Stand aside, out of every camera's way."""
        self.ensure_clear()
        rest = JointPositions(self._profile.rest_deg)
        if self.joints() != rest:
            self.move_joints(rest)

    def _guarded(self, check: Callable[[JointPositions], GuardedMove]) -> GuardedMove:
        try:
            self._stop.check()
        except Stopped as stopped:
            raise self.fail("arm", stopped) from stopped
        if self._hold is not None:
            self.ensure_clear()
        start = self.joints()
        try:
            return check(start)
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
        except CellError as error:
            raise self.fail("arm", error, move) from error
        self._joints, self._pose = move.end, move.end_pose
        if self._moves:
            self._events.emit(MotionFinished(move.end_pose))

    def _halt(self) -> None:
        """Stop the arm after a fault; a second fault here must not hide the first."""
        try:
            self._arm.stop()
        except CellError as error:
            self._reporter.not_stopped(str(error))


def _absent(guard: MotionGuard, profile: MotionFigures, reporter: FaultReporter) -> Arm:
    return AbsentArm(
        JointPositions(profile.rest_deg),
        forward=guard.arm.forward,
        solve=guard.arm.solve,
        on_skip=reporter.skipped,
    )


def _fits(calculated: Pose, told: Pose) -> bool:
    """Return whether a pose told with two digits can be that of joints told with two digits."""
    return (
        max(
            abs(calculated.x_mm - told.x_mm),
            abs(calculated.y_mm - told.y_mm),
            abs(calculated.z_mm - told.z_mm),
        )
        <= _FIT_MM
    )
