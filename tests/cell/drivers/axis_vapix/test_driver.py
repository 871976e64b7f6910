"""The driver against the emulated camera: what works, and what each failure says."""

from __future__ import annotations

import logging
import socket
import threading

import numpy as np
import pytest

from cell.clock import SimulatedClock
from cell.drivers.axis_vapix import AxisCamera, AxisSettings
from cell.drivers.axis_vapix.requests import ValueRefused
from cell.drivers.axis_vapix.tables import DIRECTIONS, Direction
from cell.errors import CellError, DeviceError, DeviceTimeout, ProfileError
from cell.twin.emulators.axis_vapix import (
    AuthMode,
    EmulatedAxisCamera,
    EmulatedAxisSettings,
    WebCameraFault,
)
from tests.cell.drivers.axis_vapix.bench import SECRET, VARIABLE, driver, pixels, profile


def test_a_camera_tells_who_it_is_once() -> None:
    with EmulatedAxisCamera() as emulated:
        camera = driver(emulated)
        identity = camera.open()
        assert identity.startswith("AXIS 211 PTZ Network Camera at 127.0.0.1:")
        assert identity.endswith("head AXIS PTZ camera driver")
        asked = len(emulated.requests)
        assert camera.open() == identity
        assert len(emulated.requests) == asked
        camera.close()
        camera.open()
        assert len(emulated.requests) > asked


def test_a_still_has_the_size_that_was_asked_for_and_the_cells_time() -> None:
    clock = SimulatedClock(12.5)
    with EmulatedAxisCamera() as emulated:
        picture = driver(emulated, clock).still(320, 240, 10)
        assert pixels(picture).shape == (240, 320, 3)
        assert picture.time_s == 12.5
        smaller = driver(emulated).still(320, 240, 90)
        assert len(smaller.jpeg) < len(picture.jpeg)


def test_the_picture_changes_with_pan_tilt_and_zoom_and_comes_back() -> None:
    clock = SimulatedClock()
    with EmulatedAxisCamera(clock=clock) as emulated:
        camera = driver(emulated, clock)
        first = pixels(camera.still())
        seen = [first]
        for pan_deg, tilt_deg, zoom in (
            (30.0, None, None),
            (None, -20.0, None),
            (None, None, 5000),
        ):
            camera.move_to(pan_deg=pan_deg, tilt_deg=tilt_deg, zoom=zoom)
            camera.wait_until_still()
            seen.append(pixels(camera.still()))
        for earlier, later in zip(seen, seen[1:], strict=False):
            assert np.abs(earlier.astype(int) - later).mean() > 10
        camera.home()
        camera.wait_until_still()
        assert np.array_equal(pixels(camera.still()), first)


def test_absolute_and_relative_moves_arrive_and_stop_at_the_heads_limits() -> None:
    clock = SimulatedClock()
    with EmulatedAxisCamera(clock=clock) as emulated:
        camera = driver(emulated, clock)
        camera.move_to(pan_deg=30, tilt_deg=-10, zoom=500)
        there = camera.wait_until_still()
        assert (there.pan_deg, there.tilt_deg, there.zoom) == (30.0, -10.0, 500)
        camera.move_by(pan_deg=5, tilt_deg=-5, zoom=100)
        there = camera.wait_until_still()
        assert (there.pan_deg, there.tilt_deg, there.zoom) == (35.0, -15.0, 600)
        camera.move_to(pan_deg=180)
        limits = camera.limits()
        assert limits.pan_deg == (-170.0, 170.0)
        assert camera.wait_until_still().pan_deg == 170.0


def test_a_slower_move_takes_longer() -> None:
    clock = SimulatedClock()
    with EmulatedAxisCamera(clock=clock) as emulated:
        camera = driver(emulated, clock)
        camera.move_to(pan_deg=100, speed=10)
        clock.sleep(5.0)
        assert camera.position().pan_deg == pytest.approx(50.0)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_a_step_goes_in_its_direction(direction: Direction) -> None:
    clock = SimulatedClock()
    with EmulatedAxisCamera(clock=clock) as emulated:
        camera = driver(emulated, clock)
        camera.step(direction)
        there = camera.wait_until_still()
        pan, tilt = DIRECTIONS[direction]
        assert (there.pan_deg, there.tilt_deg) == (5.0 * pan, 5.0 * tilt)


