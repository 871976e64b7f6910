"""One command shows many patterns: the page is opened once and paints each of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from calibration.screen.patterns import STEPS, Panel
from cell.pictures import HEIGHT_PX, WIDTH_PX
from cell.profile import load_profile
from console.hand_screen import HandScreen
from tests.cell.drivers.kiosk.chromium import Chromium, chromium_path
from tests.console.test_hardware import free_port


def test_patterns_in_a_row_come_out_exactly_and_the_picture_before_comes_back(
    tmp_path: Path,
) -> None:
    chromium_path()
    panel = Panel(width_px=WIDTH_PX, height_px=HEIGHT_PX)
    patterns = [panel.sine("columns", step) for step in range(STEPS)]
    patterns += [panel.code("rows", bit) for bit in range(4)]
    port = free_port()
    display = load_profile("mash").display.model_copy(update={"page_port": port})
    with Chromium(tmp_path / "chromium") as browser, HandScreen(display, tmp_path) as screen:
        again = screen.bookmark()
        browser.open(f"http://127.0.0.1:{port}/", WIDTH_PX, HEIGHT_PX)
        for number, pixels in enumerate(patterns):
            screen.show_pixels(pixels, f"pattern {number}")
            assert np.array_equal(browser.screenshot(), pixels), number
        again()
        assert not browser.screenshot().any()  # nothing was shown before: black
