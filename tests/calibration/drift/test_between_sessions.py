"""The watchdog's check for drift: with a calibration by the screen, and with other ones."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from calibration.checks import Checks, moved_cameras
from calibration.drift.between_sessions import DriftCheck
from calibration.verdict import Grade
from cell.devices.camera import Frame
from cell.errors import DeviceError, Stopped
from cell.profile import LensProfile, PlaceProfile, Profile
from tests.calibration.drift.bumps import litter, moved_camera, with_camera
from tests.cell.twin.cameras.stage import PROFILE
from tests.cell.twin.cameras.test_patterns import PatternStage

MOVED_MM = np.array([2.0, 1.0, 0.0])


class Watch:
    """A stage with its cameras, and the hours that pass between the checks of it."""

    def __init__(self, profile: Profile, folder: Path, truth: Profile = PROFILE) -> None:
        self.profile, self.truth = profile, truth
        self.checks = Checks(folder)
        self.stage = PatternStage()
        self.hours = 0
        self.broken: Exception | None = None
        self._count = 0

    def show_pixels(self, pixels: NDArray[np.uint8], name: str) -> None:
        self._count += 1
        self.stage.show_pixels(f"{name} {self._count}", pixels)

    def grab(self, camera: str) -> Frame:
        if self.broken is not None:
            raise self.broken
        made = self.stage.camera(camera, profile=self.truth, seed=self._count)
        return made.grab()

    def check(self) -> tuple[str, str]:
        self.hours += 2
        at = datetime(2026, 3, 1, tzinfo=UTC) + timedelta(hours=self.hours)
        told = DriftCheck(self.profile, (), self.checks, lambda: at).look(self)
        return told.verdict, told.text

    def grade(self) -> Grade | None:
        last = self.checks.read().last
        assert last is not None
        assert last.at.hour == self.hours
        return last.cameras["top"].grade

    def knock(self) -> None:
        moved = moved_camera(PROFILE.twin.cameras["top"], MOVED_MM, np.zeros(3))
        self.truth = with_camera(self.truth, "top", moved)


def with_lens_and_place(shift_mm: float = 0.0) -> Profile:
    """Return a profile that knows where the top camera is, to some millimetres."""
    true = PROFILE.twin.cameras["top"]
    x, y, z = true.position_mm
    lens = LensProfile(
        focal_px=(true.focal_px, true.focal_px), centre_px=true.centre_px, k1=true.k1, k2=true.k2
    )
    place = PlaceProfile(position_mm=(x + shift_mm, y, z), rotation_deg=true.rotation_deg)
    camera = PROFILE.cameras["top"].model_copy(update={"lens": lens, "place": place})
    return PROFILE.model_copy(update={"cameras": {**PROFILE.cameras, "top": camera}})


def test_a_camera_with_a_plane_map_alone_is_compared_with_its_first_check(tmp_path: Path) -> None:
    watch = Watch(PROFILE, tmp_path)
    verdict, text = watch.check()
    assert verdict == "cannot tell"
    assert "first time" in text
    assert watch.grade() is None
    watch.stage.put(*litter(np.random.default_rng(3), 0.2, PROFILE))
    assert watch.check()[0] == "holds"
    assert watch.grade() is Grade.OK
    watch.knock()
    verdict, text = watch.check()
    assert verdict == "moved"
    assert "2." in text  # the millimetres of the knock
    assert watch.grade() is Grade.BAD
    last = watch.checks.read().last
    assert set(moved_cameras(PROFILE, last)) == {"top"}
    # What was first seen stays: otherwise the next check would find all in order.
    assert watch.check()[0] == "moved"


def test_a_known_place_is_held_against_the_dots_at_once_and_closely_from_then_on(
    tmp_path: Path,
) -> None:
    watch = Watch(with_lens_and_place(0.5), tmp_path)
    assert watch.check()[0] == "holds"  # known to a millimetre only
    assert watch.check()[0] == "holds"
    nudged = moved_camera(PROFILE.twin.cameras["top"], np.array([0.8, 0, 0]), np.zeros(3))
    watch.truth = with_camera(PROFILE, "top", nudged)
    assert watch.check()[0] == "moved"


def test_a_place_that_is_wrong_from_the_beginning_is_found(tmp_path: Path) -> None:
    watch = Watch(with_lens_and_place(4.0), tmp_path)
    assert watch.check()[0] == "moved"
    assert watch.checks.read().baselines == {}


def test_a_new_calibration_is_compared_anew(tmp_path: Path) -> None:
    watch = Watch(PROFILE, tmp_path)
    watch.check()
    watch.knock()
    rows = [list(row) for row in PROFILE.cameras["top"].plane_map or ()]
    rows[0][2] += 2.0
    top = PROFILE.cameras["top"].model_copy(update={"plane_map": tuple(map(tuple, rows))})
    watch.profile = PROFILE.model_copy(update={"cameras": {**PROFILE.cameras, "top": top}})
    assert watch.check()[0] == "cannot tell"
    assert watch.check()[0] == "holds"


def test_a_camera_without_a_picture_cannot_tell_and_a_wanted_cell_is_given_back(
    tmp_path: Path,
) -> None:
    watch = Watch(PROFILE, tmp_path)
    watch.broken = DeviceError("camera top", "gives no picture")
    verdict, text = watch.check()
    assert verdict == "cannot tell"
    assert "no picture" in text
    watch.broken = Stopped("a client asks for the cell")
    with pytest.raises(Stopped):
        watch.check()


def test_nothing_is_due_where_no_camera_is_known_to_look_anywhere(tmp_path: Path) -> None:
    def due(profile: Profile) -> bool:
        return DriftCheck(profile, (), Checks(tmp_path), lambda: datetime.now(UTC)).is_due()

    assert due(PROFILE)
    blind = {
        name: camera.model_copy(update={"plane_map": None})
        for name, camera in PROFILE.cameras.items()
    }
    assert not due(PROFILE.model_copy(update={"cameras": blind}))
