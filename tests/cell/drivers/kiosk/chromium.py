"""A headless Chromium that is driven over the DevTools protocol and dies with its test.

The protocol runs over two pipes, so that Chromium ends by itself when this process does.
"""

from __future__ import annotations

import base64
import contextlib
import itertools
import json
import os
import select
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

REQUIRED = os.environ.get("ROBOCELL_REQUIRE_CHROMIUM") == "1"
FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-proxy-server",
    "--force-color-profile=srgb",
    "--force-device-scale-factor=1",
    "--remote-debugging-pipe",
)
ANSWER_S = 30.0
_ON_3_AND_4 = """
import fcntl, os, sys
ends = [fcntl.fcntl(int(end), fcntl.F_DUPFD, 10) for end in sys.argv[1:3]]
os.dup2(ends[0], 3)
os.dup2(ends[1], 4)
os.execv(sys.argv[3], sys.argv[3:])
"""
"""Chromium reads the protocol from descriptor 3 and writes it to 4."""


def has_chromium() -> bool:
    """Return whether there is a Chromium."""
    return _path() is not None


def _path() -> str | None:
    return shutil.which("chromium") or shutil.which("chromium-browser")


def chromium_path() -> str:
    """Return where Chromium is; skip the test, or fail it if Chromium is demanded."""
    path = _path()
    if path is not None:
        return path
    if REQUIRED:
        pytest.fail("chromium is not installed and ROBOCELL_REQUIRE_CHROMIUM is 1")
    pytest.skip("chromium is not installed; ROBOCELL_REQUIRE_CHROMIUM=1 makes this a failure")


class Chromium:
    """One browser with one page."""

    def __init__(self, folder: Path) -> None:
        self._numbers = itertools.count(1)
        self._rest = b""
        to_browser, self._out = os.pipe()
        self._in, from_browser = os.pipe()
        command = (chromium_path(), *FLAGS, f"--user-data-dir={folder}", "about:blank")
        self._process = subprocess.Popen(
            [sys.executable, "-ISc", _ON_3_AND_4, str(to_browser), str(from_browser), *command],
            pass_fds=(to_browser, from_browser),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        os.close(to_browser)
        os.close(from_browser)
        try:
            self._session = self._attach()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the browser and everything it has started."""
        for end in (self._out, self._in):
            os.close(end)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(5.0)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait(5.0)

    def open(self, url: str, width_px: int, height_px: int, ratio: float = 1.0) -> None:
        """Load a page in a window of that size."""
        self.resize(width_px, height_px, ratio)
        self.call("Page.navigate", url=url)

    def resize(self, width_px: int, height_px: int, ratio: float = 1.0) -> None:
        """Give window and screen a size."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width_px,
            height=height_px,
            deviceScaleFactor=ratio,
            mobile=False,
            screenWidth=width_px,
            screenHeight=height_px,
        )

    def cover(self) -> str:
        """Open another tab in front of the page and return its name."""
        target: str = self._call("Target.createTarget", {"url": "about:blank"}, None)["targetId"]
        return target

    def uncover(self, tab: str) -> None:
        """Close the other tab and bring the page to the front."""
        self._call("Target.closeTarget", {"targetId": tab}, None)
        self.call("Page.bringToFront")

    def evaluate(self, expression: str) -> Any:
        """Return the value of an expression on the page."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True)
        return answer["result"].get("value")

    def screenshot(self) -> NDArray[np.uint8]:
        """Return what the page looks like: shape (height, width, 3), R G B."""
        png = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        picture = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
        assert picture is not None
        return np.asarray(picture[..., ::-1], np.uint8)

    def call(self, method: str, **parameters: Any) -> Any:
        """Call a method of the protocol on the page and return its result."""
        return self._call(method, parameters, self._session)

    def _attach(self) -> str:
        targets = self._call("Target.getTargets", {}, None)["targetInfos"]
        page = next(target["targetId"] for target in targets if target["type"] == "page")
        parameters = {"targetId": page, "flatten": True}
        session: str = self._call("Target.attachToTarget", parameters, None)["sessionId"]
        return session

    def _call(self, method: str, parameters: dict[str, Any], session: str | None) -> Any:
        number = next(self._numbers)
        request: dict[str, Any] = {"id": number, "method": method, "params": parameters}
        if session is not None:
            request["sessionId"] = session
        os.write(self._out, json.dumps(request).encode() + b"\0")
        deadline_s = time.monotonic() + ANSWER_S
        while True:
            message = self._message(deadline_s)
            if message.get("id") == number:
                assert "error" not in message, f"{method}: {message['error']}"
                return message["result"]

    def _message(self, deadline_s: float) -> dict[str, Any]:
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._in], [], [], max(0.0, deadline_s - time.monotonic()))
            data = os.read(self._in, 1 << 20) if ready else b""
            assert data, "chromium has ended or does not answer"
            self._rest += data
        head, _, self._rest = self._rest.partition(b"\0")
        message: dict[str, Any] = json.loads(head)
        return message
