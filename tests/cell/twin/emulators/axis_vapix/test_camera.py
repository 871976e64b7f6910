"""The emulated web camera as any program meets it: plain HTTP, without our driver."""

from __future__ import annotations

import base64
import http.client
import socket
import threading
from collections.abc import Iterator

import numpy as np
import pytest

from cell.clock import SimulatedClock
from cell.errors import DeviceError
from cell.twin.emulators.axis_vapix import (
    EmulatedAxisCamera,
    EmulatedAxisSettings,
    HeadState,
    WebCameraFault,
    panorama,
)

HEAD = "/axis-cgi/com/ptz.cgi?"


def ask(
    emulated: EmulatedAxisCamera, target: str, headers: dict[str, str] | None = None
) -> tuple[int, str, bytes]:
    """Return status, content type and body."""
    connection = http.client.HTTPConnection(emulated.url.removeprefix("http://"), timeout=10.0)
    try:
        connection.request("GET", target, headers=headers or {})
        response = connection.getresponse()
        return response.status, response.getheader("Content-Type", ""), response.read()
    finally:
        connection.close()


@pytest.fixture
def camera() -> Iterator[EmulatedAxisCamera]:
    with EmulatedAxisCamera(clock=SimulatedClock()) as started:
        yield started


def test_the_worked_examples_of_the_reference_hold() -> None:
    with EmulatedAxisCamera(EmulatedAxisSettings(auth="basic")) as camera:
        header = {"Authorization": "Basic cm9vdDpwYXNz"}
        status, kind, body = ask(camera, "/axis-cgi/jpg/image.cgi", header)
        assert (status, kind) == (200, "image/jpeg")
        assert body.startswith(b"\xff\xd8")
        assert body.endswith(b"\xff\xd9")
        status, kind, body = ask(camera, f"{HEAD}query=position", header)
        assert (status, kind) == (200, "text/plain")
        names = [line.partition("=")[0] for line in body.decode("ascii").splitlines()]
        assert names == [
            "pan", "tilt", "zoom", "iris", "focus", "brightness", "autofocus", "autoiris",
        ]  # fmt: skip
        assert ask(camera, f"{HEAD}move=home", header)[0] == 204
        wrong = base64.b64encode(b"root:other").decode("ascii")
        for value in ("", f"Basic {wrong}", "Basic ***", "Bearer x", 'Digest username="root"'):
            assert ask(camera, f"{HEAD}move=home", {"Authorization": value})[0] == 401


@pytest.mark.parametrize(
    "query",
    [
        "",
        "nonsense=1",
        "pan=left",
        "pan=999",
        "pan=nan",
        "move=sideways",
        "continuouspantiltmove=5",
        "continuouspantiltmove=5,101",
        "center=1",
        "gotoserverpresetname=roof",
        "autofocus=perhaps",
        "query=weather",
    ],
)
def test_a_request_that_is_wrong_gets_a_complaint_with_status_200(
    camera: EmulatedAxisCamera, query: str
) -> None:
    before = camera.state()
    status, _, body = ask(camera, f"{HEAD}{query}")
    assert status == 200
    assert body.startswith(b"Error: ")
    assert camera.state() == before


def test_an_unknown_path_is_not_there(camera: EmulatedAxisCamera) -> None:
    assert ask(camera, "/")[0] == 404
    with EmulatedAxisCamera(EmulatedAxisSettings(has_head=False)) as fixed:
        assert ask(fixed, f"{HEAD}query=position")[0] == 404


def test_a_digest_is_not_taken_twice() -> None:
    """What somebody overheard is of no use: the count of a nonce must grow."""
    settings = EmulatedAxisSettings(auth="digest")
    with EmulatedAxisCamera(settings) as camera:
        from cell.drivers.axis_vapix.authorization import Credentials

        challenges = camera.gate.challenges("")
        credentials = Credentials("root", "pass")
        assert credentials.learn(challenges)
        header = {"Authorization": str(credentials.header("GET", f"{HEAD}move=home"))}
        assert ask(camera, f"{HEAD}move=home", header)[0] == 204
        assert ask(camera, f"{HEAD}move=home", header)[0] == 401
        other = {"Authorization": str(credentials.header("GET", f"{HEAD}move=home"))}
        assert ask(camera, f"{HEAD}move=stop", other)[0] == 401


