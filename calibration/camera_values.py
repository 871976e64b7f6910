"""Lens and place of a camera in the form in which records set them in the profile."""

from __future__ import annotations

from pydantic import JsonValue

from cell.geometry import LensModel, Pose


def lens_value(lens: LensModel) -> dict[str, JsonValue]:
    """Return a lens as the profile's table `cameras.X.lens` has it."""
    return {
        "focal_px": [lens.focal_u_px, lens.focal_v_px],
        "centre_px": [lens.centre_u_px, lens.centre_v_px],
        "k1": lens.k1,
        "k2": lens.k2,
        "p1": lens.p1,
        "p2": lens.p2,
        "k3": lens.k3,
    }


def place_value(pose: Pose) -> dict[str, JsonValue]:
    """Return where a camera is as the tables `cameras.X.place` and `cameras.X.mount` have it."""
    return {
        "position_mm": [pose.x_mm, pose.y_mm, pose.z_mm],
        "rotation_deg": [pose.a_deg, pose.b_deg, pose.c_deg],
    }
