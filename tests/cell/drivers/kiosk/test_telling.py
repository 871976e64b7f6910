"""What other programs of the computer are told of the screen."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlsplit

import pytest

from cell.drivers.kiosk import KioskScreen, ask_screen
from cell.drivers.kiosk.server import _is_loopback
from cell.errors import DeviceError
from tests.cell.drivers.kiosk.pages import FakePage, RushedClock
from tests.cell.drivers.kiosk.test_screen import (
    HEIGHT_PX,
    PIXELS,
    WIDTH_PX,
    confirm,
    settings,
    small_view,
)
from tests.cell.drivers.kiosk.test_screen import screen as screen


@pytest.fixture
def clock() -> RushedClock:
    return RushedClock()


def port_of(screen: KioskScreen) -> int:
    port = urlsplit(screen.url).port
    assert port is not None
    return port


def test_without_a_page_nothing_is_painted(screen: KioskScreen) -> None:
    told = ask_screen(port_of(screen))
    assert told is not None
    assert (told.size, told.shown, told.painted, told.pages) == (
        (WIDTH_PX, HEIGHT_PX),
        "",
        False,
        (),
    )


def test_a_painted_picture_is_told_with_its_page(screen: KioskScreen) -> None:
    with FakePage(screen, confirm, small_view()):
        screen.show_pixels(PIXELS, "squares")
        told = ask_screen(port_of(screen))
    assert told is not None
    assert (told.shown, told.painted) == ("squares", True)
    (page,) = told.pages
    assert (page.covers_px, page.is_visible, page.trouble) == ((WIDTH_PX, HEIGHT_PX), True, "")


def test_a_scaled_page_is_told_by_what_it_covers(screen: KioskScreen) -> None:
    with FakePage(screen, confirm, small_view(ratio=1.25)):
        told = ask_screen(port_of(screen))
    assert told is not None
    (page,) = told.pages
    assert page.covers_px == (round(WIDTH_PX * 1.25), round(HEIGHT_PX * 1.25))
    assert "scaled by 1.25" in page.trouble


def test_a_port_that_nobody_has_tells_nothing(clock: RushedClock) -> None:
    with KioskScreen(settings(), clock) as gone:
        port = port_of(gone)
    assert ask_screen(port) is None


@contextmanager
def _somebody_else(answer: bytes) -> Iterator[int]:
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def serve() -> None:
            connected, _ = listening.accept()
            with connected:
                connected.recv(4096)
                connected.sendall(answer)

        thread = threading.Thread(target=serve)
        thread.start()
        yield listening.getsockname()[1]
        thread.join()


@pytest.mark.parametrize(
    "answer",
    [
        b"",
        b"SSH-2.0-OpenSSH_9\r\n",
        b"HTTP/1.0 404 Not Found\r\n\r\nno such page",
        b"HTTP/1.0 200 OK\r\n\r\n{}",
    ],
)
def test_another_program_on_the_port_is_said(answer: bytes) -> None:
    with _somebody_else(answer) as port, pytest.raises(DeviceError, match="does not serve"):
        ask_screen(port, timeout_s=5.0)


@pytest.mark.parametrize(
    ("address", "is_own"),
    [("127.0.0.1", True), ("::1", True), ("192.168.0.7", False), ("", False)],
)
def test_only_this_computer_is_told(address: str, is_own: bool) -> None:
    assert _is_loopback(address) == is_own