def test_a_sweep_goes_on_until_it_is_stopped() -> None:
    clock = SimulatedClock()
    with EmulatedAxisCamera(clock=clock) as emulated:
        camera = driver(emulated, clock)
        camera.sweep(50, -20)
        camera.sweep_zoom(50)
        clock.sleep(1.0)
        camera.stop()
        there = camera.position()
        assert there.pan_deg == pytest.approx(50.0)
        assert there.tilt_deg == pytest.approx(-20.0)
        assert there.zoom == pytest.approx(1667, abs=1)
        clock.sleep(5.0)
        assert camera.position() == there
        camera.sweep_focus(-10)
        clock.sleep(1.0)
        camera.sweep_focus(0)
        assert camera.position().focus == pytest.approx(4642 - 333, abs=1)


def test_a_head_that_does_not_come_to_rest_is_reported() -> None:
    clock = SimulatedClock()
    settings = AxisSettings(poll_s=0.1, travel_timeout_s=1.0)
    with EmulatedAxisCamera(clock=clock) as emulated:
        camera = driver(emulated, clock, settings)
        camera.sweep(10, 0)
        with pytest.raises(DeviceTimeout, match=r"still moves after 1 s.*webcam stop"):
            camera.wait_until_still()


def test_click_to_centre_brings_the_point_to_the_middle() -> None:
    clock = SimulatedClock()
    with EmulatedAxisCamera(clock=clock) as emulated:
        camera = driver(emulated, clock)
        camera.centre_on(480, 120, 640, 480)
        there = camera.wait_until_still()
        assert there.pan_deg == pytest.approx(12.5, abs=0.01)
        assert there.tilt_deg == pytest.approx(9.375, abs=0.01)


def test_presets_are_listed_and_reached_and_an_unknown_one_is_not_sent() -> None:
    clock = SimulatedClock()
    with EmulatedAxisCamera(clock=clock) as emulated:
        camera = driver(emulated, clock)
        assert camera.presets() == {1: "Home", 2: "table", 3: "store"}
        camera.go_to_preset("table")
        assert camera.wait_until_still().tilt_deg == -40.0
        with pytest.raises(DeviceError, match="no preset 'roof'; there are: Home, table, store"):
            camera.go_to_preset("roof")
        assert not any("roof" in request for request in emulated.requests)


def test_focus_iris_and_brightness_are_set_and_change_the_picture() -> None:
    with EmulatedAxisCamera() as emulated:
        camera = driver(emulated)
        before = pixels(camera.still())
        camera.set_brightness(9000)
        camera.set_focus(100)
        camera.set_iris(2000)
        there = camera.position()
        assert (there.brightness, there.focus, there.iris) == (9000, 100, 2000)
        assert (there.has_autofocus, there.has_autoiris) == (False, False)
        after = pixels(camera.still())
        assert after.mean() > before.mean() + 20
        camera.set_autofocus(is_on=True)
        camera.set_autoiris(is_on=True)
        assert camera.position().has_autofocus is True
        sharp = pixels(camera.still())
        assert (
            np.abs(np.diff(sharp.astype(int), axis=1)).mean()
            > 1.1 * np.abs(np.diff(after.astype(int), axis=1)).mean()
        )


def test_parameters_are_listed_by_group() -> None:
    with EmulatedAxisCamera() as emulated:
        told = driver(emulated).parameters("Brand")
        assert told["root.Brand.Brand"] == "AXIS"
        assert "root.Properties.PTZ.PTZ" not in told


