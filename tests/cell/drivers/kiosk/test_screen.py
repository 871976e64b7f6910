"""The screen and a page without a browser: who confirms what, and what is refused."""

from __future__ import annotations

import hashlib
import json
import socket
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cell.drivers.kiosk import KioskScreen, KioskSettings
from cell.drivers.kiosk.patterns import checkerboard, solid
from cell.errors import DeviceError, DeviceTimeout
from tests.cell.drivers.kiosk.pages import (
    PATIENCE_S,
    FakePage,
    RushedClock,
    await_pages,
    loading_only,
    silence,
    view,
)

WIDTH_PX, HEIGHT_PX = 64, 36


def confirm(show: dict[str, Any], png: bytes) -> list[dict[str, Any]]:
    """Say what an honest page says."""
    return [
        {"kind": "loading", "number": show["number"]},
        {
            "kind": "painted",
            "number": show["number"],
            "sha256": hashlib.sha256(png).hexdigest(),
            "picture_px": [show["width_px"], show["height_px"]],
            "painted_unix_ms": 1.0,
            "took_ms": 20.0,
            "view": small_view(),
        },
    ]


def small_view(**changes: Any) -> dict[str, Any]:
    return view(WIDTH_PX, HEIGHT_PX, screen_px=(WIDTH_PX, HEIGHT_PX), **changes)


def settings(port: int = 0, state_folder: Path | None = None) -> KioskSettings:
    return KioskSettings(
        port=port,
        width_px=WIDTH_PX,
        height_px=HEIGHT_PX,
        paint_timeout_s=PATIENCE_S,
        state_folder=state_folder,
    )


@pytest.fixture
def clock() -> RushedClock:
    return RushedClock()


@pytest.fixture
def screen(clock: RushedClock) -> Iterator[KioskScreen]:
    with KioskScreen(settings(), clock) as started:
        yield started


PIXELS = checkerboard(WIDTH_PX, HEIGHT_PX, 4)


def test_show_returns_when_the_page_has_confirmed(screen: KioskScreen) -> None:
    with FakePage(screen, confirm, small_view()) as page:
        screen.show_pixels(PIXELS, "squares")
        assert screen.shown() == "squares"
        (painted,) = screen.painted()
        assert painted.sha256 == page.shows[-1]["sha256"]
        screen.check()


def test_show_waits_for_a_page_that_is_slow_to_paint(screen: KioskScreen) -> None:
    gate = threading.Event()
    held: list[list[dict[str, Any]]] = []

    def later(show: dict[str, Any], png: bytes) -> list[dict[str, Any]]:
        begun, painted = confirm(show, png)
        held.append([painted])
        gate.set()
        return [begun]

    with FakePage(screen, later, small_view()) as page:
        done = threading.Event()

        def work() -> None:
            screen.show_pixels(PIXELS)
            done.set()

        worker = threading.Thread(target=work)
        worker.start()
        assert gate.wait(PATIENCE_S)
        await_pages(screen, lambda pages: pages[0].loading is not None)
        assert not done.is_set()
        page.say(held[0][0])
        worker.join(PATIENCE_S)
        assert done.is_set()


def test_without_a_page_the_error_names_the_address(
    screen: KioskScreen, clock: RushedClock
) -> None:
    clock.rush()
    with pytest.raises(DeviceError, match="no page is connected") as caught:
        screen.show_pixels(PIXELS)
    assert screen.url in str(caught.value)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (small_view(is_visible=False), "hidden.*to the front"),
        (small_view(ratio=1.25), "scaled by 1.25.*100 %"),
        (
            view(60, 30, screen_px=(WIDTH_PX, HEIGHT_PX)),
            "has 60 x 30 pixels, 64 x 36 are needed.*F11",
        ),
        (
            view(60, 30, screen_px=(60, 30)),
            "60 x 30 pixels on a screen of 60 x 30, 64 x 36 .*output",
        ),
    ],
    ids=["hidden", "scaled", "not full screen", "wrong output"],
)
def test_a_page_whose_window_is_wrong_does_not_count(
    screen: KioskScreen, clock: RushedClock, changed: dict[str, Any], message: str
) -> None:
    with FakePage(screen, silence, changed):
        clock.rush()
        with pytest.raises(DeviceError, match=message) as caught:
            screen.show_pixels(PIXELS)
    assert not isinstance(caught.value, DeviceTimeout)


