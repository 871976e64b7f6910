"""Cameras: each its own number and identity, a map that fits it, and a twin."""

from __future__ import annotations

from collections.abc import Iterator

from cell.profile.cell import CellProfile, Profile
from cell.profile.rules.problem import PlaygroundRule, Problem, Rule


def _camera_identities(profile: CellProfile) -> Iterator[Problem]:
    """No two cameras have the same number or GUID."""
    numbers: dict[int, str] = {}
    guids: dict[str, str] = {}
    for name, camera in profile.cameras.items():
        first = numbers.setdefault(camera.number, name)
        if first != name:
            yield Problem(
                ("cameras", name, "number"),
                f"the cameras {first} and {name} both have number {camera.number}",
                "give every camera the number on its label",
                other=("cameras", first, "number"),
            )
        first = guids.setdefault(camera.guid.casefold(), name)
        if first != name:
            yield Problem(
                ("cameras", name, "guid"),
                f"the cameras {first} and {name} both have the GUID {camera.guid}",
                "every camera has its own; `cell camera list` shows those that are connected",
                other=("cameras", first, "guid"),
            )


def _plane_maps(profile: CellProfile) -> Iterator[Problem]:
    """A plane map can be inverted. Warning: not noted with which camera, or with another one."""
    for name, camera in profile.cameras.items():
        rows = camera.plane_map
        at = ("cameras", name, "plane_map")
        if rows is None:
            continue
        if abs(_determinant(rows)) < 1e-12:
            yield Problem(
                at,
                f"the plane map of camera {name} takes the whole picture to one line: its "
                "determinant is 0",
                "measure it again, or leave it out",
            )
        if camera.plane_map_guid and camera.plane_map_guid.casefold() != camera.guid.casefold():
            yield Problem(
                ("cameras", name, "plane_map_guid"),
                f"the plane map of camera {name} was measured with the camera "
                f"{camera.plane_map_guid}, and {camera.guid} is in its place now",
                "measure the plane map again",
                other=("cameras", name, "guid"),
                severity="warning",
            )
        elif not camera.plane_map_guid:
            yield Problem(
                at,
                f"it is not noted with which camera the plane map of {name} was measured",
                "add plane_map_guid, so that an exchanged camera is noticed",
                severity="warning",
            )


def _determinant(m: tuple[tuple[float, float, float], ...]) -> float:
    return (
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    )


def _camera_twins(profile: Profile) -> Iterator[Problem]:
    """Every camera has a twin in `twin.cameras`. Warning: a twin without a camera."""
    for name in profile.cameras:
        if name not in profile.twin.cameras:
            yield Problem(
                ("cameras", name),
                f"the camera {name} has no twin: [twin.cameras.{name}] is missing",
                "say where its twin stands, with mount, position_mm, rotation_deg, focal_px and "
                "centre_px",
                other=("twin",),
            )
    for name in profile.twin.cameras:
        if name not in profile.cameras:
            yield Problem(
                ("twin", "cameras", name),
                f"the twin's camera {name} is not used: there is no [cameras.{name}]",
                severity="warning",
            )


CAMERA_RULES = (Rule(("cameras",), _camera_identities), Rule(("cameras",), _plane_maps))
CAMERA_TWIN_RULES = (PlaygroundRule(("cameras", "twin"), _camera_twins),)
