"""`cell serve --wires hardware` from end to end, in real time: ports, page, pictures, a client.

The devices are emulated behind pseudo-terminals that the server's process opens like
hardware; the cameras' pictures are files. The television is a page without a browser, or
Chromium where ROBOCELL_REQUIRE_CHROMIUM is 1.
"""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest

from cell.assembly.models import emulate_cell
from cell.clock import SystemClock
from cell.profile import load_profile, profile_text
from cell.twin.serving.ends import PtyEnd
from cell.twin.serving.pty_port import PtyPort
from cell.twin.serving.server import EmulatorServer
from cell.twin.wire_faults import FaultyEmulator, WireFault
from console.scripts import load_script
from sessions.client import MasClient
from sessions.errors import SessionsError
from sessions.hosting import store_plan
from tests.cell.drivers.kiosk.chromium import REQUIRED, Chromium
from tests.cell.drivers.kiosk.pages import DistantPage, confirming, view
from tests.console.cli import command, environment

DEADLINE_S = 60.0
PICTURES = 24
SEED = 4


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port: int = taken.getsockname()[1]
        return port


def write_pictures(folder: Path, seed: int) -> None:
    """Write pictures of which no two are alike, as a camera's never are."""
    random = np.random.default_rng(seed)
    folder.mkdir(parents=True)
    for number in range(PICTURES):
        small = random.integers(40, 220, (60, 80, 3), np.uint8)
        cv2.imwrite(str(folder / f"{number:03}.jpg"), cv2.resize(small, (1280, 960)))


def write_profile(folder: Path, page_port: int) -> Path:
    """Write the shipped profile with ports and pictures in a folder, and in a hurry."""
    text = profile_text("mash")
    for device, port in (("arm", "COM9"), ("gripper", "COM8"), ("display", "COM7")):
        text = text.replace(f'port = "{port}"', f'port = "{folder / "ports" / device}"')
    for number, camera in enumerate(("oblique", "top", "gripper")):
        pictures = folder / camera
        write_pictures(pictures, SEED + number)
        table = f"[cameras.{camera}]\n"
        text = text.replace(table, f'{table}backend = "file"\nsource = "{pictures}"\n')
    for was, now in (
        (
            "joint_speed_deg_s = [250, 267, 267, 352, 450, 660]",
            "joint_speed_deg_s = [999, 999, 999, 999, 999, 999]",
        ),
        ("\nlinear_speed_mm_s = 250 ", "\nlinear_speed_mm_s = 1000 "),
        ("joint_speed_percent = 30 ", "joint_speed_percent = 100 "),
        ("\nspeed_mm_s = 60", "\nspeed_mm_s = 82"),
        ("\nacceleration_mm_s2 = 200", "\nacceleration_mm_s2 = 320"),
        ("\ninput = 1", f"\ninput = 1\npage_port = {page_port}"),
    ):
        assert was in text, was
        text = text.replace(was, now)
    path = folder / "mash.toml"
    path.write_text(text, "utf-8")
    return path


@contextmanager
def emulated(profile: Path, ports: Path) -> Iterator[dict[str, FaultyEmulator]]:
    """Serve the devices of a profile on their ports; yield their wires."""
    clock, wires = SystemClock(), {}
    ports.mkdir()
    plan = store_plan(load_script("mash"))
    with ExitStack() as stack:
        for device in emulate_cell(load_profile(str(profile)), plan, clock, seed=SEED):
            end = PtyEnd(PtyPort(ports / device.name, device.line))
            stack.enter_context(
                EmulatorServer(device.name, device.emulator, end, clock, lock=device.lock)
            )
            wires[device.name] = device.emulator
        yield wires


class Served:
    """A server process and what it says."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        assert process.stderr is not None
        self.process = process
        self._stderr = process.stderr
        self._lines: list[str] = []
        self._reading = threading.Thread(target=self._read)
        self._reading.start()
        first = process.stdout.readline()
        assert first.startswith("listening on"), self.end()
        self.port = int(first.split()[2].rpartition(":")[2])

    def _read(self) -> None:
        self._lines.extend(self._stderr)

    def end(self) -> str:
        """Wait for the process and return its log."""
        try:
            self.process.wait(DEADLINE_S)
        finally:
            self.process.kill()
            self._reading.join(DEADLINE_S)
        return "".join(self._lines)


@contextmanager
def serving(profile: Path, home: Path) -> Iterator[Served]:
    words = ["serve", "mash", "--profile", str(profile), "--wires", "hardware", "--port", "0"]
    with subprocess.Popen(
        command([*words, "--seed", str(SEED), "--no-watchdog"]),
        env=environment(home),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield Served(process)
        finally:
            process.kill()


def fake_page(url: str, folder: Path) -> AbstractContextManager[object]:
    """Return the television of most tests: it confirms what it is told to show."""
    return DistantPage(url, confirming(view()), view())


@contextmanager
def chromium_page(url: str, folder: Path) -> Iterator[Chromium]:
    with Chromium(folder / "chromium") as browser:
        browser.open(url, 1920, 1080)
        yield browser


@contextmanager
def playing(
    folder: Path, page: Callable[[str, Path], AbstractContextManager[object]]
) -> Iterator[tuple[Served, dict[str, FaultyEmulator]]]:
    port = free_port()
    profile = write_profile(folder, port)
    with (
        emulated(profile, folder / "ports") as wires,
        serving(profile, folder) as served,
        page(f"http://127.0.0.1:{port}/", folder),
    ):
        yield served, wires


def test_a_task_is_played_on_hardware_and_goes_on_after_an_unplugged_arm(tmp_path: Path) -> None:
    with playing(tmp_path, chromium_page if REQUIRED else fake_page) as (served, wires):
        with MasClient.connect("127.0.0.1", served.port) as client:
            client.start("ReachRedCube", "STATIC_4x4")
            assert client.action("UP").event == "Robot move"
            seen = client.get_view("CAMERA_TOP")
            assert seen.pixels().shape == (960, 1280, 3)
            wires["arm"].inject(WireFault.UNPLUGGED)
            with pytest.raises(SessionsError, match="connection to a device failed"):
                client.action("RIGHT")
            wires["arm"].clear()
            assert client.action("RIGHT").event == "Robot move"
            assert not np.array_equal(client.get_view("CAMERA_TOP").pixels(), seen.pixels())
        served.process.send_signal(signal.SIGTERM)
        log = served.end()
    assert served.process.returncode == 0, log
    assert len(re.findall(r"held: arm: \S+ is gone while in use|held: arm: no port", log)) == 1, log
    assert log.count("asked again") == 1, log
    assert "resume check: clear" in log
    assert "Traceback" not in log
