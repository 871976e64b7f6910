from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from cell.devices.camera import MODES, Camera
from cell.errors import DeviceError
from cell.geometry import Pose, Transform
from cell.twin.cameras import TwinCamera
from cell.twin.cameras.optics import lens_for_mode
from cell.twin.cameras.painter import Eye
from tests.cell.twin.cameras.stage import (
    ARM,
    FULL,
    PROFILE,
    QUIET,
    SURFACE_MM,
    Stage,
    block,
    joints_at,
    mean_at,
)

NAMES = ("top", "oblique", "gripper")


def eye_of(name: str, joints_deg: tuple[float, ...] = PROFILE.arm.rest_deg) -> Eye:
    placing = PROFILE.twin.cameras[name]
    mount = Transform.from_pose(Pose(*placing.position_mm, *placing.rotation_deg))
    if placing.mount == "flange":
        points, tool = ARM.chain(joints_deg)
        flange = np.eye(4)
        flange[:3, :3] = np.array(tool).reshape(3, 4)[:, :3]
        flange[:3, 3] = points[5]
        mount = Transform(flange) @ mount
    return Eye(lens_for_mode(placing, FULL), mount)


def pixel_of(eye: Eye, x_mm: float, y_mm: float, z_mm: float) -> tuple[float, float]:
    u_px, v_px = eye.pixels(np.array([[x_mm, y_mm, z_mm]]))[0]
    return float(u_px), float(v_px)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("mode", MODES, ids=lambda mode: str(mode.number))
def test_every_mode_gives_its_picture_size(name: str, mode: object) -> None:
    chosen = next(m for m in MODES if m is mode)
    frame = Stage().camera(name, chosen).grab()
    assert frame.pixels.shape == (chosen.height_px, chosen.width_px, 3)
    assert frame.pixels.dtype == np.uint8
    assert not frame.pixels.flags.writeable


@pytest.mark.parametrize("name", NAMES)
def test_small_modes_show_what_the_full_one_shows(name: str) -> None:
    stage = Stage().put(block("cube", "red", 600, -150)).show("forest")
    stage.move(joints_at(560, -100, 200))
    full = stage.camera(name, MODES[3], profile=QUIET).grab().pixels
    small = stage.camera(name, MODES[0], profile=QUIET).grab().pixels
    shrunk = cv2.resize(full, (640, 480), interpolation=cv2.INTER_AREA)
    difference = np.abs(shrunk.astype(int) - small.astype(int))
    assert difference.mean() < 4.0


def test_opening_names_model_and_guid() -> None:
    camera: Camera = Stage().camera("top")
    assert camera.open(FULL) == "Flea2 FL2G-13S2C 00B09D01009A7C42"


def test_closed_camera_refuses_to_grab() -> None:
    camera = Stage().camera("top")
    camera.close()
    camera.close()
    with pytest.raises(DeviceError, match="not open"):
        camera.grab()


def test_impossible_setting_is_refused_and_changes_nothing() -> None:
    camera = Stage().camera("top")
    before = camera.settings()
    with pytest.raises(DeviceError, match="must be positive"):
        camera.configure(replace(before, shutter_ms=0.0))
    assert camera.settings() == before


def test_same_frame_comes_back_while_nothing_changes() -> None:
    stage = Stage()
    camera = stage.camera("top")
    first = camera.grab()
    stage.clock.sleep(5.0)
    assert camera.grab() is first
    camera.configure(camera.settings())
    assert camera.grab() is first


def test_change_of_scene_or_settings_takes_a_new_frame() -> None:
    stage = Stage()
    camera = stage.camera("top")
    first = camera.grab()
    stage.clock.sleep(5.0)
    stage.put(block("cube", "red", 600, -150))
    second = camera.grab()
    assert (first.number, second.number) == (1, 2)
    assert second.time_s == 5.0
    camera.configure(replace(camera.settings(), gain_db=0.0))
    assert camera.grab().number == 3
    assert camera.grab().settings.gain_db == 0.0


def test_frame_given_out_is_never_drawn_into_again() -> None:
    stage = Stage()
    for name in NAMES:
        camera = stage.camera(name)
        frame = camera.grab()
        kept = frame.pixels.copy()
        stage.move(joints_at(600, -150, 150)).show("water")
        camera.grab()
        np.testing.assert_array_equal(frame.pixels, kept)
        stage.move(PROFILE.arm.rest_deg).show("black")


