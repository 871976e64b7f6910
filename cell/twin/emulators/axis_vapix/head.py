"""The head that pans, tilts and zooms, on somebody else's clock."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

from cell.drivers.axis_vapix.tables import DIRECTIONS, LENS, Direction
from cell.twin.emulators.axis_vapix.settings import EmulatedAxisSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadState:
    """Where the head points and how the lens is set."""

    pan_deg: float = 0.0
    tilt_deg: float = 0.0
    zoom: float = 1.0
    focus: float = 4642.0
    iris: float = 5748.0
    brightness: float = 4999.0
    has_autofocus: bool = True
    has_autoiris: bool = True


class Head:
    """Moves to where it was sent, or on and on, as time passes; threads may share it.

    Args:
        settings: How far and how fast it goes.
        now_s: The time.
    """

    def __init__(self, settings: EmulatedAxisSettings, now_s: Callable[[], float]) -> None:
        self._settings = settings
        self._now_s = now_s
        self._lock = threading.RLock()
        self._state = HeadState()
        self._target = self._state
        self._sweep = (0.0, 0.0, 0.0, 0.0)
        self._share = 1.0
        self._at_s = now_s()

    def state(self) -> HeadState:
        """Return where it is now."""
        with self._lock:
            self._move_on()
            return self._state

    def angle_of_view_deg(self) -> float:
        """Return the horizontal angle of view at the zoom of now."""
        return angle_of_view_deg(self.state(), self._settings)

    def go_to(
        self,
        *,
        pan_deg: float | None = None,
        tilt_deg: float | None = None,
        zoom: float | None = None,
        speed_percent: float = 100.0,
    ) -> None:
        """Set out for a position, as far as the head reaches."""
        with self._lock:
            self._move_on()
            self._sweep = (0.0, 0.0, 0.0, 0.0)
            self._share = speed_percent / 100.0
            settings, target = self._settings, self._target
            if pan_deg is not None:
                target = replace(target, pan_deg=_within(pan_deg, *settings.pan_deg))
            if tilt_deg is not None:
                target = replace(target, tilt_deg=_within(tilt_deg, *settings.tilt_deg))
            if zoom is not None:
                target = replace(target, zoom=_within(zoom, LENS.least, LENS.most))
            self._target = target

    def go_by(
        self,
        *,
        pan_deg: float = 0.0,
        tilt_deg: float = 0.0,
        zoom: float = 0.0,
        speed_percent: float = 100.0,
    ) -> None:
        """Set out for a position beside the one that it is on its way to."""
        with self._lock:
            target = self._target
            self.go_to(
                pan_deg=target.pan_deg + pan_deg,
                tilt_deg=target.tilt_deg + tilt_deg,
                zoom=target.zoom + zoom,
                speed_percent=speed_percent,
            )

    def step(self, direction: Direction) -> None:
        """Turn a bit."""
        pan, tilt = DIRECTIONS[direction]
        self.go_by(pan_deg=pan * self._settings.step_deg, tilt_deg=tilt * self._settings.step_deg)

    def sweep(
        self,
        *,
        pan_percent: float | None = None,
        tilt_percent: float | None = None,
        zoom_percent: float | None = None,
        focus_percent: float | None = None,
    ) -> None:
        """Go on and on at shares of the full speed; what is None goes on as it did."""
        with self._lock:
            self._move_on()
            self._target = self._state
            given = (pan_percent, tilt_percent, zoom_percent, focus_percent)
            pairs = zip(given, self._sweep, strict=True)
            pan, tilt, zoom, focus = (old if new is None else new / 100 for new, old in pairs)
            self._sweep = (pan, tilt, zoom, focus)

    def stop(self) -> None:
        """Stay where it is."""
        with self._lock:
            self._move_on()
            self._target = self._state
            self._sweep = (0.0, 0.0, 0.0, 0.0)

    def set_lens(
        self,
        *,
        focus: float | None = None,
        iris: float | None = None,
        brightness: float | None = None,
        has_autofocus: bool | None = None,
        has_autoiris: bool | None = None,
    ) -> None:
        """Set the lens, at once; a focus or an iris set by hand ends its automatic."""
        with self._lock:
            self._move_on()
            state = self._state
            if focus is not None:
                state = replace(state, focus=focus, has_autofocus=False)
            if iris is not None:
                state = replace(state, iris=iris, has_autoiris=False)
            if brightness is not None:
                state = replace(state, brightness=brightness)
            if has_autofocus is not None:
                state = replace(state, has_autofocus=has_autofocus)
            if has_autoiris is not None:
                state = replace(state, has_autoiris=has_autoiris)
            self._state = state
            self._target = replace(
                state,
                pan_deg=self._target.pan_deg,
                tilt_deg=self._target.tilt_deg,
                zoom=self._target.zoom,
            )

    def _move_on(self) -> None:
        now_s = self._now_s()
        passed_s, self._at_s = now_s - self._at_s, now_s
        turned = self._settings.speed_deg_s * passed_s
        zoomed = (LENS.most - LENS.least) / self._settings.zoom_s * passed_s
        if any(self._sweep):
            self._sweep_on(turned, zoomed)
            return
        state, target = self._state, self._target
        self._state = replace(
            state,
            pan_deg=_towards(state.pan_deg, target.pan_deg, turned * self._share),
            tilt_deg=_towards(state.tilt_deg, target.tilt_deg, turned * self._share),
            zoom=_towards(state.zoom, target.zoom, zoomed),
        )

    def _sweep_on(self, turned: float, zoomed: float) -> None:
        pan, tilt, zoom, focus = self._sweep
        state, settings = self._state, self._settings
        self._state = self._target = replace(
            state,
            pan_deg=_within(state.pan_deg + pan * turned, *settings.pan_deg),
            tilt_deg=_within(state.tilt_deg + tilt * turned, *settings.tilt_deg),
            zoom=_within(state.zoom + zoom * zoomed, LENS.least, LENS.most),
            focus=_within(state.focus + focus * zoomed, LENS.least, LENS.most),
        )


def angle_of_view_deg(state: HeadState, settings: EmulatedAxisSettings) -> float:
    """Return the horizontal angle of view at a zoom."""
    share = (state.zoom - LENS.least) / (LENS.most - LENS.least)
    return settings.angle_of_view_deg / (1.0 + share * (settings.most_zoom - 1.0))


def _within(value: float, least: float, most: float) -> float:
    return min(max(value, least), most)


def _towards(value: float, target: float, step: float) -> float:
    return target if abs(target - value) <= step else value + (step if target > value else -step)
