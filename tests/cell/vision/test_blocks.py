from __future__ import annotations

import numpy as np
import pytest

from cell.errors import VisionError
from cell.geometry import PlaneMap
from cell.vision import RecognitionSettings, find_blocks, locate
from tests.cell.vision.shapes import GREEN, RED, disc, pictures, rectangle

MAP = PlaneMap(((0.0, 0.58, 222.0), (0.58, 0.0, -375.0), (0.0, 0.0, 1.0)))


def test_cube_cylinder_and_bridge_are_told_apart_and_placed() -> None:
    found = find_blocks(
        *pictures(
            (rectangle(200.3, 200.6, 27.5, 27.5), RED),
            (disc(400.0, 400.0, 27.5), GREEN),
            (rectangle(700.0, 600.0, 86.5, 27.7), RED),
        )
    )
    assert [(seen.kind, seen.colour) for seen in found] == [
        ("cube", "red"),
        ("cylinder", "green"),
        ("bridge", "red"),
    ]
    assert (found[0].u_px, found[0].v_px) == pytest.approx((200.3, 200.6), abs=0.3)
    place = locate(found[1], MAP)
    assert (place.x_mm, place.y_mm) == pytest.approx((222 + 0.58 * 400, -375 + 0.58 * 400), abs=0.1)


@pytest.mark.parametrize("turn_deg", [0.0, 3.0, 15.0, 30.0, 44.0, -20.0])
def test_square_s_circularity_hardly_depends_on_its_turn(turn_deg: float) -> None:
    (seen,) = find_blocks(*pictures((rectangle(500.4, 400.2, 27.5, 27.5, turn_deg), RED)))
    assert seen.circularity == pytest.approx(np.pi / 4, rel=0.04)
    assert (seen.yaw_px_deg - turn_deg + 45) % 90 - 45 == pytest.approx(0.0, abs=0.7)


@pytest.mark.parametrize("turn_deg", [0.0, 35.0, 80.0, -60.0])
def test_bridge_tells_the_direction_of_its_length(turn_deg: float) -> None:
    (seen,) = find_blocks(*pictures((rectangle(500.4, 400.2, 86.5, 27.7, turn_deg), RED)))
    assert seen.kind == "bridge"
    assert seen.yaw_px_deg == pytest.approx(turn_deg, abs=0.3)


def test_disc_is_as_round_as_can_be_and_not_rounder() -> None:
    (seen,) = find_blocks(*pictures((disc(500.4, 400.2, 27.5), GREEN)))
    assert 0.97 < seen.circularity <= 1.0


def test_paint_outside_the_table_has_no_colour() -> None:
    (seen,) = find_blocks(*pictures((disc(500.0, 400.0, 27.5), (140.0, 60.0, 140.0))))
    assert (seen.kind, seen.colour) == ("cylinder", None)


def test_shape_outside_the_table_has_no_kind() -> None:
    (seen,) = find_blocks(*pictures((rectangle(500.0, 400.0, 60.0, 20.0), RED)))
    assert (seen.kind, seen.colour) == (None, "red")


def test_small_specks_are_dropped() -> None:
    assert find_blocks(*pictures((disc(500.0, 400.0, 7.0), RED))) == ()


@pytest.mark.parametrize("v_px", [60.0, 869.0])
def test_block_cut_by_the_crop_is_left_out(v_px: float) -> None:
    assert find_blocks(*pictures((rectangle(500.0, v_px, 27.5, 27.5), RED))) == ()


def test_block_is_seen_beside_an_arm_that_reaches_in() -> None:
    arm = (rectangle(900.0, 100.0, 80.0, 300.0), (120.0, 120.0, 120.0))
    (seen,) = find_blocks(*pictures(arm, (disc(400.0, 400.0, 27.5), GREEN)))
    assert seen.kind == "cylinder"


def test_dark_screen_is_refused_with_what_to_do() -> None:
    with pytest.raises(VisionError, match="switch the screen on"):
        find_blocks(*pictures((disc(400.0, 400.0, 27.5), GREEN), lit=20.0))


def test_lights_off_are_told() -> None:
    with pytest.raises(VisionError, match="lights are off"):
        find_blocks(*pictures((disc(400.0, 400.0, 27.5), GREEN), lamps=0.05))


def test_picture_of_another_size_is_refused() -> None:
    white, black = pictures()
    with pytest.raises(VisionError, match="1280 x 960"):
        find_blocks(white[::2], black[::2])
    with pytest.raises(VisionError, match="black screen"):
        find_blocks(white, black[..., 0])


def test_noise_does_not_change_what_is_found() -> None:
    generator = np.random.default_rng(9)
    noisy = [
        np.clip(p + generator.normal(0, 2.0, p.shape), 0, 255).astype(np.uint8)
        for p in pictures((rectangle(500.4, 400.2, 27.5, 27.5, 20.0), RED))
    ]
    (seen,) = find_blocks(noisy[0], noisy[1])
    assert (seen.kind, seen.colour) == ("cube", "red")
    assert (seen.u_px, seen.v_px) == pytest.approx((500.4, 400.2), abs=0.2)


@pytest.mark.parametrize(
    "wrong", [{"first_row": 900}, {"threshold_share": 0.0}, {"least_area_px": 0}, {"edge_px": -1}]
)
def test_settings_that_cannot_be_are_refused(wrong: dict[str, int]) -> None:
    values: dict[str, float] = {**wrong}
    with pytest.raises(ValueError, match="must|rows|least"):
        RecognitionSettings(
            first_row=int(values.get("first_row", 60)),
            threshold_share=values.get("threshold_share", 0.15),
            least_area_px=int(values.get("least_area_px", 200)),
            edge_px=int(values.get("edge_px", 2)),
        )
