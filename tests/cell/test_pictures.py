from __future__ import annotations

import hashlib

import numpy as np
import pytest

from cell.errors import CellError
from cell.pictures import PICTURE_NAMES, UnknownPicture, picture


def test_there_are_the_five_pictures_of_the_cell() -> None:
    assert PICTURE_NAMES == ("black", "white", "mash", "water", "forest")


@pytest.mark.parametrize("name", PICTURE_NAMES)
def test_pictures_fill_the_panel_and_cannot_be_written(name: str) -> None:
    pixels = picture(name)
    assert pixels.shape == (1080, 1920, 3)
    assert pixels.dtype == np.uint8
    assert not pixels.flags.writeable


def test_black_and_white_are_plain() -> None:
    assert picture("black").max() == 0
    assert picture("white").min() == 255


@pytest.mark.parametrize("name", ["mash", "water", "forest"])
def test_made_pictures_have_contrast_and_are_alike_every_time(name: str) -> None:
    pixels = picture(name)
    assert pixels.astype(float).std() > 25
    digest = hashlib.sha256(pixels.tobytes()).hexdigest()
    picture.cache_clear()
    assert hashlib.sha256(picture(name).tobytes()).hexdigest() == digest


def test_water_is_blue_and_forest_is_green_where_it_is_dark() -> None:
    red, _, blue = picture("water").reshape(-1, 3).mean(axis=0)
    assert blue > 2 * red
    trees = picture("forest")[800:].reshape(-1, 3).mean(axis=0)
    assert trees[1] > trees[0]
    assert trees[1] > trees[2]


def test_unknown_picture_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(UnknownPicture, match="no picture 'sky'; there are black, white") as caught:
        picture("sky")
    assert isinstance(caught.value, CellError)
