from __future__ import annotations

import numpy as np
import pytest

from cell.vision.colour_model import (
    label_index,
    measure_colour,
    measure_face,
    reference_colours,
)

PAINT = {
    "blue": (37.0, 57.0, 110.0),
    "natural": (168.0, 148.0, 121.0),
    "yellow": (203.0, 176.0, 60.0),
    "green": (88.0, 135.0, 60.0),
    "red": (188.0, 60.0, 47.0),
}


@pytest.mark.parametrize("level", [0.7, 0.85, 1.0, 1.15, 1.3])
@pytest.mark.parametrize("colour", PAINT)
def test_colour_does_not_depend_on_the_light(colour: str, level: float) -> None:
    red, green, blue = (min(255.0, level * channel) for channel in PAINT[colour])
    guess = reference_colours().classify((red, green, blue))
    assert guess.colour == colour
    assert guess.probability > 0.98
    told = reference_colours().light_of((red, green, blue), colour)
    assert told == pytest.approx(level, rel=0.06)


def test_colour_between_two_is_not_guessed_and_one_far_from_all_is_none() -> None:
    model = reference_colours()
    between = model.classify((155.0, 155.0, 62.0))
    assert between.colour is None
    assert between.reason.startswith(("colour between", "no known colour"))
    violet = model.classify((140.0, 60.0, 140.0))
    assert violet.colour is None
    assert violet.reason.startswith("no known colour")


def test_margins_between_all_colours_are_positive_and_symmetric() -> None:
    model = reference_colours()
    for first in model.colours:
        for second in model.colours:
            margin = model.margin(first, second)
            assert margin == pytest.approx(model.margin(second, first))
            assert (margin > 1.0) == (first != second)


def test_labels_of_pixels_agree_with_the_classes() -> None:
    model = reference_colours()
    picture = np.array([[PAINT[c] for c in PAINT]], np.uint8)
    labels = model.label_table[label_index(picture)][0]
    assert [model.colours[number - 1] for number in labels] == list(PAINT)
    white = model.label_table[label_index(np.full((1, 1, 3), 255, np.uint8))]
    assert white[0, 0] == 0


def test_a_face_is_measured_inside_its_edge() -> None:
    picture = np.zeros((100, 100, 3), np.uint8)
    picture[30:70, 30:70] = (10, 200, 30)
    outline = np.array([(30.0, 30.0), (69.0, 30.0), (69.0, 69.0), (30.0, 69.0)])
    sample = measure_face(picture, outline)
    assert sample.mean_rgb == (10.0, 200.0, 30.0)
    assert sample.deviation_rgb == (0.0, 0.0, 0.0)
    assert sample.clipped_share == 0.0
    with pytest.raises(ValueError, match="no pixel"):
        measure_colour(picture, np.zeros((100, 100), np.uint8))
