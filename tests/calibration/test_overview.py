"""Pictures of records for people, each kind in its own way."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from pydantic import JsonValue

from calibration.archive import Archive
from calibration.errors import CalibrationError
from calibration.overview import overview_of
from calibration.pictures import Pixels, digest_of, encode_png
from calibration.record import CalibrationRecord, Sample
from cell.vision.boards import Board
from tests.calibration.records import a_record

BOARD = Board(kind="chessboard", columns=8, rows=6, square_mm=25.0)
GREY = np.full((960, 1280, 3), 80, np.uint8)
PINK = (255, 0, 160)
"""What arrows of residuals are drawn in."""


def kept(
    tmp_path: Path, kind: str, samples: list[Sample], pictures: list[Pixels],
    details: dict[str, JsonValue] | None = None,
) -> tuple[CalibrationRecord, Archive]:  # fmt: skip
    archive = Archive(tmp_path)
    record = a_record(kind=kind).model_copy(
        update={"samples": tuple(samples), "details": details or {}}
    )
    archive.keep(record, {digest_of(one): encode_png(one) for one in pictures})
    return record, archive


def pink(picture: Pixels) -> np.ndarray:
    """Return columns and rows of arrows, below the title."""
    rows, columns = np.nonzero((picture[34:] == PINK).all(axis=2))
    return np.stack([columns, rows], axis=1)


def pairs(unit: str) -> list[Sample]:
    """Pairs of robot points and pixels 2 px a mm, x to the right, y up; one is 3 mm off in y."""
    places = [(300.0, -100.0), (500.0, -100.0), (300.0, 100.0), (500.0, 100.0)]
    samples = []
    for index, (x, y) in enumerate(places):
        off = (0.0, 3.0 if index == 0 else 0.0)
        samples.append(
            Sample(
                label=f"pair {index + 1}", given=(x, y), measured=(2.0 * x, 500.0 - 2.0 * y),
                residual=off, residual_mm=off[1] if unit == "mm" else 1.0,
                picture=digest_of(GREY), is_used=index < 3,
            )
        )  # fmt: skip
    return samples


@pytest.mark.parametrize(("unit", "up_px"), [("mm", -60.0), ("px", 60.0)])
def test_residuals_are_drawn_as_they_lie_in_the_picture(
    tmp_path: Path, unit: str, up_px: float
) -> None:
    picture = overview_of(*kept(tmp_path, "homography", pairs(unit), [GREY]))
    assert picture.shape == (994, 1280, 3)
    at = pink(picture) - (600.0, 700.0)
    # 3 mm are 6 px and drawn ten times; 3 px are drawn twenty times.
    near = at[(np.abs(at[:, 0]) < 15) & (np.abs(at[:, 1]) < 80)]
    assert len(near) > 60
    tip = near[np.abs(near[:, 1]).argmax(), 1]
    assert tip == pytest.approx(up_px, abs=4)


def test_a_lens_shows_where_corners_were_seen(tmp_path: Path) -> None:
    drawn = np.repeat(BOARD.draw(2.0)[..., None], 3, axis=2)
    views = []
    for left in (30, 800):
        page = np.full((960, 1280, 3), 255, np.uint8)
        page[60 : 60 + drawn.shape[0], left : left + drawn.shape[1]] = drawn
        views.append(page)
    samples = [
        Sample(label=f"view {i}", measured=(35.0, 0.2), residual=(0.2,), picture=digest_of(view))
        for i, view in enumerate(views)
    ]
    board: dict[str, JsonValue] = {
        "kind": "chessboard", "columns": 8, "rows": 6, "square_mm": 25.0,
    }  # fmt: skip
    record, archive = kept(tmp_path, "lens", samples, views, {"board": board})
    picture = overview_of(record.model_copy(update={"values": {}}), archive)
    assert len(pink(picture)) == 0
    # A lens that bends lines misses what lies straight before it.
    lens: JsonValue = {"focal_px": [1200.0, 1200.0], "centre_px": [639.5, 479.5], "k1": -0.3}
    bent = record.model_copy(update={"values": {f"cameras.{record.subject}.lens": lens}})
    assert len(pink(overview_of(bent, archive))) > 200
    assert picture.shape == (994, 1280, 3)
    upper, lower = picture[34:514], picture[514:]
    assert np.ptp(upper[:, :640].astype(int)) > 150
    # Viridis begins with a dark violet where there is nothing.
    assert np.median(lower[:, :, 1]) < 10
    assert np.median(upper[100:300, 100:400, 1]) > 60


def test_settings_are_shown_before_and_after(tmp_path: Path) -> None:
    dark, light = GREY // 2, GREY * 2
    samples = [Sample(label="before", picture=digest_of(dark)),
               Sample(label="after", picture=digest_of(light))]  # fmt: skip
    picture = overview_of(*kept(tmp_path, "camera-settings", samples, [dark, light]))
    assert np.abs(picture[100, 100].astype(int) - 40).max() <= 1
    assert np.abs(picture[100, 740].astype(int) - 160).max() <= 1


def test_recognition_shows_where_each_block_lay(tmp_path: Path) -> None:
    sample = Sample(
        label="slot 1", given=(640.0, 480.0), measured=(180.0, 44.0, 20.0, 2961.0, 0.8),
        residual=(0.7,), picture=digest_of(GREY),
    )  # fmt: skip
    picture = overview_of(*kept(tmp_path, "recognition", [sample], [GREY]))
    ring = picture[34 + 470 : 34 + 490, 630:650]
    assert int(ring[..., 1].max()) - int(ring[..., 0].max()) > 60


@pytest.mark.parametrize("kind", ["homography", "lens"])
def test_what_has_no_place_in_a_picture_is_said_to_have_none(tmp_path: Path, kind: str) -> None:
    sample = Sample(label="one", measured=(1.0, 2.0, 3.0))
    with pytest.raises(CalibrationError, match="have no places in a picture"):
        overview_of(*kept(tmp_path, kind, [sample], []))


def test_a_picture_can_be_read_again(tmp_path: Path) -> None:
    picture = overview_of(*kept(tmp_path, "homography", pairs("mm"), [GREY]))
    again = cv2.imdecode(np.frombuffer(encode_png(picture), np.uint8), cv2.IMREAD_COLOR)
    assert again is not None
    assert again.shape == picture.shape
