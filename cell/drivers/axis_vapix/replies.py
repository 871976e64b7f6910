"""What the camera answers, as records; without I/O."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from cell.errors import CellError

_JPEG_BEGIN, _JPEG_END = b"\xff\xd8", b"\xff\xd9"
_PADDING = b"\r\n\0- "
_PRESET = re.compile(r"presetposno(\d+)", re.IGNORECASE)
_Value = TypeVar("_Value")


class MalformedReply(CellError):
    """The camera answered something else than was asked."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadPosition:
    """Where the head points and how its lens is set; None is what it does not tell."""

    pan_deg: float | None = None
    tilt_deg: float | None = None
    zoom: int | None = None
    iris: int | None = None
    focus: int | None = None
    brightness: int | None = None
    has_autofocus: bool | None = None
    """Whether the camera focuses by itself."""
    has_autoiris: bool | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadLimits:
    """How far the head turns and zooms; None is what it does not tell."""

    pan_deg: tuple[float, float] | None = None
    tilt_deg: tuple[float, float] | None = None
    zoom: tuple[float, float] | None = None


def error_text(body: bytes) -> str | None:
    """Return the complaint in a reply that came with status 200, or None.

    VAPIX reports mistakes as a text that begins with `Error` (`# Error` in param.cgi).
    """
    text = body[:400].decode("utf-8", "replace").strip()
    match = re.match(r"#?\s*Error\b[:\s-]*(.*)", text, re.IGNORECASE | re.DOTALL)
    return None if match is None else " ".join(match.group(1).split()) or "without a reason"


def parse_values(body: bytes) -> dict[str, str]:
    """Return the `name=value` lines of a reply; lines of another kind are passed over."""
    values: dict[str, str] = {}
    for line in body.decode("utf-8", "replace").splitlines():
        name, equals, value = line.partition("=")
        if equals and name.strip():
            values[name.strip()] = value.strip()
    return values


def parse_position(body: bytes) -> HeadPosition:
    """Return the answer to `query=position`.

    Raises:
        MalformedReply: It holds no position, or a value that is no number.
    """
    values = {name.lower(): value for name, value in parse_values(body).items()}
    if not values.keys() & {"pan", "tilt", "zoom"}:
        raise MalformedReply(f"no position in {_shown(body)}")
    return HeadPosition(
        pan_deg=_read(values, "pan", float),
        tilt_deg=_read(values, "tilt", float),
        zoom=_read(values, "zoom", _whole),
        iris=_read(values, "iris", _whole),
        focus=_read(values, "focus", _whole),
        brightness=_read(values, "brightness", _whole),
        has_autofocus=_read(values, "autofocus", _is_on),
        has_autoiris=_read(values, "autoiris", _is_on),
    )


def parse_limits(body: bytes) -> HeadLimits:
    """Return the answer to `query=limits`.

    Raises:
        MalformedReply: A limit is no number.
    """
    values = {name.lower(): value for name, value in parse_values(body).items()}

    def span(what: str) -> tuple[float, float] | None:
        least, most = _read(values, f"min{what}", float), _read(values, f"max{what}", float)
        return None if least is None or most is None else (least, most)

    return HeadLimits(pan_deg=span("pan"), tilt_deg=span("tilt"), zoom=span("zoom"))


def parse_presets(body: bytes) -> dict[int, str]:
    """Return the answer to `query=presetposall`: names by number."""
    found = {}
    for name, value in parse_values(body).items():
        match = _PRESET.fullmatch(name)
        if match and value:
            found[int(match.group(1))] = value
    return dict(sorted(found.items()))


def whole_jpeg(body: bytes) -> bytes:
    """Return a JPEG file without what may hang on behind it.

    Raises:
        MalformedReply: It does not begin and end like one.
    """
    trimmed = body.rstrip(_PADDING)
    if not trimmed.startswith(_JPEG_BEGIN):
        raise MalformedReply(f"no JPEG picture: it begins with {_shown(body)}")
    if not trimmed.endswith(_JPEG_END):
        raise MalformedReply(f"half a JPEG picture: {len(body)} bytes without an end")
    return trimmed


def _read(values: dict[str, str], name: str, read: Callable[[str], _Value]) -> _Value | None:
    text = values.get(name)
    if text is None:
        return None
    try:
        return read(text)
    except ValueError:
        raise MalformedReply(f"{name} is {text[:40]!r}") from None


def _whole(text: str) -> int:
    return round(float(text))


def _is_on(text: str) -> bool:
    if text.lower() not in ("on", "off"):
        raise ValueError(text)
    return text.lower() == "on"


def _shown(body: bytes) -> str:
    return repr(body[:40])
