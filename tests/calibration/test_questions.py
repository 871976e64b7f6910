"""Answers that cannot be are refused when they are given, by the question they belong to."""

from __future__ import annotations

import pytest

from calibration.catalogue import Site
from calibration.errors import AnswerRefused
from calibration.homography.procedure import calibrate_homography
from calibration.requests import Value
from calibration.screen.procedure import screen
from cell.profile import load_profile
from cell.store import StorePlan
from tests.calibration.playing import played, site_of

NOMINAL = load_profile("mash")
UNARMED = NOMINAL.model_copy(update={"arm": NOMINAL.arm.model_copy(update={"enabled": False})})


@pytest.mark.parametrize(
    ("key", "value"),
    [("points", 4.7), ("points", 3.0), ("points", float("inf")), ("quality", 0.0),
     ("quality", 101.0), ("quality", float("nan")), ("pixel_noise", 0.0),
     ("pixel_noise", 1e9), ("placement_noise", -1.0), ("placement_noise", 1e9)],
)  # fmt: skip
def test_a_wizard_refuses_a_figure_that_cannot_be_before_anything_is_done(
    key: str, value: Value
) -> None:
    with pytest.raises(AnswerRefused, match=f"^{key}: "):
        played(calibrate_homography(site_of(UNARMED)), {"way": "clicked", key: value})


def test_what_the_twin_hides_is_not_the_default_of_a_question() -> None:
    twin = NOMINAL.twin.model_copy(update={"placement_scatter_mm": 7.0})
    asked = calibrate_homography(site_of(NOMINAL.model_copy(update={"twin": twin})))
    defaults = {}
    request = next(asked)
    while getattr(request, "key", "") != "placement_noise":
        key = getattr(request, "key", "")
        if key:
            defaults[key] = request
        request = asked.send(getattr(request, "default", ()))
    assert getattr(request, "default", None) == 0.3


@pytest.mark.parametrize("value", [1.0, 2.5, 10.0])
def test_a_number_of_places_that_cannot_be_is_refused_before_any_picture(value: float) -> None:
    plan = StorePlan(())
    site = Site(profile=NOMINAL, plan=plan, current=())
    with pytest.raises(AnswerRefused, match="^blocks: a whole number from 2 to 9"):
        played(screen(site), {"way": "blocks", "blocks": value})