@pytest.mark.parametrize("name", NAMES)
def test_same_commands_give_the_same_pixels_on_one_thread_and_on_two(name: str) -> None:
    def run(threads: int) -> list[bytes]:
        cv2.setNumThreads(threads)
        stage = Stage().put(block("bridge", "green", 600, -150)).show("mash")
        camera = stage.camera(name)
        pictures = [camera.grab().pixels.tobytes()]
        for y_mm in (-200.0, -100.0):
            stage.move(joints_at(600, y_mm, 180))
            pictures.append(camera.grab().pixels.tobytes())
        return pictures

    before = cv2.getNumThreads()
    try:
        assert run(1) == run(2)
    finally:
        cv2.setNumThreads(before)


def test_reopening_starts_the_same_sequence_again() -> None:
    stage = Stage()
    camera = stage.camera("oblique")
    first = camera.grab()
    stage.move(joints_at(600, -150, 180))
    camera.grab()
    stage.move(PROFILE.arm.rest_deg)
    camera.open(FULL)
    again = camera.grab()
    assert again.number == 1
    np.testing.assert_array_equal(again.pixels, first.pixels)


def test_another_seed_gives_other_noise_on_the_same_scene() -> None:
    stage = Stage()
    first = stage.camera("top", seed=1).grab().pixels.astype(int)
    second = stage.camera("top", seed=2).grab().pixels.astype(int)
    assert 1.0 < np.abs(first - second).mean() < 3.0


def test_noise_grows_with_the_gain() -> None:
    def deviation(gain_db: float) -> float:
        stage = Stage().show(None)
        noisy, quiet = stage.camera("top"), stage.camera("top", profile=QUIET)
        for camera in (noisy, quiet):
            camera.configure(replace(camera.settings(), gain_db=gain_db, shutter_ms=8.0))
        difference = noisy.grab().pixels[200:800].astype(int) - quiet.grab().pixels[200:800]
        return float(difference.std())

    default_db = PROFILE.cameras["top"].settings.gain_db
    assert deviation(default_db) == pytest.approx(PROFILE.twin.cameras["top"].noise, rel=0.05)
    assert deviation(default_db + 6.02) == pytest.approx(2 * deviation(default_db), rel=0.05)


@pytest.mark.parametrize("name", NAMES)
def test_doubled_shutter_doubles_every_unclipped_pixel(name: str) -> None:
    stage = Stage().put(block("cube", "blue", 600, -150)).show("black")
    stage.move(joints_at(520, -150, 220))
    camera = stage.camera(name, profile=QUIET)
    default = camera.grab().pixels.astype(int)
    camera.configure(replace(camera.settings(), shutter_ms=2 * camera.settings().shutter_ms))
    doubled = camera.grab().pixels.astype(int)
    fair = (default > 20) & (default < 120)
    assert fair.mean() > 0.15
    # Only pixels on an edge of something that clips now are less than twice as bright.
    is_double = np.abs(doubled - 2 * default)[fair] <= 5
    assert is_double.mean() > 0.97


