"""Poses from which a camera on the arm's flange sees a sheet's markers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cell.errors import MotionRefused, UnreachablePose
from cell.geometry import CameraView, JointPositions, LensModel, Pose, Transform
from cell.motion.guard import Guard
from cell.profile import Profile, StoreProfile
from cell.sheet.errors import SheetError
from cell.sheet.finding import Pixels
from cell.sheet.hidden import fingers_mask
from cell.sheet.layout import SheetLayout
from cell.sheet.placing import Points, SheetPlace
from cell.sheet.reading import Look

_HEIGHTS_MM = (300.0, 240.0, 360.0)
_TURNS_DEG = tuple(float(turn) for turn in range(-180, 180, 45))
_EDGE_PX = 40.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LookingPose:
    """A pose to look from.

    Attributes:
        pose: Of the tool point.
        joints: Of the arm there.
        sees: Indices of the sheet's markers that are wholly in the picture.
    """

    pose: Pose
    joints: JointPositions
    sees: tuple[int, ...]


def flange_view(
    pose: Pose, tool_mm: Sequence[float], lens: LensModel, flange_from_camera: Transform
) -> CameraView:
    """Return the view of a camera on the flange.

    Args:
        pose: Of the tool point when the picture was taken.
        tool_mm: The tool point in the flange's frame.
        lens: The camera's lens.
        flange_from_camera: Where the camera hangs on the flange.
    """
    flange_from_tool = np.eye(4)
    flange_from_tool[:3, 3] = tool_mm
    robot_from_flange = Transform.from_pose(pose) @ Transform(flange_from_tool).inverse()
    return CameraView(lens, robot_from_flange @ flange_from_camera)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HandCamera:
    """A calibrated camera on the flange.

    Attributes:
        lens: Its lens.
        flange_from_camera: Where it hangs.
        tool_mm: The tool point in the flange's frame.
        hidden: Where the fingers may hide the table, (960, 1280).
    """

    lens: LensModel
    flange_from_camera: Transform
    tool_mm: tuple[float, float, float]
    hidden: Pixels

    def look(self, pixels: Pixels, pose: Pose) -> Look:
        """Return a picture with its view.

        Args:
            pixels: The picture.
            pose: Of the tool point when it was taken.
        """
        view = flange_view(pose, self.tool_mm, self.lens, self.flange_from_camera)
        return Look(pixels=pixels, view=view, hidden=self.hidden)


def hand_camera(profile: Profile, camera: str) -> HandCamera:
    """Return what a profile knows of a camera on the flange.

    Raises:
        SheetError: Its lens or its mount is not calibrated.
    """
    known = profile.cameras[camera]
    if known.lens is None or known.mount is None:
        raise SheetError(
            f"camera {camera}: its lens and mount are not calibrated; "
            "`cell calibrate gripper-camera`"
        )
    lens, mount = known.lens.model(), known.mount.transform()
    return HandCamera(
        lens=lens,
        flange_from_camera=mount,
        tool_mm=profile.arm.tool_mm,
        hidden=fingers_mask(profile, lens, mount),
    )


def looking_poses(
    profile: Profile,
    layout: SheetLayout,
    lens: LensModel,
    flange_from_camera: Transform,
    *,
    store: StoreProfile | None = None,
    start: JointPositions | None = None,
    times: int = 2,
) -> tuple[LookingPose, ...]:
    """Return few poses from which the camera sees every marker that it can see at all.

    It looks again turned about the vertical, because the fingers and blocks hide parts.

    The guard passes the motions from the start to the first, and from each to the next.

    Args:
        profile: The cell's profile.
        layout: The sheet.
        lens: The camera's lens.
        flange_from_camera: Where the camera hangs on the flange.
        store: Where the sheet roughly lies; as in the profile unless given.
        start: Where the arm stands before; at rest unless given.
        times: From how many sides to look.
    """
    store = store or profile.store
    place = SheetPlace(
        corner_mm=store.corner_mm,
        angle_deg=store.angle_deg,
        scale=1.0,
        covariance=np.zeros((3, 3)),
        sigma_px=0.0,
        freedom=0,
    )
    guard = Guard.from_profile(profile)
    here = start or JointPositions(tuple(profile.arm.rest_deg))
    candidates = [
        (pose, sees)
        for pose in _candidates(profile, layout, place, lens, flange_from_camera)
        if (sees := _seen(pose, profile, layout, place, lens, flange_from_camera))
    ]
    chosen: list[LookingPose] = []
    for _ in range(times):
        before = [one.pose.c_deg for one in chosen]
        turned = [c for c in candidates if all(_is_turned(c[0].c_deg, b) for b in before)]
        found = _covering(turned, layout, guard, profile, here)
        chosen += found
        here = chosen[-1].joints if chosen else here
    return tuple(chosen)


def _covering(
    candidates: list[tuple[Pose, tuple[int, ...]]],
    layout: SheetLayout,
    guard: Guard,
    profile: Profile,
    here: JointPositions,
) -> list[LookingPose]:
    """Return poses that see every marker once, each the one that sees most of what is left."""
    waiting = {one.index for one in layout.fiducials}
    chosen: list[LookingPose] = []
    while waiting and candidates:
        candidates.sort(key=lambda one: -len(waiting & set(one[1])))
        pose, sees = candidates.pop(0)
        if not waiting & set(sees):
            break
        joints = _passed(guard, profile, here, pose)
        if joints is not None:
            chosen.append(LookingPose(pose=pose, joints=joints, sees=sees))
            waiting -= set(sees)
            here = joints
    return chosen


def _is_turned(first_deg: float, second_deg: float) -> bool:
    return abs(math.remainder(math.radians(first_deg - second_deg), math.tau)) > math.radians(80)


def _candidates(
    profile: Profile,
    layout: SheetLayout,
    place: SheetPlace,
    lens: LensModel,
    flange_from_camera: Transform,
) -> Iterator[Pose]:
    """Return poses, gripper down, whose picture's middle is at a point of the sheet."""
    surface_mm = profile.heights.surface_mm
    middle = np.array([[lens.centre_u_px, lens.centre_v_px]])
    across = np.linspace(0.15, 0.85, 5) * layout.width_mm
    down = np.linspace(0.15, 0.85, 4) * layout.height_mm
    for height_mm, turn_deg in itertools.product(_HEIGHTS_MM, _TURNS_DEG):
        pose = Pose(0.0, 0.0, surface_mm + height_mm, 180.0, 0.0, turn_deg)
        view = flange_view(pose, profile.arm.tool_mm, lens, flange_from_camera)
        try:
            hit = view.to_robot(middle, surface_mm)[0]
        except ValueError:
            continue
        for x, y in itertools.product(across, down):
            target = place.to_robot(np.array([x, y])) - hit
            yield Pose(float(target[0]), float(target[1]), pose.z_mm, 180.0, 0.0, turn_deg)


def _seen(
    pose: Pose,
    profile: Profile,
    layout: SheetLayout,
    place: SheetPlace,
    lens: LensModel,
    flange_from_camera: Transform,
) -> tuple[int, ...]:
    if not layout.fiducials:
        return ()
    view = flange_view(pose, profile.arm.tool_mm, lens, flange_from_camera)
    corners = np.array([one.corners_mm for one in layout.fiducials])
    try:
        pixels: Points = view.to_picture(place.to_robot(corners), profile.heights.surface_mm)
    except ValueError:
        return ()
    size = np.array([lens.width_px, lens.height_px])
    inside = ((pixels > _EDGE_PX) & (pixels < size - _EDGE_PX)).all(axis=(1, 2))
    return tuple(int(index) for index in np.nonzero(inside)[0])


def _passed(
    guard: Guard, profile: Profile, here: JointPositions, pose: Pose
) -> JointPositions | None:
    """Return the joints of a pose if the guard lets the arm go there."""
    arm = profile.arm
    try:
        guard.check_pose_joint(here, pose, posture=arm.posture, percent=arm.joint_speed_percent)
        return guard.arm.solve(pose, arm.posture, here)
    except (MotionRefused, UnreachablePose):
        return None
