from __future__ import annotations

from benchmarks.messes import store
from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import LensProfile, PlaceProfile, Profile, load_profile
from cell.store import TablePlace
from cell.vision.viewpoints import mapped_cameras


def known(profile: Profile, *names: str) -> Profile:
    """Return a profile that knows lens and place of cameras as they really are."""
    cameras = dict(profile.cameras)
    for name in names:
        real = profile.twin.cameras[name]
        lens = LensProfile(
            focal_px=(real.focal_px, real.focal_px), centre_px=real.centre_px, k1=real.k1
        )
        place = PlaceProfile(position_mm=real.position_mm, rotation_deg=real.rotation_deg)
        cameras[name] = cameras[name].model_copy(update={"lens": lens, "place": place})
    return profile.model_copy(update={"cameras": cameras})


def test_the_camera_that_sees_the_playground_finest_comes_first() -> None:
    profile = load_profile("mash")
    assert list(profile.cameras)[0] == "oblique"
    assert mapped_cameras(known(profile, "oblique", "top")) == ("top", "oblique")
    assert mapped_cameras(known(profile, "oblique")) == ("top", "oblique")


def test_a_camera_that_nobody_mapped_is_left_out() -> None:
    profile = load_profile("mash")
    assert mapped_cameras(profile) == ("top",)
    bare = profile.cameras["top"].model_copy(update={"plane_map": None})
    blind = profile.model_copy(update={"cameras": {**profile.cameras, "top": bare}})
    assert mapped_cameras(blind) == ()


def test_blocks_close_behind_each_other_are_told_when_every_camera_is_mapped() -> None:
    profile = known(load_profile("mash"), "oblique", "top")
    cell = assemble_twin(profile, store(), seed=2, clock=SimulatedClock())
    try:
        cell.open()
        cell.deploy(7, TablePlace(x_mm=500, y_mm=0, yaw_deg=20))
        cell.deploy(13, TablePlace(x_mm=560, y_mm=60, yaw_deg=70))
        report = cell.clean_from_picture()
        assert sorted(report.home) == [7, 13]
        assert not report.left
    finally:
        cell.dispose()
