"""`cell tv-page` in a process of its own, with and without a browser."""

from __future__ import annotations

import signal
import subprocess
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from cell.pictures import HEIGHT_PX, WIDTH_PX, picture
from console.cli import main
from console.exits import Exit
from tests.cell.drivers.kiosk.chromium import Chromium, chromium_path
from tests.console.cli import command, environment

ENDS_S = 20.0


@contextmanager
def tv_page(home: Path, *words: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        command(["tv-page", "--port", "0", *words]),
        env=environment(home),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate(timeout=ENDS_S)


def line_of(process: subprocess.Popen[str], wanted: str) -> str:
    """Return the next line on stderr that contains a text."""
    assert process.stderr is not None
    for line in process.stderr:
        if wanted in line:
            return line
    raise AssertionError(f"{wanted!r} was not told")


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, Exit.DONE), (signal.SIGINT, Exit.INTERRUPTED)]
)
def test_it_tells_its_address_serves_the_page_and_ends_when_asked(
    tmp_path: Path, number: signal.Signals, code: Exit
) -> None:
    with tv_page(tmp_path) as process:
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        with opener.open(url, timeout=ENDS_S) as answer:
            assert b"page.js" in answer.read()
        assert url in line_of(process, "no page is connected")
        process.send_signal(number)
        assert process.wait(ENDS_S) == code


def test_a_picture_that_there_is_not_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tv-page", "--picture", "sky"]) == Exit.USAGE
    assert "there are black, white, mash, water, forest" in capsys.readouterr().err


def test_in_a_browser_it_tells_what_is_painted_and_what_is_wrong(tmp_path: Path) -> None:
    chromium_path()
    with Chromium(tmp_path / "browser") as browser:
        with tv_page(tmp_path, "--picture", "water") as process:
            assert process.stdout is not None
            url = process.stdout.readline().strip()
            browser.open(url, WIDTH_PX, HEIGHT_PX)
            assert "1920 x 1080, 1 page" in line_of(process, "water is painted")
            assert np.array_equal(browser.screenshot(), picture("water"))
            browser.resize(1280, 720)
            assert "1920 x 1080 are needed" in line_of(process, "1280 x 720")
            browser.resize(WIDTH_PX, HEIGHT_PX)
            line_of(process, "water is painted")
            process.send_signal(signal.SIGTERM)
            assert process.wait(ENDS_S) == Exit.DONE
        with tv_page(tmp_path) as process:
            assert process.stdout is not None
            browser.open(process.stdout.readline().strip(), WIDTH_PX, HEIGHT_PX)
            line_of(process, "water is painted")
            assert np.array_equal(browser.screenshot(), picture("water"))
