"""What a camera's features are: name, unit, ranges, control and value, as the device says.

A camera keeps two numbers for most features: the raw one of its register and the absolute
one in a physical unit. They are kept apart here, and every range is the device's own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, get_args

from cell.errors import DeviceError

FeatureName = Literal[
    "brightness",
    "exposure",
    "sharpness",
    "hue",
    "saturation",
    "gamma",
    "pan",
    "tilt",
    "shutter",
    "gain",
    "white_balance_red",
    "white_balance_blue",
    "frame_rate",
]
"""The features of table C.1."""

FEATURE_NAMES: tuple[FeatureName, ...] = get_args(FeatureName)

FeatureControl = Literal["manual", "auto", "one-push", "off"]
"""Who sets the value: we do, the camera does, the camera does once, nobody."""

UNITS: Mapping[FeatureName, str] = MappingProxyType(
    {
        "brightness": "%",
        "exposure": "EV",
        "hue": "deg",
        "saturation": "%",
        "gamma": "",
        "shutter": "ms",
        "gain": "dB",
        "frame_rate": "frames/s",
    }
)
"""Units of absolute values; a feature that is not here has raw values only."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraFeature:
    """One feature as the device describes it now.

    Attributes:
        name: Which feature.
        unit: Unit of the absolute value; empty for a pure number or a raw feature.
        raw_range: Least and greatest raw value; None if the device has no raw value.
        absolute_range: Least and greatest absolute value; None if the device has none.
        controls: The kinds of control that the device offers.
        control: The kind of control in force.
        raw: The raw value now, None without one.
        absolute: The absolute value now, None without one.
        is_absolute: Whether the absolute value rules; the raw one only follows it then.
        is_read_only: Whether the device takes no value for it under the present control.
    """

    name: FeatureName
    unit: str
    raw_range: tuple[int, int] | None
    absolute_range: tuple[float, float] | None
    controls: frozenset[FeatureControl] = field(default_factory=lambda: frozenset({"manual"}))
    control: FeatureControl = "manual"
    raw: int | None = None
    absolute: float | None = None
    is_absolute: bool = False
    is_read_only: bool = False

    def allowed(self, *, is_absolute: bool) -> str:
        """Return the allowed values of one kind in words."""
        span = self.absolute_range if is_absolute else self.raw_range
        if span is None:
            return f"no {'absolute' if is_absolute else 'raw'} value"
        unit = f" {self.unit}" if is_absolute and self.unit else ""
        return f"{span[0]:g} to {span[1]:g}{unit}"


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraIdentity:
    """Who a camera is.

    Attributes:
        model: What the device calls itself; empty if it says nothing.
        guid: GUID or serial number by which it was found; empty if it has none.
    """

    model: str
    guid: str

    def __str__(self) -> str:
        return f"{self.model} {self.guid}".strip()


@dataclass(frozen=True, slots=True, kw_only=True)
class NotTaken:
    """A feature that does not have the value asked for.

    Attributes:
        feature: Which one.
        asked: What was asked, with its unit, such as `16.02 ms` or `auto`.
        allowed: What the device allows.
        read_back: What the device has instead; empty if it has no such feature.
    """

    feature: FeatureName
    asked: str
    allowed: str
    read_back: str

    def __str__(self) -> str:
        has = f"reads back {self.read_back}" if self.read_back else "has no such feature"
        return f"{self.feature}: asked {self.asked}, allowed {self.allowed}, {has}"


class FeatureError(DeviceError):
    """A camera's feature did not take a value.

    Attributes:
        not_taken: What was asked, allowed and read back, for each such feature.
    """

    def __init__(self, camera: str, not_taken: Iterable[NotTaken], *, hint: str = "") -> None:
        self.not_taken = tuple(not_taken)
        super().__init__(f"camera {camera}", "; ".join(map(str, self.not_taken)), hint=hint)


@dataclass(frozen=True, slots=True)
class SettingsReport:
    """What became of a whole set of settings.

    Attributes:
        camera: Name of the camera in the profile.
        not_taken: The features that do not have the value asked for; empty if all do.
    """

    camera: str
    not_taken: tuple[NotTaken, ...] = ()

    def require(self) -> None:
        """Return if every feature took its value.

        Raises:
            FeatureError: One did not; the text names all of them.
        """
        if self.not_taken:
            raise FeatureError(
                self.camera, self.not_taken, hint="correct the camera's settings in the profile"
            )


def quantity(value: float | None, unit: str) -> str:
    """Return a value with its unit in words; `nothing` for None."""
    return "nothing" if value is None else f"{value:g} {unit}".strip()


def is_taken(asked: float, read_back: float | None, span: tuple[float, float]) -> bool:
    """Return whether an absolute value read back is the one asked, to the device's resolution.

    A device rounds to its own steps: a 4096th of the range, or one part in a thousand of
    the value where that is more (shutters have steps that grow with the time).
    """
    if read_back is None:
        return False
    step = (span[1] - span[0]) / 4096
    return abs(read_back - asked) <= max(step, abs(asked) * 1e-3, 1e-6)
