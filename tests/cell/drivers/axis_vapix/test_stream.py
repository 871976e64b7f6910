"""The stream: pictures through every kind of boundary and fault, and an end when asked."""

from __future__ import annotations

import itertools
import threading

import numpy as np
import pytest

from cell.clock import SimulatedClock
from cell.drivers.axis_vapix import AxisSettings
from cell.errors import DeviceError, DeviceTimeout
from cell.twin.emulators.axis_vapix import (
    EmulatedAxisCamera,
    EmulatedAxisSettings,
    WebCameraFault,
)
from tests.cell.drivers.axis_vapix.bench import SECRET, VARIABLE, driver, pixels

FAST = 1000.0


@pytest.mark.parametrize("names_dashes", [False, True])
@pytest.mark.parametrize("quotes", [False, True])
@pytest.mark.parametrize("tells_length", [False, True])
def test_pictures_come_whatever_the_camera_writes_around_them(
    names_dashes: bool, quotes: bool, tells_length: bool
) -> None:
    settings = EmulatedAxisSettings(
        names_dashes=names_dashes, quotes_boundary=quotes, tells_length=tells_length, rate_hz=FAST
    )
    with EmulatedAxisCamera(settings) as emulated, driver(emulated).stream(160, 120) as stream:
        pictures = list(itertools.islice(stream, 5))
        assert [picture.number for picture in pictures] == [1, 2, 3, 4, 5]
        assert pixels(pictures[-1]).shape == (120, 160, 3)
        assert (stream.reconnects, stream.broken) == (0, 0)


def test_the_stream_follows_the_head() -> None:
    clock = SimulatedClock()
    settings = EmulatedAxisSettings(rate_hz=FAST)
    with EmulatedAxisCamera(settings, clock=clock) as emulated:
        camera = driver(emulated, clock)
        with camera.stream(160, 120) as stream:
            first = pixels(next(stream)).astype(int)
            camera.move_to(pan_deg=60)
            camera.wait_until_still()
            changed = (np.abs(pixels(p) - first).mean() > 10 for p in itertools.islice(stream, 200))
            assert any(changed)


def test_a_stream_of_a_protected_camera_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, SECRET)
    settings = EmulatedAxisSettings(auth="digest", password=SECRET, rate_hz=FAST)
    with EmulatedAxisCamera(settings) as emulated:
        camera = driver(emulated, user="root", variable=VARIABLE)
        with camera.stream(160, 120) as stream:
            assert next(stream).number == 1


@pytest.mark.parametrize(
    "fault", [WebCameraFault.CUT_OFF, WebCameraFault.DROPPED, WebCameraFault.BUSY]
)
@pytest.mark.parametrize("times", [1, 3])
def test_a_broken_connection_is_opened_anew(fault: WebCameraFault, times: int) -> None:
    with EmulatedAxisCamera(EmulatedAxisSettings(rate_hz=FAST)) as emulated:
        emulated.inject(fault, times)
        with driver(emulated).stream(160, 120) as stream:
            assert [picture.number for picture in itertools.islice(stream, 3)] == [1, 2, 3]
            assert stream.reconnects == times


def test_a_connection_that_breaks_in_the_middle_loses_no_count() -> None:
    with (
        EmulatedAxisCamera(EmulatedAxisSettings(rate_hz=FAST)) as emulated,
        driver(emulated).stream(160, 120) as stream,
    ):
        next(stream)
        emulated.inject(WebCameraFault.CUT_OFF, 1)
        numbers = [picture.number for picture in itertools.islice(stream, 20)]
        assert numbers == list(range(2, 22))
        assert stream.reconnects == 1


def test_failures_that_pictures_lie_between_do_not_add_up() -> None:
    with (
        EmulatedAxisCamera(EmulatedAxisSettings(rate_hz=FAST)) as emulated,
        driver(emulated).stream(160, 120) as stream,
    ):
        for rounds in range(1, 4):
            emulated.inject(WebCameraFault.CUT_OFF, 3)
            for _ in range(50):
                next(stream)
                if stream.reconnects == 3 * rounds:
                    break
            assert stream.reconnects == 3 * rounds
        assert next(stream).jpeg


