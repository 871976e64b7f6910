"""The AXIS web camera: pictures, and where it looks."""

from __future__ import annotations

import logging

from cell.clock import Clock, SystemClock
from cell.drivers.axis_vapix import requests
from cell.drivers.axis_vapix.exchange import Address, Exchange, Reply
from cell.drivers.axis_vapix.replies import (
    HeadLimits,
    HeadPosition,
    MalformedReply,
    error_text,
    parse_limits,
    parse_position,
    parse_presets,
    parse_values,
    whole_jpeg,
)
from cell.drivers.axis_vapix.settings import AxisSettings
from cell.drivers.axis_vapix.stream import AxisStream, WebPicture
from cell.drivers.axis_vapix.tables import HEAD_PATH, Direction
from cell.errors import DeviceError, DeviceTimeout
from cell.profile import WebCameraProfile

_LOGGER = logging.getLogger(__name__)
_NOT_TOLD = (401, 403, 404)


class AxisCamera:
    """A web camera that speaks VAPIX over HTTP.

    Each call is a request of its own, so there is nothing to keep open; a camera that
    was away is simply asked again.

    Args:
        profile: The camera's table in the profile.
        clock: The cell's clock: time of pictures, and of a head that is waited for.
        settings: What the profile does not say.
        net_clock: What deadlines of the net are measured with; real time unless given.

    Raises:
        ProfileError: The profile's url cannot be used.
    """

    def __init__(
        self,
        profile: WebCameraProfile,
        clock: Clock,
        settings: AxisSettings | None = None,
        *,
        net_clock: Clock | None = None,
    ) -> None:
        self._settings = AxisSettings() if settings is None else settings
        self._model = profile.model
        self._clock = clock
        self._address = Address.from_profile(profile)
        self._exchange = Exchange(
            self._address,
            SystemClock() if net_clock is None else net_clock,
            device=self._settings.device,
            user_agent=self._settings.user_agent,
            timeout_s=profile.timeout_s,
        )
        self._identity = ""
        self._has_head: bool | None = None

    def open(self) -> str:
        """Check that the camera is there and return the identity; again is harmless.

        Raises:
            DeviceError: It does not let the user in, or what answers is no AXIS camera.
            DeviceTimeout: Nothing answers.
        """
        if not self._identity:
            head = self.head_name()
            name = self._full_name() or f"AXIS camera ({self._model})"
            told = f"head {head}" if head is not None else "fixed, no pan, tilt or zoom"
            self._identity = f"{name} at {self._address.text}, {told}"
        return self._identity

    def close(self) -> None:
        """Forget the identity, so that `open` asks again."""
        self._identity = ""
        self._has_head = None

    @property
    def has_head(self) -> bool:
        """Whether the camera turns and zooms; asked once."""
        if self._has_head is None:
            self.head_name()
        return bool(self._has_head)

    def still(self, width_px: int = 640, height_px: int = 480, compression: int = 30) -> WebPicture:
        """Return one picture.

        Args:
            width_px: Width; the camera offers a few sizes only.
            height_px: Height.
            compression: 0 to 100, the higher the smaller the file.

        Raises:
            ValueRefused: A value is out of range.
            DeviceError: The camera refuses, or sends no whole picture.
            DeviceTimeout: It does not answer in time.
        """
        reply = self._get(requests.still_target(width_px, height_px, compression))
        try:
            jpeg = whole_jpeg(reply.body)
        except MalformedReply as error:
            raise self._nonsense(error) from error
        return WebPicture(number=1, time_s=self._clock.now_s(), jpeg=jpeg)

    def stream(
        self,
        width_px: int = 640,
        height_px: int = 480,
        compression: int = 30,
        rate_hz: int = 0,
    ) -> AxisStream:
        """Return a stream of pictures, which connects when the first one is asked for.

        Args:
            width_px: Width of the pictures.
            height_px: Height of the pictures.
            compression: 0 to 100, the higher the smaller the pictures.
            rate_hz: Pictures a second, 0 for the camera's own rate.

        Raises:
            ValueRefused: A value is out of range.
        """
        target = requests.stream_target(width_px, height_px, compression, rate_hz)
        return AxisStream(self._exchange, target, self._settings, self._clock.now_s)

    def position(self) -> HeadPosition:
        """Return where the head points and how the lens is set."""
        reply = self._ask_head(requests.query_target("position"))
        try:
            return parse_position(reply.body)
        except MalformedReply as error:
            raise self._nonsense(error) from error

    def limits(self) -> HeadLimits:
        """Return how far the head turns and zooms, as far as it tells."""
        reply = self._ask_head(requests.query_target("limits"))
        try:
            return parse_limits(reply.body)
        except MalformedReply as error:
            raise self._nonsense(error) from error

    def move_to(
        self,
        *,
        pan_deg: float | None = None,
        tilt_deg: float | None = None,
        zoom: int | None = None,
        speed: int | None = None,
    ) -> None:
        """Point the head; what is None stays. The camera answers before it has arrived.

        Raises:
            ValueRefused: A value is out of range (180 deg, zoom 1 to 9999), or none is given.
            DeviceError: The camera has no head, or refuses.
        """
        self._ask_head(requests.absolute_target(pan_deg, tilt_deg, zoom, speed))

    def move_by(
        self,
        *,
        pan_deg: float | None = None,
        tilt_deg: float | None = None,
        zoom: int | None = None,
        speed: int | None = None,
    ) -> None:
        """Turn the head by so much; the camera answers before it has arrived."""
        self._ask_head(requests.relative_target(pan_deg, tilt_deg, zoom, speed))

    def step(self, direction: Direction) -> None:
        """Turn the head a bit: some 5 deg on heads that know their position."""
        self._ask_head(requests.step_target(direction))

    def home(self) -> None:
        """Point the head to its home position."""
        self._ask_head(requests.step_target("home"))

    def sweep(self, pan_percent: int, tilt_percent: int) -> None:
        """Turn the head on and on, -100 to 100 % of its speed, until `stop`."""
        self._ask_head(requests.sweep_target(pan_percent, tilt_percent))

    def sweep_zoom(self, percent: int) -> None:
        """Zoom on and on, -100 to 100 % of its speed, until `stop`."""
        self._ask_head(requests.lens_sweep_target("zoom", percent))

    def sweep_focus(self, percent: int) -> None:
        """Move the focus on and on, -100 to 100 % of its speed, until `stop`."""
        self._ask_head(requests.lens_sweep_target("focus", percent))

    def stop(self) -> None:
        """Stop head, zoom and focus."""
        self._ask_head(requests.sweep_target(0, 0))
        self._ask_head(requests.lens_sweep_target("zoom", 0))
        self._ask_head(requests.lens_sweep_target("focus", 0))
        self._ask_head(requests.step_target("stop"))

    def centre_on(self, column_px: int, row_px: int, width_px: int, height_px: int) -> None:
        """Turn the head so that a point of a picture of that size comes to its middle."""
        self._ask_head(requests.centre_target(column_px, row_px, width_px, height_px))

    def presets(self) -> dict[int, str]:
        """Return the stored positions: names by number."""
        return parse_presets(self._ask_head(requests.query_target("presetposall")).body)

    def go_to_preset(self, name: str) -> None:
        """Point the head to a stored position.

        Raises:
            DeviceError: The camera has none of that name; the text lists those it has.
        """
        known = self.presets()
        if name not in known.values():
            listed = ", ".join(known.values()) or "none"
            raise DeviceError(
                self._settings.device, f"has no preset {name!r}", hint=f"there are: {listed}"
            )
        self._ask_head(requests.preset_target(name))

    def set_autofocus(self, *, is_on: bool) -> None:
        """Have the camera focus by itself, or leave the focus."""
        self._ask_head(requests.switch_target("autofocus", is_on=is_on))

    def set_autoiris(self, *, is_on: bool) -> None:
        """Have the camera set its iris by itself, or leave it."""
        self._ask_head(requests.switch_target("autoiris", is_on=is_on))

    def set_focus(self, value: int) -> None:
        """Set the focus, 1 to 9999."""
        self._ask_head(requests.lens_target("focus", value))

    def set_iris(self, value: int) -> None:
        """Set the iris, 1 to 9999."""
        self._ask_head(requests.lens_target("iris", value))

    def set_brightness(self, value: int) -> None:
        """Set the brightness, 1 to 9999; without effect on an AXIS 214."""
        self._ask_head(requests.lens_target("brightness", value))

    def head_name(self) -> str | None:
        """Return the name of the head's driver, or None for a fixed camera."""
        try:
            reply = self._exchange.get(requests.whoami_target())
        except DeviceError as error:
            if error.code != 404:
                raise
            self._has_head = False
            return None
        # A camera with the function but without a head behind it answers with a complaint.
        self._has_head = error_text(reply.body) is None
        name = reply.body.decode("utf-8", "replace").strip() or "without a name"
        return name if self._has_head else None

    def parameters(self, group: str = "") -> dict[str, str]:
        """Return the camera's parameters of a group such as `Brand`, by full name."""
        return parse_values(self._get(requests.parameters_target(group)).body)

    def wait_until_still(self) -> HeadPosition:
        """Return the position when the head has come to rest.

        Raises:
            DeviceTimeout: It still moves after the time that a head may take.
        """
        settings = self._settings
        deadline_s = self._clock.now_s() + settings.travel_timeout_s
        before = self.position()
        while self._clock.now_s() < deadline_s:
            self._clock.sleep(settings.poll_s)
            after = self.position()
            if _is_same(before, after, settings.still_deg):
                return after
            before = after
        raise DeviceTimeout(
            settings.device,
            f"the head still moves after {settings.travel_timeout_s:g} s",
            hint="stop it: `cell webcam stop`",
        )

    def _full_name(self) -> str:
        try:
            told = self.parameters("Brand")
        except DeviceError as error:
            if error.code not in _NOT_TOLD:
                raise
            _LOGGER.debug("%s: does not tell its name", self._settings.device)
            return ""
        named = {name.lower().rpartition(".")[2]: value for name, value in told.items()}
        return named.get("prodfullname") or named.get("prodshortname", "")

    def _ask_head(self, target: str) -> Reply:
        if not self.has_head:
            raise DeviceError(
                self._settings.device,
                "is a fixed camera: it has no pan, tilt or zoom",
                code=404,
                hint=f"it has no {HEAD_PATH}; turn it by hand",
            )
        return self._get(target)

    def _get(self, target: str) -> Reply:
        reply = self._exchange.get(target)
        complaint = error_text(reply.body)
        if complaint is not None:
            raise DeviceError(
                self._settings.device,
                f"did not understand {target.partition('?')[2]!r}: {complaint}",
                hint="see whether the model has this function",
            )
        return reply

    def _nonsense(self, error: MalformedReply) -> DeviceError:
        return DeviceError(
            self._settings.device,
            f"sent {error}",
            hint="see whether web_camera.url is the camera's address, then ask again",
        )


def _is_same(before: HeadPosition, after: HeadPosition, tolerance: float) -> bool:
    pairs = (
        (before.pan_deg, after.pan_deg),
        (before.tilt_deg, after.tilt_deg),
        (before.zoom, after.zoom),
    )
    return all(old is None or new is None or abs(new - old) <= tolerance for old, new in pairs)