def test_a_page_that_has_not_painted_in_time_is_told_from_one_that_hangs(
    screen: KioskScreen, clock: RushedClock
) -> None:
    with FakePage(screen, silence, small_view()):
        clock.rush()
        with pytest.raises(DeviceTimeout, match="does not react to 'squares'"):
            screen.show_pixels(PIXELS, "squares")
    await_pages(screen, lambda pages: not pages)
    with FakePage(screen, loading_only, small_view()):
        await_pages(screen, lambda pages: pages[0].loading == 1)
        with pytest.raises(DeviceError, match="begun to load 'squares' and has not painted"):
            screen.check()


def test_a_page_that_painted_something_else_does_not_count(
    screen: KioskScreen, clock: RushedClock
) -> None:
    def other(show: dict[str, Any], png: bytes) -> list[dict[str, Any]]:
        _, painted = confirm(show, png)
        return [{**painted, "sha256": "0" * 64}]

    with FakePage(screen, other, small_view()):
        clock.rush()
        with pytest.raises(DeviceError):
            screen.show_pixels(PIXELS)
        await_pages(screen, lambda pages: pages[0].painted is not None)
        with pytest.raises(DeviceError, match="shows other content"):
            screen.check()


def test_the_confirmation_of_an_earlier_picture_does_not_count(
    screen: KioskScreen, clock: RushedClock
) -> None:
    def first_only(show: dict[str, Any], png: bytes) -> list[dict[str, Any]]:
        return confirm(show, png) if show["number"] == 1 else []

    with FakePage(screen, first_only, small_view()):
        screen.show_pixels(PIXELS)
        clock.rush()
        with pytest.raises(DeviceTimeout, match="does not react"):
            screen.show_pixels(PIXELS)


def test_what_the_page_could_not_do_is_told(screen: KioskScreen, clock: RushedClock) -> None:
    def broken(show: dict[str, Any], png: bytes) -> list[dict[str, Any]]:
        return [{"kind": "failed", "number": show["number"], "problem": "no memory"}]

    with FakePage(screen, broken, small_view()):
        clock.rush()
        with pytest.raises(DeviceError):
            screen.show_pixels(PIXELS)
        await_pages(screen, lambda pages: pages[0].failed is not None)
        with pytest.raises(DeviceError, match="no memory.*reload"):
            screen.check()


def test_of_several_pages_the_one_that_does_not_confirm_is_named(
    screen: KioskScreen, clock: RushedClock
) -> None:
    with (
        FakePage(screen, confirm, small_view()),
        FakePage(screen, confirm, small_view()) as second,
    ):
        screen.show_pixels(PIXELS)
        assert len(screen.painted()) == 2
        second.say({"kind": "view", "view": small_view(is_visible=False)})
        await_pages(screen, lambda pages: any(not page.view.is_visible for page in pages))
        with pytest.raises(DeviceError, match="page 2, one of 2 connected, is hidden.*close it"):
            screen.check()


def test_a_page_that_connects_late_gets_the_picture(screen: KioskScreen) -> None:
    worker = threading.Thread(target=screen.show_pixels, args=(PIXELS, "squares"))
    worker.start()
    with FakePage(screen, confirm, small_view()) as page:
        worker.join(PATIENCE_S)
        assert not worker.is_alive()
        assert page.shows[-1]["name"] == "squares"


def test_a_new_process_shows_the_last_picture_again(tmp_path: Path) -> None:
    with (
        KioskScreen(settings(state_folder=tmp_path)) as first,
        FakePage(first, confirm, small_view()),
    ):
        first.show_pixels(solid(WIDTH_PX, HEIGHT_PX, (1, 2, 3)))
        first.show_pixels(PIXELS, "squares")
    with KioskScreen(settings(state_folder=tmp_path)) as second:
        assert second.shown() == "squares"
        with FakePage(second, confirm, small_view()) as page:
            await_pages(second, lambda pages: pages[0].painted is not None)
            second.check()
            assert page.shows[0]["name"] == "squares"
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("damage", ["picture", "index", "no picture"])
def test_a_damaged_last_picture_is_left_out(tmp_path: Path, damage: str) -> None:
    with (
        KioskScreen(settings(state_folder=tmp_path)) as first,
        FakePage(first, confirm, small_view()),
    ):
        first.show_pixels(PIXELS, "squares")
    (png,) = tmp_path.glob("*.png")
    if damage == "picture":
        png.write_bytes(png.read_bytes()[:-1])
    elif damage == "index":
        (tmp_path / "screen.json").write_text("{")
    else:
        png.unlink()
    with KioskScreen(settings(state_folder=tmp_path)) as second:
        assert second.shown() == ""


