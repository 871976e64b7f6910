"""The page in a real browser: what it says is what is on it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cell.drivers.kiosk import KioskScreen, KioskSettings
from cell.drivers.kiosk.patterns import checkerboard, crosshair, gray_code
from cell.errors import DeviceError
from cell.pictures import HEIGHT_PX, PICTURE_NAMES, WIDTH_PX, picture
from tests.cell.drivers.kiosk.chromium import Chromium, chromium_path
from tests.cell.drivers.kiosk.pages import RushedClock, await_pages


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    chromium_path()
    with Chromium(tmp_path_factory.mktemp("chromium")) as started:
        yield started


@pytest.fixture
def screen() -> Iterator[KioskScreen]:
    with KioskScreen(KioskSettings(port=0, paint_timeout_s=20.0)) as started:
        yield started


def test_every_picture_is_on_the_screen_pixel_by_pixel_when_show_returns(
    browser: Chromium, screen: KioskScreen
) -> None:
    browser.open(screen.url, WIDTH_PX, HEIGHT_PX)
    for name in PICTURE_NAMES:
        screen.show(name)
        assert np.array_equal(browser.screenshot(), picture(name)), name
        (painted,) = screen.painted()
        assert painted.picture_px == (WIDTH_PX, HEIGHT_PX)
        assert painted.view.is_visible
        assert screen.shown() == name


def test_noise_and_patterns_come_out_exactly(browser: Chromium, screen: KioskScreen) -> None:
    browser.open(screen.url, WIDTH_PX, HEIGHT_PX)
    noise = np.random.default_rng(5).integers(0, 256, (HEIGHT_PX, WIDTH_PX, 3), np.uint8)
    for pixels in (
        noise,
        checkerboard(WIDTH_PX, HEIGHT_PX, 1),
        gray_code(WIDTH_PX, HEIGHT_PX, "columns", 0),
        crosshair(WIDTH_PX, HEIGHT_PX, (1919, 0)),
    ):
        screen.show_pixels(pixels)
        assert np.array_equal(browser.screenshot(), pixels)


def test_a_page_connects_again_and_shows_the_last_picture(browser: Chromium) -> None:
    first = KioskScreen(KioskSettings(port=0, paint_timeout_s=20.0))
    with first:
        browser.open(first.url, WIDTH_PX, HEIGHT_PX)
        first.show("water")
    assert np.array_equal(browser.screenshot(), picture("water"))
    port = int(first.url.rstrip("/").rpartition(":")[2])
    with KioskScreen(KioskSettings(port=port, paint_timeout_s=20.0)) as second:
        second.show("mash")
        assert np.array_equal(browser.screenshot(), picture("mash"))


def test_a_window_of_another_size_is_refused_and_right_again_after_a_change(
    browser: Chromium,
) -> None:
    clock = RushedClock()
    with KioskScreen(KioskSettings(port=0, paint_timeout_s=20.0), clock) as screen:
        browser.open(screen.url, WIDTH_PX, HEIGHT_PX)
        screen.show("white")
        browser.resize(1280, 720)
        await_pages(screen, lambda pages: pages[0].view.window_px == (1280, 720))
        with pytest.raises(DeviceError, match="1280 x 720, 1920 x 1080 are needed"):
            screen.check()
        browser.resize(WIDTH_PX, HEIGHT_PX)
        screen.show("black")
        assert np.array_equal(browser.screenshot(), picture("black"))
        browser.resize(1280, 720)
        await_pages(screen, lambda pages: pages[0].view.window_px == (1280, 720))
        clock.rush()
        with pytest.raises(DeviceError, match="1280 x 720, 1920 x 1080 are needed"):
            screen.show("white")


def test_a_scaled_page_is_refused_until_it_is_scaled_no_more(
    browser: Chromium, screen: KioskScreen
) -> None:
    browser.open(screen.url, WIDTH_PX, HEIGHT_PX)
    screen.show("white")
    for ratio in (2.0, 1.25):
        browser.resize(WIDTH_PX, HEIGHT_PX, ratio)
        await_pages(screen, lambda pages: pages[0].view.pixel_ratio != 1.0)
        with pytest.raises(DeviceError, match=f"scaled by {ratio:g}.*100 %"):
            screen.check()
        browser.resize(WIDTH_PX, HEIGHT_PX)
        await_pages(screen, lambda pages: pages[0].view.pixel_ratio == 1.0)
        screen.check()


def test_a_page_behind_another_tab_is_said_to_be_hidden_until_it_is_in_front(
    browser: Chromium, screen: KioskScreen
) -> None:
    browser.open(screen.url, WIDTH_PX, HEIGHT_PX)
    screen.show("white")
    tab = browser.cover()
    await_pages(screen, lambda pages: not pages[0].view.is_visible)
    screen.send("mash")
    with pytest.raises(DeviceError, match="hidden.*to the front"):
        screen.check()
    browser.uncover(tab)
    await_pages(screen, lambda pages: pages[0].painted.number == 2)
    screen.check()
    assert np.array_equal(browser.screenshot(), picture("mash"))


def test_the_page_needs_nothing_from_elsewhere_and_hides_the_cursor(
    browser: Chromium, screen: KioskScreen
) -> None:
    browser.open(screen.url, WIDTH_PX, HEIGHT_PX)
    screen.show("forest")
    used = browser.evaluate("performance.getEntriesByType('resource').map(e => e.name).join(' ')")
    assert used
    assert all(address.startswith(screen.url) for address in used.split())
    assert browser.evaluate("getComputedStyle(document.body).cursor") == "none"


def test_the_page_of_the_package_is_found_beside_its_module() -> None:
    folder = Path(__file__).parents[4] / "cell" / "drivers" / "kiosk"
    assert (folder / "page.html").exists()
    assert (folder / "page.js").exists()