@pytest.mark.parametrize(
    "settings",
    [EmulatedAxisSettings(has_head=False), EmulatedAxisSettings(has_head_driver=False)],
    ids=["no ptz.cgi", "no driver"],
)
def test_a_fixed_camera_is_found_out_and_said(settings: EmulatedAxisSettings) -> None:
    with EmulatedAxisCamera(settings) as emulated:
        camera = driver(emulated)
        assert "fixed, no pan, tilt or zoom" in camera.open()
        assert not camera.has_head
        with pytest.raises(DeviceError, match="fixed camera.*by hand"):
            camera.home()
        assert not any("move=home" in request for request in emulated.requests)
        assert camera.still().jpeg


def test_a_value_out_of_range_sends_nothing() -> None:
    with EmulatedAxisCamera() as emulated:
        camera = driver(emulated)
        with pytest.raises(ValueRefused):
            camera.move_to(pan_deg=200)
        assert emulated.requests == ()


# --- who may -------------------------------------------------------------------------------


@pytest.mark.parametrize("auth", ["basic", "digest", "both"])
@pytest.mark.parametrize("browser", [False, True])
def test_every_way_of_asking_for_the_password_is_answered(
    auth: AuthMode, browser: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, SECRET)
    settings = EmulatedAxisSettings(auth=auth, password=SECRET, needs_browser=browser)
    with EmulatedAxisCamera(settings) as emulated:
        camera = driver(emulated, user="root", variable=VARIABLE)
        camera.open()
        asked = len(emulated.requests)
        for _ in range(3):
            camera.still(160, 120)
        assert len(emulated.requests) == asked + 3, "only the first request is asked twice"


def test_a_nonce_that_has_grown_old_is_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, SECRET)
    settings = EmulatedAxisSettings(auth="digest", password=SECRET, nonce_uses=2)
    with EmulatedAxisCamera(settings) as emulated:
        camera = driver(emulated, user="root", variable=VARIABLE)
        for _ in range(7):
            camera.still(160, 120)


@pytest.mark.parametrize("auth", ["basic", "digest"])
@pytest.mark.parametrize(
    ("user", "variable", "value", "message"),
    [
        ("", "", "", r"wants a user and a password \(error 401\); set user and password_variable"),
        ("root", "", "", "does not let 'root' in without a password.*set password_variable"),
        ("root", VARIABLE, "", f"the password of 'root'.*environment variable {VARIABLE}"),
        ("root", VARIABLE, SECRET, f"does not let 'root' in with the password in {VARIABLE}"),
    ],
    ids=["no user", "no variable", "variable not set", "wrong password"],
)
def test_a_refusal_says_what_is_missing_and_never_the_password(
    auth: AuthMode,
    user: str,
    variable: str,
    value: str,
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.DEBUG)
    monkeypatch.delenv(VARIABLE, raising=False)
    if value:
        monkeypatch.setenv(VARIABLE, value)
    with EmulatedAxisCamera(EmulatedAxisSettings(auth=auth)) as emulated:
        camera = driver(emulated, user=user, variable=variable)
        with pytest.raises(DeviceError, match=message) as caught:
            camera.open()
        assert caught.value.code == 401
        assert len(emulated.requests) <= 2
    assert SECRET not in f"{caught.value!r} {caught.value.__cause__!r} {caplog.text} {camera!r}"


def test_a_user_who_may_not_read_parameters_still_gets_an_identity() -> None:
    with EmulatedAxisCamera(EmulatedAxisSettings(tells_name=False)) as emulated:
        assert driver(emulated).open().startswith("AXIS camera (axis-211) at ")


@pytest.mark.parametrize(
    "url",
    [
        "http://root:hidden@192.168.0.90",
        "https://192.168.0.90",
        "192.168.0.90",
        "http://",
        "http://h/some/page",
        "http://h:port",
        "",
    ],
)
def test_an_address_that_cannot_be_used_is_refused_and_not_repeated(url: str) -> None:
    with pytest.raises(ProfileError, match=r"web_camera\.url") as caught:
        AxisCamera(profile(url), SimulatedClock())
    assert "hidden" not in str(caught.value)