def test_the_old_path_and_word_of_a_stream_work_too(camera: EmulatedAxisCamera) -> None:
    connection = http.client.HTTPConnection(camera.url.removeprefix("http://"), timeout=10.0)
    connection.request("GET", "/mjpg/video.mjpg?req_fps=60&resolution=160x120")
    response = connection.getresponse()
    assert response.getheader("Content-Type") == "multipart/x-mixed-replace;boundary=myboundary"
    assert response.readline() == b"--myboundary\r\n"
    response.close()
    connection.close()


def test_stop_ends_streams_and_who_is_held_and_a_second_start_takes_the_same_port() -> None:
    camera = EmulatedAxisCamera()
    camera.start()
    camera.start()
    url = camera.url
    camera.inject(WebCameraFault.SILENT)
    ended = threading.Event()

    def wait() -> None:
        with socket.create_connection(("127.0.0.1", int(url.rpartition(":")[2])), 10.0) as line:
            line.sendall(b"GET / HTTP/1.1\r\n\r\n")
            if line.recv(100) == b"":
                ended.set()

    worker = threading.Thread(target=wait)
    worker.start()
    while not camera.requests:
        worker.join(0.005)
    camera.stop()
    worker.join(10.0)
    assert ended.is_set()
    camera.stop()
    camera.start()
    assert camera.url == url
    assert ask(camera, f"{HEAD}whoami=1")[0] == 200
    camera.stop()


def test_a_port_that_is_taken_is_named(camera: EmulatedAxisCamera) -> None:
    port = int(camera.url.rpartition(":")[2])
    with pytest.raises(DeviceError, match=f"127.0.0.1:{port}.*choose another"):
        EmulatedAxisCamera(port=port).start()


def test_another_source_of_pictures_is_shown() -> None:
    def grey(
        state: HeadState, settings: EmulatedAxisSettings, width_px: int, height_px: int
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
        return np.full((height_px, width_px, 3), 99, np.uint8)

    with EmulatedAxisCamera(source=grey) as camera:
        _, _, body = ask(camera, "/axis-cgi/jpg/image.cgi?resolution=160x120")
    with EmulatedAxisCamera() as camera:
        assert body != ask(camera, "/axis-cgi/jpg/image.cgi?resolution=160x120")[2]


def test_the_panorama_moves_by_as_many_pixels_as_the_head_turns() -> None:
    settings = EmulatedAxisSettings()
    width, height = 500, 300
    step = settings.angle_of_view_deg / width
    here = panorama(HeadState(pan_deg=10.03, tilt_deg=-20.03), settings, width, height)
    right = panorama(HeadState(pan_deg=10.03 + 40 * step, tilt_deg=-20.03), settings, width, height)
    up = panorama(HeadState(pan_deg=10.03, tilt_deg=-20.03 + 30 * step), settings, width, height)
    clear_of_text = slice(0, 200)
    assert np.array_equal(here[clear_of_text, 40:], right[clear_of_text, :-40])
    assert np.array_equal(here[:150], up[30:180])


def test_a_head_sent_somewhere_arrives_when_its_speed_says() -> None:
    clock = SimulatedClock()
    camera = EmulatedAxisCamera(EmulatedAxisSettings(speed_deg_s=100.0), clock=clock)
    camera.head.go_to(pan_deg=50.0, tilt_deg=-80.0)
    clock.sleep(0.25)
    assert camera.state().pan_deg == pytest.approx(25.0)
    clock.sleep(0.5)
    assert camera.state().pan_deg == pytest.approx(50.0)
    assert camera.state().tilt_deg == pytest.approx(-75.0)
    clock.sleep(0.25)
    assert camera.state().tilt_deg == pytest.approx(-80.0)
