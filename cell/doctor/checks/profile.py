"""What a valid profile may still have wrong: places out of reach, heights, doubles."""

from __future__ import annotations

from collections.abc import Sequence

from cell.doctor.notes import Notes
from cell.doctor.patient import Patient
from cell.errors import CellError, UnreachablePose
from cell.geometry import JointPositions, LatticeMap, Pose
from cell.kinematics import SixAxisArm
from cell.profile import Profile
from cell.store import place_of_slot

_DOWN_DEG = (180.0, 0.0, 180.0)
"""A and B of a hand that points down, and C, the rotation of the cell's moves."""

_MARGIN_MM = 0.5
"""The fingertips keep this far from the glass."""


def check_profile(patient: Patient, notes: Notes) -> None:
    """Hold the profile against itself, the arm's reach, and the script's views."""
    profile = patient.profile
    _check_doubles(profile, notes)
    _check_views(patient, notes)
    _check_heights(profile, notes)
    try:
        arm = SixAxisArm.from_profile(profile.arm)
    except CellError as error:
        notes.find("profile-invalid", "profile", "the arm's limits cannot be used", str(error))
        return
    _check_rest(profile, arm, notes)
    _check_slots(patient, arm, notes)
    _check_corners(patient, arm, notes)


def _check_doubles(profile: Profile, notes: Notes) -> None:
    serials = {
        "arm": profile.arm.serial,
        "gripper": profile.gripper.serial,
        "display": profile.display.serial,
    }
    if profile.arm.tcp is not None:
        del serials["arm"]
    names = {device: wire.usb_serial or wire.port for device, wire in serials.items()}
    _find_doubles(names, "profile-same-port", "port", notes)
    guids = {f"camera {name}": camera.guid for name, camera in profile.cameras.items()}
    _find_doubles(guids, "profile-same-guid", "GUID", notes)


def _find_doubles(values: dict[str, str], cause: str, words: str, notes: Notes) -> None:
    seen: dict[str, str] = {}
    for owner, value in values.items():
        if value and value in seen:
            problem = f"{seen[value]} and {owner} have the same {words}"
            notes.find(cause, "profile", problem, f"{words} {value} twice")
        seen.setdefault(value, owner)


def _check_views(patient: Patient, notes: Notes) -> None:
    missing = sorted(set(patient.views) - set(patient.profile.cameras))
    for name in missing:
        there = ", ".join(patient.profile.cameras) or "none"
        problem = f"the script has a view of camera {name}, the profile has no such camera"
        notes.find("profile-camera-missing", "profile", problem, f"cameras: {there}")
    if patient.views and not missing:
        notes.fine("profile", "every view has its camera")


def _check_heights(profile: Profile, notes: Notes) -> None:
    tips_mm = profile.heights.laying_mm - profile.gripper.tip_below_tool_mm
    surface_mm = profile.heights.surface_mm
    top_mm = surface_mm + min(block.height_mm for block in profile.blocks.values())
    facts = f"fingertips at {tips_mm:.1f} mm, surface {surface_mm:.1f} mm, lowest block's top "
    if tips_mm < surface_mm + _MARGIN_MM:
        problem = "laying a block would press the fingertips into the surface"
    elif tips_mm > top_mm - _MARGIN_MM:
        problem = "the fingertips would close above the lowest block"
    elif profile.heights.service_mm - profile.gripper.tip_below_tool_mm < top_mm:
        problem = "at the service height the hand would run into blocks"
        facts = f"service height {profile.heights.service_mm:.1f} mm, block tops at "
    else:
        notes.fine("profile", "laying and service height fit surface and blocks")
        return
    notes.find("profile-laying-height", "profile", problem, f"{facts}{top_mm:.1f} mm")


def _check_rest(profile: Profile, arm: SixAxisArm, notes: Notes) -> None:
    rest = profile.arm.rest_deg
    for violation in arm.violations(rest):
        problem = f"at rest {violation.joint} would stand outside its limits"
        fact = f"{violation.joint} {violation.value_deg:g} deg, limit {violation.limit_deg:g} deg"
        notes.find("profile-rest-refused", "profile", problem, fact)
        return
    flange_mm = arm.flange(JointPositions(rest)).z_mm
    least_mm = profile.arm.flange_min_z_mm
    if flange_mm < least_mm:
        problem = "at rest the arm would be below its lowest height"
        fact = f"flange at {flange_mm:.1f} mm, lowest allowed {least_mm:.1f} mm"
        notes.find("profile-rest-refused", "profile", problem, fact)
    else:
        notes.fine("profile", "the arm may stand aside where the profile says")


def _check_slots(patient: Patient, arm: SixAxisArm, notes: Notes) -> None:
    heights = patient.profile.heights
    bad: list[str] = []
    facts: list[str] = []
    for slot in patient.plan.slots:
        place = place_of_slot(slot, patient.profile.store)
        why = why_unreachable(
            patient.profile, arm, place.x_mm, place.y_mm, (heights.laying_mm, heights.service_mm)
        )
        if why:
            bad.append(str(slot.number))
            facts.append(f"slot {slot.number} at ({place.x_mm:.1f}, {place.y_mm:.1f}) mm: {why}")
    if bad:
        words = f"slot {bad[0]} is" if len(bad) == 1 else f"slots {', '.join(bad)} are"
        notes.find("profile-slot-unreachable", "profile", f"{words} out of reach", *facts[:3])
    else:
        notes.fine("profile", f"all {len(patient.plan.slots)} slots of the store are in reach")


def _check_corners(patient: Patient, arm: SixAxisArm, notes: Notes) -> None:
    heights = patient.profile.heights
    facts: list[str] = []
    for (x, y), (x_mm, y_mm) in lattice_corners(patient).items():
        why = why_unreachable(
            patient.profile, arm, x_mm, y_mm, (heights.laying_mm, heights.service_mm)
        )
        if why:
            facts.append(f"({x}, {y}) at ({x_mm:.1f}, {y_mm:.1f}) mm: {why}")
    columns, rows = patient.lattice
    if facts:
        problem = f"a corner of the {columns} x {rows} lattice is out of reach"
        notes.find("profile-corner-unreachable", "profile", problem, *facts)
    else:
        notes.fine("profile", f"the corners of the {columns} x {rows} lattice are in reach")


def lattice_corners(patient: Patient) -> dict[tuple[int, int], tuple[float, float]]:
    """Return robot x and y of the four corners of the widest world."""
    lattice = patient.profile.lattice
    to_robot = LatticeMap(
        step_mm=lattice.step_mm,
        angle_deg=lattice.angle_deg,
        origin_x_mm=lattice.origin_mm[0],
        origin_y_mm=lattice.origin_mm[1],
    ).to_robot
    columns, rows = patient.lattice
    corners = [(x, y) for x in (0, columns - 1) for y in (0, rows - 1)]
    return {corner: to_robot(*corner) for corner in corners}


def why_unreachable(
    profile: Profile, arm: SixAxisArm, x_mm: float, y_mm: float, heights_mm: Sequence[float]
) -> str:
    """Return why the hand, pointing down, cannot be brought to a place; empty if it can."""
    for z_mm in heights_mm:
        try:
            arm.solve(Pose(x_mm, y_mm, z_mm, *_DOWN_DEG), profile.arm.posture)
        except UnreachablePose as error:
            return f"at z {z_mm:.0f} mm {error}"
    return ""
