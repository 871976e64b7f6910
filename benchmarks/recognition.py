"""How long recognising 19 blocks at 1280 x 960 takes on one core, beside OpenCV's bare outlines."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Result, interleaved_s
from cell.vision.recognition import OnePicture, TwoPictures, recognise
from cell.vision.sight import TableSight
from tests.cell.twin.cameras.stage import PROFILE, Stage, block
from tests.cell.vision.layouts import COLOURS, KINDS, true_view

_TARGET_MS = 15.0
_COUNT = 19


def run() -> list[Result]:
    """Measure with one picture on three backgrounds, and with two pictures."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        pictures = _pictures()
        sight = TableSight.of_profile(PROFILE, "top", true_view())
        looks: dict[str, OnePicture | TwoPictures] = {
            "two pictures": TwoPictures(pictures["white"], pictures["black"])
        }
        looks |= {f"one picture on {name}": OnePicture(p) for name, p in pictures.items()}
        return [_measured(name, look, sight, pictures) for name, look in looks.items()]
    finally:
        cv2.setNumThreads(threads)


def _measured(
    name: str,
    look: OnePicture | TwoPictures,
    sight: TableSight,
    pictures: dict[str, NDArray[np.uint8]],
) -> Result:
    found = len(recognise(look, sight).blocks)
    if found != _COUNT:
        raise RuntimeError(f"{name}: {found} of {_COUNT} blocks were recognised")
    white, black = pictures["white"], pictures["black"]

    def outlines() -> object:
        _, mask = cv2.threshold(
            cv2.cvtColor(cv2.subtract(white, black), cv2.COLOR_RGB2GRAY), 60, 255, 0
        )
        return cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)

    own_s, peer_s = interleaved_s(lambda: recognise(look, sight), outlines, repeat=15, number=3)
    return Result(
        name=f"{_COUNT} blocks, {name}",
        value=1e3 * own_s,
        unit="ms",
        peer="OpenCV: subtract, threshold, findContours",
        peer_value=1e3 * peer_s,
        target=_TARGET_MS,
    )


def _pictures() -> dict[str, NDArray[np.uint8]]:
    places = [(x, y) for x in (320, 420, 520, 620, 700) for y in (-280, -140, 0, 140)][:_COUNT]
    stage = Stage().put(
        *(
            block(KINDS[k % 3], COLOURS[k % 5], x, y, yaw_deg=17.0 * k)
            for k, (x, y) in enumerate(places)
        )
    )
    camera = stage.camera("top")
    pictures = {}
    for name in ("white", "black", "mash", "forest"):
        stage.show(name)
        pictures[name] = camera.grab().pixels
    return pictures
