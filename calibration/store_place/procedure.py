"""The procedure `store-place`: where the store's sheet lies, touched, typed or seen."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.procedure import (
    Procedure,
    Steps,
    ask_choice,
    ask_done,
    ask_number,
    ask_numbers,
    capture,
    light,
    move_tool,
    read_tool,
    stand_aside,
    tell,
)
from calibration.store_place.fitting import CORNERS, Touched
from calibration.store_place.measurement import KIND, measure_seen, measure_touched
from cell.geometry import CameraView
from cell.profile import Profile
from cell.sheet import SheetLayout, lay_out
from cell.sheet.looking import hand_camera, looking_poses
from cell.sheet.reading import Look
from cell.store import StorePlan, with_calibration_object

__all__ = ["KIND", "store_place"]

_CORNERS: Final = 4
_PICTURES: Final = 3
_WHERE: Final = (
    "by the black triangle", "where the plan's arrow points", "opposite the black triangle",
    "below the black triangle",
)  # fmt: skip


def store_place(site: Site) -> Procedure:
    """Measure where the store's sheet lies in the robot frame.

    Raises:
        CalibrationError: The cell has no store, or no camera can tell.
        FitFailed: The corners do not tell where it lies.
    """
    profile, plan = site.profile, site.plan
    if not isinstance(profile, Profile) or plan is None or not plan.slots:
        raise CalibrationError(f"the cell {site.profile.name} has no store whose place to measure")
    plan = with_calibration_object(plan, profile.store)
    layout = lay_out(plan.slots, profile.blocks)
    cameras = tuple(
        name
        for name, camera in profile.cameras.items()
        if isinstance(camera.view(profile.heights.surface_mm), CameraView)
        or (camera.lens is not None and camera.mount is not None)
    )
    ways = ("touch", "type", *(["camera"] if cameras else []))
    way = yield from ask_choice(
        "way",
        "How is it measured: corners touched with the arm, corners typed"
        + (", or the sheet seen by a camera?" if cameras else "? (no camera is calibrated)"),
        ways,
        default="touch",
    )
    ruler_mm = yield from ask_number(
        "ruler", "What does the sheet's 100 mm ruler measure?", unit="mm", default=100.0
    )
    if not 50.0 <= ruler_mm <= 200.0:
        raise CalibrationError(
            f"ruler: one of 100 mm cannot measure {ruler_mm:g} mm; give millimetres, such as 97.0"
        )
    if way == "camera":
        return (yield from _by_camera(profile, plan, layout, cameras, ruler_mm))
    return (yield from _by_corners(profile, plan, layout, way == "touch", ruler_mm))


def _by_corners(
    profile: Profile, plan: StorePlan, layout: SheetLayout, is_touched: bool, ruler_mm: float
) -> Procedure:
    count = yield from ask_number(
        "corners", "How many corners, 2 to 4? More tell how good it is", default=float(_CORNERS)
    )
    if count not in (2.0, 3.0, 4.0):
        raise CalibrationError(f"corners: 2, 3 or 4 can be taken, not {count:g}")
    noise_mm = yield from ask_number(
        "noise", "How exactly is a corner met (standard deviation)?", unit="mm", default=0.5
    )
    if not noise_mm > 0.0:
        raise CalibrationError(f"noise: {noise_mm:g} mm is not above 0; no touch is exact")
    points = []
    for index in range(int(count)):
        yield from tell(f"corner {index + 1} of {int(count)}", index, int(count))
        points.append((yield from _corner(index, is_touched)))
    touched = Touched(
        size_mm=(float(layout.width_mm), float(layout.height_mm)),
        scale=ruler_mm / 100.0,
        points_mm=np.array(points),
        noise_mm=noise_mm,
    )
    return measure_touched(touched, profile, plan)


def _corner(index: int, is_touched: bool) -> Steps[tuple[float, float]]:
    where = f"the sheet's {CORNERS[index]} corner, {_WHERE[index]}"
    key = CORNERS[index].replace(" ", "-")
    if is_touched:
        yield from ask_done(f"{key}-touched", f"Drive the tool point over {where}.")
        pose = (yield from read_tool()).pose
        return pose.x_mm, pose.y_mm
    x, y = yield from ask_numbers(key, f"Robot x and y of {where}?", count=2, unit="mm")
    return x, y


def _by_camera(
    profile: Profile,
    plan: StorePlan,
    layout: SheetLayout,
    cameras: tuple[str, ...],
    ruler_mm: float,
) -> Procedure:
    camera = yield from ask_choice("camera", "Which camera looks?", cameras, default=cameras[0])
    scale: float | None = None if math.isclose(ruler_mm, 100.0) else ruler_mm
    if profile.cameras[camera].mount is not None:
        looks, digests = yield from _by_hand_camera(profile, layout, camera)
        return measure_seen(looks, digests, camera, layout, profile, plan, ruler_mm=scale)
    count = yield from ask_number("pictures", "How many pictures?", default=float(_PICTURES))
    if not 1.0 <= count <= 20.0 or count != int(count):
        raise CalibrationError(f"pictures: 1 to 20 can be taken, not {count:g}")
    view = profile.cameras[camera].view(profile.heights.surface_mm)
    yield from stand_aside()
    looks, digests = [], []
    for index in range(int(count)):
        picture = yield from capture(camera, f"the store's sheet, {index + 1} of {int(count)}")
        looks.append(Look(pixels=picture.pixels, view=view))
        digests.append(picture.digest)
    return measure_seen(looks, digests, camera, layout, profile, plan, ruler_mm=scale)


def _by_hand_camera(
    profile: Profile, layout: SheetLayout, camera: str
) -> Steps[tuple[list[Look], list[str]]]:
    """Look with the camera on the flange from poses that see all of the sheet.

    Raises:
        CalibrationError: The guard lets the arm go to none.
    """
    here = yield from read_tool()
    hand = hand_camera(profile, camera)
    poses = looking_poses(profile, layout, hand.lens, hand.flange_from_camera, start=here.joints)
    if not poses:
        raise CalibrationError(
            f"the arm can bring camera {camera} nowhere from where it sees the store's sheet; "
            "touch its corners instead"
        )
    yield from light(is_on=True)
    looks, digests = [], []
    for number, one in enumerate(poses, 1):
        yield from tell(f"look {number} of {len(poses)}", number - 1, len(poses))
        reading = yield from move_tool(one.pose, by_joints=True)
        picture = yield from capture(camera, f"the store's sheet, {number} of {len(poses)}")
        looks.append(hand.look(picture.pixels, reading.pose))
        digests.append(picture.digest)
    yield from stand_aside()
    return looks, digests
