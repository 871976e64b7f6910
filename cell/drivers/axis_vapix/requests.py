"""Requests as paths with their query, without I/O.

Values are checked here, before anything is sent.
"""

from __future__ import annotations

from collections.abc import Mapping
from urllib.parse import urlencode

from cell.drivers.axis_vapix.tables import (
    COMPRESSION,
    HEAD_PATH,
    LENS,
    PAN,
    PARAMETER_PATH,
    PERCENT,
    RELATIVE_ANGLE,
    RELATIVE_LENS,
    SPEED,
    STILL_PATH,
    STREAM_PATH,
    TILT,
    Direction,
    Span,
)
from cell.errors import CellError


class ValueRefused(CellError):
    """A value is outside of what the camera takes; nothing was sent."""


def still_target(width_px: int, height_px: int, compression: int) -> str:
    """Return the request of one picture."""
    fields = _picture(width_px, height_px, compression)
    return _target(STILL_PATH, fields)


def stream_target(width_px: int, height_px: int, compression: int, rate_hz: int) -> str:
    """Return the request of a stream; a rate of 0 is the camera's own."""
    fields = _picture(width_px, height_px, compression)
    fields["fps"] = str(int(_checked("rate", rate_hz, Span(0, 60, "Hz"))))
    return _target(STREAM_PATH, fields)


def absolute_target(
    pan_deg: float | None, tilt_deg: float | None, zoom: int | None, speed: int | None
) -> str:
    """Return the request that points the head; what is None stays.

    Raises:
        ValueRefused: A value is out of range, or there is none.
    """
    given = {
        "pan": _optional("pan", pan_deg, PAN),
        "tilt": _optional("tilt", tilt_deg, TILT),
        "zoom": _optional("zoom", zoom, LENS),
    }
    return _moving(given, speed)


def relative_target(
    pan_deg: float | None, tilt_deg: float | None, zoom: int | None, speed: int | None
) -> str:
    """Return the request that turns the head by so much.

    Raises:
        ValueRefused: A value is out of range, or there is none.
    """
    given = {
        "rpan": _optional("pan by", pan_deg, RELATIVE_ANGLE),
        "rtilt": _optional("tilt by", tilt_deg, RELATIVE_ANGLE),
        "rzoom": _optional("zoom by", zoom, RELATIVE_LENS),
    }
    return _moving(given, speed)


def step_target(direction: Direction | str) -> str:
    """Return the request of a step: a direction, `home` or `stop`."""
    return _target(HEAD_PATH, {"move": direction})


def sweep_target(pan_percent: int, tilt_percent: int) -> str:
    """Return the request that turns the head on and on; zeros stop it."""
    pan = int(_checked("pan speed", pan_percent, PERCENT))
    tilt = int(_checked("tilt speed", tilt_percent, PERCENT))
    return _target(HEAD_PATH, {"continuouspantiltmove": f"{pan},{tilt}"})


def lens_sweep_target(what: str, percent: int) -> str:
    """Return the request that moves `zoom` or `focus` on and on; zero stops it."""
    value = int(_checked(f"{what} speed", percent, PERCENT))
    return _target(HEAD_PATH, {f"continuous{what}move": str(value)})


def centre_target(column_px: int, row_px: int, width_px: int, height_px: int) -> str:
    """Return the request that brings a point of a picture of that size to its middle.

    Raises:
        ValueRefused: The point is not in the picture.
    """
    _checked("column", column_px, Span(0, width_px, "px"))
    _checked("row", row_px, Span(0, height_px, "px"))
    fields = {"center": f"{column_px},{row_px}", "imagewidth": str(width_px)}
    return _target(HEAD_PATH, {**fields, "imageheight": str(height_px)})


def preset_target(name: str) -> str:
    """Return the request that goes to a stored position."""
    return _target(HEAD_PATH, {"gotoserverpresetname": name})


def switch_target(what: str, *, is_on: bool) -> str:
    """Return the request that switches `autofocus` or `autoiris`."""
    return _target(HEAD_PATH, {what: "on" if is_on else "off"})


def lens_target(what: str, value: int) -> str:
    """Return the request that sets `focus`, `iris` or `brightness`, 1 to 9999."""
    return _target(HEAD_PATH, {what: str(int(_checked(what, value, LENS)))})


def query_target(what: str) -> str:
    """Return the question for `position`, `limits`, `speed` or `presetposall`."""
    return _target(HEAD_PATH, {"query": what})


def whoami_target() -> str:
    """Return the question for the name of the head's driver."""
    return _target(HEAD_PATH, {"whoami": "1"})


def parameters_target(group: str) -> str:
    """Return the question for the parameters of a group; all of them if it is empty."""
    fields = {"action": "list"}
    if group:
        fields["group"] = group
    return _target(PARAMETER_PATH, fields)


def _picture(width_px: int, height_px: int, compression: int) -> dict[str, str]:
    size = Span(1, 8192, "px")
    width, height = _checked("width", width_px, size), _checked("height", height_px, size)
    squeezed = _checked("compression", compression, COMPRESSION)
    return {"resolution": f"{int(width)}x{int(height)}", "compression": str(int(squeezed))}


def _moving(given: dict[str, str | None], speed: int | None) -> str:
    fields = {name: value for name, value in given.items() if value is not None}
    if not fields:
        raise ValueRefused("nothing to move: give pan, tilt or zoom")
    if speed is not None:
        fields["speed"] = str(int(_checked("speed", speed, SPEED)))
    return _target(HEAD_PATH, fields)


def _optional(what: str, value: float | None, span: Span) -> str | None:
    return None if value is None else f"{_checked(what, value, span):g}"


def _checked(what: str, value: float, span: Span) -> float:
    if not span.allows(value):
        unit = f" {span.unit}" if span.unit else ""
        raise ValueRefused(
            f"web camera: {what} cannot be {value:g}{unit}; allowed is "
            f"{span.least:g} to {span.most:g}{unit}"
        )
    return value


def _target(path: str, fields: Mapping[str, str]) -> str:
    return f"{path}?{urlencode(fields, safe=',')}"
