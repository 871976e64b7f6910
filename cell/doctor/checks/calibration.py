"""The plane maps of the profile: there, of this camera, young, and possible."""

from __future__ import annotations

import math
from datetime import date

from cell.doctor.checks.profile import lattice_corners
from cell.doctor.environment import Environment
from cell.doctor.notes import Notes
from cell.doctor.patient import Patient
from cell.geometry import PlaneMap
from cell.profile import CameraProfile

OLD_DAYS = 366
_PICTURE_PX = (1280, 960)
_LEAST_MM_A_PIXEL, _MOST_MM_A_PIXEL = 0.1, 3.0


def check_calibration(patient: Patient, environment: Environment, notes: Notes) -> None:
    """Look at every plane map of the profile."""
    mapped = [(n, c) for n, c in patient.profile.cameras.items() if c.plane_map is not None]
    if not mapped:
        problem = "no camera of the profile is mapped to the table"
        notes.find("plane-map-missing", "calibration", problem, "0 cameras have a plane_map")
    for name, camera in mapped:
        component = f"camera {name}"
        _check_owner(component, camera, notes)
        _check_age(component, camera.plane_map_date, environment.now().date(), notes)
        _check_map(patient, component, camera, notes)


def _check_owner(component: str, camera: CameraProfile, notes: Notes) -> None:
    if not camera.plane_map_guid:
        notes.skip(component, "owner of the plane map", "plane_map_guid is not noted")
    elif camera.plane_map_guid != camera.guid:
        problem = "the plane map was measured with another camera"
        fact = f"map of {camera.plane_map_guid}, camera {camera.guid}"
        notes.find("plane-map-other-camera", component, problem, fact)
    else:
        notes.fine(component, "the plane map was measured with this camera")


def _check_age(component: str, measured: date | None, today: date, notes: Notes) -> None:
    if measured is None:
        notes.skip(component, "age of the plane map", "plane_map_date is not noted")
        return
    days = (today - measured).days
    if days > OLD_DAYS:
        problem = f"the plane map is {days} days old"
        notes.find("plane-map-old", component, problem, f"measured on {measured.isoformat()}")
    elif days < 0:
        problem = "the plane map's date lies in the future"
        notes.find("plane-map-old", component, problem, f"measured on {measured.isoformat()}")
    else:
        notes.fine(component, f"the plane map is {days} days old")


def _check_map(patient: Patient, component: str, camera: CameraProfile, notes: Notes) -> None:
    if camera.plane_map is None:
        return
    problem, fact = _why_implausible(patient, PlaneMap(camera.plane_map))
    if problem:
        notes.find("plane-map-implausible", component, problem, fact)
    else:
        notes.fine(component, "the plane map brings the whole lattice into the picture")


def _why_implausible(patient: Patient, plane_map: PlaneMap) -> tuple[str, str]:
    """Return what is impossible about a map, and the figure; empty texts for a possible one."""
    width_px, height_px = _PICTURE_PX
    try:
        for (x, y), (x_mm, y_mm) in lattice_corners(patient).items():
            u, v = plane_map.to_picture(x_mm, y_mm)
            if not (0 <= u < width_px and 0 <= v < height_px):
                problem = f"the plane map puts lattice point ({x}, {y}) outside the picture"
                return problem, f"({x_mm:.0f}, {y_mm:.0f}) mm comes to pixel ({u:.0f}, {v:.0f})"
        for u, v in ((100, 100), (width_px / 2, height_px / 2), (width_px - 100, height_px - 100)):
            here, beside = plane_map.to_robot(u, v), plane_map.to_robot(u + 1, v)
            size_mm = math.dist(here, beside)
            if not _LEAST_MM_A_PIXEL <= size_mm <= _MOST_MM_A_PIXEL:
                problem = "the plane map makes pixels of an impossible size"
                return problem, f"{size_mm:.3g} mm a pixel at ({u:.0f}, {v:.0f})"
    except (ValueError, ZeroDivisionError) as error:
        return "the plane map has no inverse", str(error)
    return "", ""