def test_a_picture_that_stops_in_its_middle_is_given_up_and_the_stream_goes_on() -> None:
    quick = AxisSettings(part_timeout_s=0.3, least_back_off_s=0.001)
    with EmulatedAxisCamera(EmulatedAxisSettings(rate_hz=FAST)) as emulated:
        emulated.inject(WebCameraFault.SLOW, 1)
        with driver(emulated, settings=quick).stream(160, 120) as stream:
            assert next(stream).number == 1
            assert stream.reconnects == 1


def test_broken_pictures_are_left_out_and_counted() -> None:
    with EmulatedAxisCamera(EmulatedAxisSettings(rate_hz=FAST)) as emulated:
        emulated.inject(WebCameraFault.BROKEN_JPEG, 2)
        with driver(emulated).stream(160, 120) as stream:
            assert next(stream).number == 1
            assert (stream.broken, stream.reconnects) == (2, 0)


def test_a_stream_that_fails_again_and_again_is_given_up_with_the_last_reason() -> None:
    with EmulatedAxisCamera(EmulatedAxisSettings(rate_hz=FAST)) as emulated:
        emulated.inject(WebCameraFault.BUSY)
        with (
            driver(emulated).stream(160, 120) as stream,
            pytest.raises(
                DeviceTimeout, match="failed 5 times in a row, at last: is busy"
            ) as caught,
        ):
            next(stream)
        assert caught.value.code == 503
        assert len(emulated.requests) == 5


def test_a_refused_user_is_not_tried_again_and_again() -> None:
    with (
        EmulatedAxisCamera(EmulatedAxisSettings(auth="basic")) as emulated,
        driver(emulated).stream() as stream,
    ):
        with pytest.raises(DeviceError, match="wants a user"):
            next(stream)
        assert len(emulated.requests) == 1


def test_more_viewers_than_the_camera_takes_are_told_so() -> None:
    settings = EmulatedAxisSettings(rate_hz=FAST, most_viewers=1)
    with EmulatedAxisCamera(settings) as emulated:
        camera = driver(emulated)
        with camera.stream(160, 120) as first:
            next(first)
            with camera.stream(160, 120) as second, pytest.raises(DeviceTimeout, match="viewers"):
                next(second)


def test_stop_ends_a_wait_for_a_picture_at_once() -> None:
    patient = AxisSettings(part_timeout_s=60.0)
    with EmulatedAxisCamera(EmulatedAxisSettings(rate_hz=FAST)) as emulated:
        stream = driver(emulated, settings=patient).stream(160, 120)
        next(stream)
        emulated.inject(WebCameraFault.SLOW)
        rest: list[int] = []
        worker = threading.Thread(target=lambda: rest.extend(p.number for p in stream))
        worker.start()
        stream.stop()
        worker.join(10.0)
        assert not worker.is_alive()
        assert list(stream) == []


def test_stop_ends_a_pause_between_two_attempts_at_once() -> None:
    slow = AxisSettings(least_back_off_s=60.0, most_back_off_s=60.0)
    with EmulatedAxisCamera() as emulated:
        emulated.inject(WebCameraFault.DROPPED)
        stream = driver(emulated, settings=slow).stream()
        worker = threading.Thread(target=lambda: list(stream))
        worker.start()
        while not emulated.requests:
            worker.join(0.005)
        stream.stop()
        worker.join(10.0)
        assert not worker.is_alive()


def test_pauses_grow_up_to_a_limit() -> None:
    settings = AxisSettings(least_back_off_s=0.25, most_back_off_s=4.0)
    assert [settings.back_off_s(n) for n in (1, 2, 3, 4, 5, 6, 5000)] == [
        0.25, 0.5, 1.0, 2.0, 4.0, 4.0, 4.0,
    ]  # fmt: skip


def test_what_is_no_stream_is_told_with_the_cameras_own_words() -> None:
    with EmulatedAxisCamera() as emulated, driver(emulated).stream(161, 120) as stream:
        with pytest.raises(DeviceError, match="gives no stream: resolution 161x120 is not supp"):
            next(stream)
        assert len(emulated.requests) == 1