def test_white_balance_changes_its_channel_alone() -> None:
    stage = Stage().show("black")
    camera = stage.camera("top", profile=QUIET)
    before = camera.grab().pixels.astype(int)
    settings = camera.settings()
    camera.configure(replace(settings, white_balance_red=settings.white_balance_red // 2))
    after = camera.grab().pixels.astype(int)
    np.testing.assert_array_equal(before[..., 1:], after[..., 1:])
    assert after[..., 0].mean() == pytest.approx(before[..., 0].mean() / 2, rel=0.03)


def test_sharpness_steepens_edges_and_keeps_plain_areas() -> None:
    stage = Stage().put(block("cube", "natural", 600, -150)).show("black")
    camera = stage.camera("top", profile=QUIET)
    neutral = camera.grab().pixels.astype(int)
    camera.configure(replace(camera.settings(), sharpness=2048))
    sharp = camera.grab().pixels.astype(int)
    assert np.abs(np.diff(sharp, axis=1)).max() > np.abs(np.diff(neutral, axis=1)).max() + 20
    assert abs(sharp.mean() - neutral.mean()) < 1.0


@pytest.mark.parametrize("name", NAMES)
def test_lights_off_leaves_the_screen_alone(name: str) -> None:
    stage = Stage().put(block("cube", "natural", 600, -150))
    stage.move(joints_at(600, -60, 300))
    camera = stage.camera(name, profile=QUIET)
    stage.show(None, are_lights_on=False)
    dark = camera.grab().pixels
    assert dark.max() < 12
    stage.show("white", are_lights_on=False)
    shown = camera.grab().pixels
    assert (shown.min(axis=2) > 200).mean() > 0.08
    eye = eye_of(name, stage.joints_deg)
    assert mean_at(shown, *pixel_of(eye, 600, -150, 71.5), 3).max() < 40


@pytest.mark.parametrize("picture", ["white", "mash", "water", "forest"])
def test_picture_on_the_screen_is_seen_by_every_camera(picture: str) -> None:
    stage = Stage().move(joints_at(600, -150, 400))
    for name in NAMES:
        camera = stage.camera(name, MODES[0], profile=QUIET)
        stage.show("black")
        black = camera.grab().pixels.astype(int)
        stage.show(picture)
        shown = camera.grab().pixels.astype(int)
        assert (np.abs(shown - black).max(axis=2) > 20).mean() > 0.05


def test_screen_s_corner_lies_where_the_profile_says() -> None:
    stage = Stage()
    camera = stage.camera("top", profile=QUIET)
    stage.show("black")
    black = camera.grab().pixels.astype(int)
    stage.show("white")
    white = camera.grab().pixels.astype(int)
    is_lit = (white - black).max(axis=2) > 100
    display = PROFILE.display
    left, right = -370.0, display.corner_y_mm + display.width_px * display.pixel_mm
    upper = display.corner_x_mm
    lower = display.corner_x_mm + display.height_px * display.pixel_mm
    eye = eye_of("top")
    for x_mm, y_mm, inwards in (
        (upper, left, (1, 0)), (upper, right, (1, -1)), (lower, right, (-1, -1)),
        (lower, left, (-1, 0)), (500.0, right, (0, -1)),
    ):  # fmt: skip
        for step_mm, expected in ((3.0, True), (-3.0, False)):
            dx, dy = (step_mm * k for k in inwards)
            u_px, v_px = pixel_of(eye, x_mm + dx, y_mm + dy, SURFACE_MM)
            assert is_lit[round(v_px), round(u_px)] == expected


@pytest.mark.parametrize("name", ["top", "oblique"])
def test_block_is_where_its_projection_says(name: str) -> None:
    stage = Stage()
    camera = stage.camera(name, profile=QUIET)
    empty = camera.grab().pixels.astype(int)
    for x_mm, y_mm in ((710, -265), (490, -45), (600, -150)):
        stage.put(block("cube", "yellow", x_mm, y_mm))
        laid = camera.grab().pixels.astype(int)
        rows, columns = np.nonzero(np.abs(laid - empty).max(axis=2) > 60)
        u_px, v_px = pixel_of(eye_of(name), x_mm, y_mm, SURFACE_MM + 20)
        assert columns.mean() == pytest.approx(u_px, abs=6)
        assert rows.mean() == pytest.approx(v_px, abs=9)


@pytest.mark.parametrize("name", ["top", "oblique"])
def test_arm_is_drawn_along_its_links(name: str) -> None:
    stage = Stage()
    camera = stage.camera(name, profile=QUIET)
    aside = camera.grab().pixels.astype(int)
    joints = joints_at(600, -150, 140)
    stage.move(joints)
    over = camera.grab().pixels.astype(int)
    changed = np.abs(over - aside).max(axis=2) > 15
    eye = eye_of(name)
    _, _, _, axis, wrist, flange, tool = ARM.link_points_mm(joints)
    for start, end in ((axis, wrist), (wrist, flange), (flange, tool)):
        middle = [(a + b) / 2 for a, b in zip(start, end, strict=True)]
        u_px, v_px = pixel_of(eye, *middle)
        if 0 <= u_px < 1280 and 0 <= v_px < 960:
            assert changed[round(v_px), round(u_px)]


def test_arm_at_rest_leaves_the_playground_free() -> None:
    stage = Stage().show("white")
    picture = stage.camera("top", profile=QUIET).grab().pixels
    assert (picture[70:860, :1180].min(axis=2) > 200).all()


def test_arm_hides_a_block_below_it_from_the_top_camera() -> None:
    stage = Stage().put(block("cube", "red", 520, -60))
    camera = stage.camera("top", profile=QUIET)
    u_px, v_px = pixel_of(eye_of("top"), 520, -60, 71.5)
    free = mean_at(camera.grab().pixels, u_px, v_px)
    stage.move(joints_at(520, -60, 200))
    hidden = mean_at(camera.grab().pixels, u_px, v_px)
    assert free[0] > 2 * free[1]
    assert hidden[0] < 1.5 * hidden[1]


def test_gripper_camera_sees_fingertips_and_what_lies_between_them() -> None:
    x_mm, y_mm, z_mm = 600.0, -150.0, 55.0
    joints = joints_at(x_mm, y_mm, z_mm)
    stage = Stage().put(block("cube", "red", x_mm, y_mm)).move(joints, 33.0)
    picture = stage.camera("gripper", profile=QUIET).grab().pixels
    eye = eye_of("gripper", joints)
    red, green, _ = mean_at(picture, *pixel_of(eye, x_mm, y_mm, 71.5), 3)
    assert red > 2 * green
    for side in (-1, 1):
        u_px, v_px = pixel_of(eye, x_mm, y_mm + side * 20.5, z_mm - 5)
        assert 0 < u_px < 1280
        assert 0 < v_px < 960
        assert np.ptp(mean_at(picture, u_px, v_px, 2)) < 25


def test_opening_the_fingers_moves_them_apart_in_the_picture() -> None:
    joints = joints_at(600, -150, 150)
    stage = Stage().move(joints, 20.0)
    camera = stage.camera("gripper", profile=QUIET)
    narrow = camera.grab().pixels.astype(int)
    stage.move(joints, 60.0)
    wide = camera.grab().pixels.astype(int)
    changed = np.abs(wide - narrow).max(axis=2) > 8
    eye = eye_of("gripper", joints)
    for side in (-1, 1):
        u_px, v_px = pixel_of(eye, 600, -150 + side * 34, 145)
        assert changed[round(v_px), round(u_px)]


@pytest.mark.parametrize("name", ["oblique", "gripper"])
def test_gripped_block_moves_with_the_arm(name: str) -> None:
    stage = Stage().show("black")
    camera = stage.camera(name, profile=QUIET)
    for y_mm in (-250.0, -60.0):
        joints = joints_at(640, y_mm, 105)
        held = block("bridge", "yellow", 640, y_mm, z_mm=105 - 16.5)
        stage.put(held).move(joints, 33.0)
        end = 687 if name == "oblique" else 593
        place = pixel_of(eye_of(name, joints), end, y_mm, 105 + 16.5)
        red, _, blue = mean_at(camera.grab().pixels, *place, 2)
        assert red > 2 * blue


def test_shadow_falls_beside_a_block_on_the_sheet() -> None:
    stage = Stage()
    camera = stage.camera("oblique", profile=QUIET)
    empty = camera.grab().pixels.astype(int)
    stage.put(block("cube", "natural", -85, 550))
    laid = camera.grab().pixels.astype(int)
    u_px, v_px = pixel_of(eye_of("oblique"), -85 - 3, 550 + 22, SURFACE_MM)
    near = mean_at(laid.astype(np.uint8), u_px, v_px, 1) / mean_at(
        empty.astype(np.uint8), u_px, v_px, 1
    )
    assert near.max() < 0.95


def test_corners_are_darker_than_the_centre_by_the_vignetting() -> None:
    strong = QUIET.twin.cameras["top"].model_copy(update={"vignetting": 0.4})
    cameras = {**QUIET.twin.cameras, "top": strong}
    profile = QUIET.model_copy(update={"twin": QUIET.twin.model_copy(update={"cameras": cameras})})
    stage = Stage().show(None)
    weak_pixels = stage.camera("top", profile=QUIET).grab().pixels[900:].astype(float)
    strong_pixels = stage.camera("top", profile=profile).grab().pixels[900:].astype(float)
    ratio = strong_pixels[:, :200].mean() / weak_pixels[:, :200].mean()
    assert 0.6 < ratio < 0.75


def test_unknown_camera_name_is_an_error_at_once() -> None:
    with pytest.raises(KeyError):
        TwinCamera("ceiling", PROFILE, scene=Stage(), arm=ARM, clock=Stage().clock, seed=1)
