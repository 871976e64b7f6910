"""How long the television's page takes to confirm a picture, in headless Chromium."""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks.measure import Result, median_s
from cell.drivers.kiosk import KioskScreen, KioskSettings
from cell.drivers.kiosk.patterns import gray_code
from cell.drivers.kiosk.png import encode_png
from cell.pictures import HEIGHT_PX, PICTURE_NAMES, WIDTH_PX, picture
from tests.cell.drivers.kiosk.chromium import Chromium, has_chromium

_ROUNDS = 8
_FRAMES_MS = 2 * 1000.0 / 60.0
"""Two frames of a 60 Hz display: the least that a confirmation can take."""


def run() -> list[Result]:
    """Measure `show` from call to return, 1920 x 1080."""
    if not has_chromium():
        print("television_page: chromium is not installed; nothing measured", file=sys.stderr)
        return []
    settings = KioskSettings(port=0, paint_timeout_s=30.0)
    with (
        tempfile.TemporaryDirectory() as folder,
        Chromium(Path(folder)) as browser,
        KioskScreen(settings) as screen,
    ):
        browser.open(screen.url, WIDTH_PX, HEIGHT_PX)
        for name in PICTURE_NAMES:
            screen.show(name)
        pictures = [_taken_ms(_showing(screen, name)) for name in PICTURE_NAMES * _ROUNDS]
        patterns = list(_patterns_ms(screen))
    encode_ms = 1e3 * median_s(lambda: encode_png(picture("water")), repeat=3)
    return [
        _result("five pictures, known to the page, median", statistics.median(pictures)),
        _result(
            "five pictures, known to the page, 95 %", sorted(pictures)[len(pictures) * 95 // 100]
        ),
        _result("Gray code patterns, new to the page, median", statistics.median(patterns)),
        Result(name="water as PNG, once a program", value=encode_ms, unit="ms"),
    ]


def _result(name: str, value_ms: float) -> Result:
    peer = "two frames of 60 Hz"
    return Result(name=name, value=value_ms, unit="ms", peer=peer, peer_value=_FRAMES_MS)


def _showing(screen: KioskScreen, name: str) -> Callable[[], None]:
    return lambda: screen.show(name)


def _patterns_ms(screen: KioskScreen) -> Iterator[float]:
    for bit in range(11):
        pixels = gray_code(WIDTH_PX, HEIGHT_PX, "columns", bit)
        start = time.perf_counter()
        screen.show_pixels(pixels)
        yield 1e3 * (time.perf_counter() - start)


def _taken_ms(job: Callable[[], None]) -> float:
    start = time.perf_counter()
    job()
    return 1e3 * (time.perf_counter() - start)