def test_stop_closes_the_page_and_a_second_start_takes_the_same_address(
    screen: KioskScreen,
) -> None:
    url = screen.url
    with FakePage(screen, confirm, small_view()) as page:
        screen.show_pixels(PIXELS, "squares")
        screen.stop()
        assert page.was_closed_by_server.wait(PATIENCE_S)
    screen.stop()
    screen.start()
    assert screen.url == url
    with FakePage(screen, confirm, small_view()) as page:
        await_pages(screen, lambda pages: pages[0].painted is not None)
        assert page.shows[0]["name"] == "squares"
        screen.check()


def test_a_port_that_is_taken_is_named() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(DeviceError, match=f"127.0.0.1:{port}.*choose another"):
            KioskScreen(settings(port)).start()


def test_an_unknown_picture_is_refused_with_the_known_ones(screen: KioskScreen) -> None:
    with pytest.raises(DeviceError, match="knows no picture 'sky'; use black, white"):
        screen.show("sky")


@pytest.mark.parametrize(
    ("pixels", "message"),
    [
        (np.zeros((HEIGHT_PX, WIDTH_PX), np.uint8), "uint8 with shape"),
        (np.zeros((HEIGHT_PX, WIDTH_PX, 3), np.float64), "float64"),
        (np.zeros((10, 20, 3), np.uint8), "'pixels' has 20 x 10 pixels, the panel 64 x 36"),
    ],
    ids=["two dimensions", "floats", "size"],
)
def test_what_is_no_picture_of_the_panel_is_refused(
    screen: KioskScreen, pixels: Any, message: str
) -> None:
    with pytest.raises(DeviceError, match=message):
        screen.show_pixels(pixels)
    assert screen.shown() == ""


@pytest.mark.parametrize(
    "nonsense",
    ["", "{", "[]", '{"kind":"painted"}', '{"kind":"view","view":{}}', "x" * 5000],
    ids=["empty", "half", "list", "incomplete", "no view", "long"],
)
def test_a_page_that_talks_nonsense_is_sent_away_and_harms_nobody(
    screen: KioskScreen, nonsense: str
) -> None:
    with FakePage(screen, confirm, small_view()) as bad:
        bad.say(nonsense)
        assert bad.was_closed_by_server.wait(PATIENCE_S)
    await_pages(screen, lambda pages: not pages)
    with FakePage(screen, confirm, small_view()):
        screen.show_pixels(PIXELS)


def test_a_picture_that_was_never_shown_is_not_there(screen: KioskScreen) -> None:
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    with pytest.raises(urllib.error.HTTPError, match="404") as caught:
        opener.open(f"{screen.url}pictures/{'0' * 64}.png", timeout=PATIENCE_S)
    caught.value.close()


def test_a_page_of_another_site_cannot_listen(screen: KioskScreen) -> None:
    host, port = screen.url.removeprefix("http://").rstrip("/").split(":")
    with socket.create_connection((host, int(port)), PATIENCE_S) as line:
        line.sendall(
            b"GET /socket HTTP/1.1\r\nHost: %s\r\nOrigin: http://elsewhere.example\r\n"
            b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n" % host.encode()
        )
        assert line.recv(4096).startswith(b"HTTP/1.1 403")


def test_the_index_of_the_kept_picture_is_plain_json(tmp_path: Path) -> None:
    with (
        KioskScreen(settings(state_folder=tmp_path)) as first,
        FakePage(first, confirm, small_view()),
    ):
        first.show_pixels(PIXELS, "squares")
    kept = json.loads((tmp_path / "screen.json").read_text("utf-8"))
    assert kept["name"] == "squares"