def test_proxies_of_the_environment_are_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("http_proxy", "HTTP_PROXY", "all_proxy"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    with EmulatedAxisCamera() as emulated:
        assert driver(emulated).still(160, 120).jpeg


# --- what goes wrong -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "code", "message"),
    [
        (WebCameraFault.UNAUTHORISED, 401, "wants a user"),
        (WebCameraFault.FORBIDDEN, 403, "operator's rights"),
        (WebCameraFault.BUSY, 503, "too many viewers.*close other viewers"),
        (WebCameraFault.ERROR_TEXT, None, "did not understand 'resolution.*syntax error"),
        (WebCameraFault.BROKEN_JPEG, None, "no JPEG picture"),
        (WebCameraFault.CUT_OFF, None, "ended the connection before its answer was whole"),
        (WebCameraFault.DROPPED, None, "ended the connection before its answer was whole"),
    ],
    ids=lambda value: value.name if isinstance(value, WebCameraFault) else "",
)
def test_each_failure_of_a_still_has_its_sentence_and_passes(
    fault: WebCameraFault, code: int | None, message: str
) -> None:
    with EmulatedAxisCamera() as emulated:
        camera = driver(emulated)
        emulated.inject(fault)
        with pytest.raises(DeviceError, match=message) as caught:
            camera.still()
        assert caught.value.code == code
        assert caught.value.hint
        emulated.clear()
        assert camera.still().jpeg


@pytest.mark.parametrize("fault", [WebCameraFault.SILENT, WebCameraFault.SLOW])
def test_a_camera_that_does_not_finish_its_answer_is_given_up(fault: WebCameraFault) -> None:
    with EmulatedAxisCamera() as emulated:
        camera = driver(emulated, timeout_s=0.3)
        emulated.inject(fault)
        with pytest.raises(DeviceTimeout, match=r"no answer from .* within 0\.3 s.*power"):
            camera.still()


def test_an_answer_that_trickles_in_has_one_deadline_in_all() -> None:
    ended = threading.Event()

    def trickle(listener: socket.socket) -> None:
        line, _ = listener.accept()
        with line:
            line.recv(4096)
            try:
                while not ended.wait(0.02):
                    line.sendall(b"X")
            except OSError:
                return

    with socket.create_server(("127.0.0.1", 0)) as listener:
        worker = threading.Thread(target=trickle, args=[listener])
        worker.start()
        url = f"http://127.0.0.1:{listener.getsockname()[1]}"
        try:
            with pytest.raises(DeviceTimeout, match=r"within 0\.3 s"):
                AxisCamera(profile(url, timeout_s=0.3), SimulatedClock()).still()
        finally:
            ended.set()
            worker.join(10.0)


def test_nobody_at_the_address_is_said() -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    camera = AxisCamera(profile(f"http://127.0.0.1:{port}"), SimulatedClock())
    with pytest.raises(DeviceError, match=f"nothing takes requests at 127.0.0.1:{port}.*url"):
        camera.open()


@pytest.mark.parametrize("seed", range(6))
def test_whatever_answers_the_error_is_one_of_ours(seed: int) -> None:
    generator = np.random.default_rng(seed)
    answers = [
        b"",
        b"HTTP/1.1 200 OK\r\n\r\n",
        b"HTTP/1.1 200 OK\r\nContent-Length: 99\r\n\r\nshort",
        b"HTTP/1.1 xyz\r\n\r\n",
        b"SSH-2.0-OpenSSH\r\n",
        generator.bytes(400),
    ]

    def answer(listener: socket.socket) -> None:
        line, _ = listener.accept()
        with line:
            line.recv(4096)
            line.sendall(answers[seed])

    with socket.create_server(("127.0.0.1", 0)) as listener:
        worker = threading.Thread(target=answer, args=[listener])
        worker.start()
        url = f"http://127.0.0.1:{listener.getsockname()[1]}"
        with pytest.raises(CellError, match="web camera: "):
            AxisCamera(profile(url), SimulatedClock()).still()
        worker.join(10.0)
