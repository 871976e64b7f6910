"""What of a camera changes the levels: shutter, gain, white balance, as the device has them.

The shutter comes first: as long as the frame period and whole swings of the lamps allow,
because gain brings noise. What is left goes to the gain. A device without absolute values
is turned by its raw ones; what a raw step does is then learned from the pictures.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from calibration.procedure import Steps, set_absolute, set_raw
from cell.devices.camera_features import CameraFeature, FeatureName

_LOG_PER_DECIBEL = math.log(10.0) / 20.0
_RAW_GAIN_SPAN_DB = 30.0
"""What the whole range of a raw gain is taken for until pictures show otherwise."""

_LEAST_CHANGE = 5e-4

TURNED: tuple[FeatureName, ...] = ("shutter", "gain", "white_balance_red", "white_balance_blue")
"""The features that are searched."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Knob:
    """One feature and what its values do to the light.

    Attributes:
        name: Which feature.
        is_absolute: Whether its absolute values are set, else the raw ones.
        low: Least value.
        high: Greatest value.
        value: Value now.
        law: `proportional`: the light goes with the value; `decibel`: 20 of `unit_db` are ten
            times.
        unit_db: Decibels of a step of one.
    """

    name: FeatureName
    is_absolute: bool
    low: float
    high: float
    value: float
    law: Literal["proportional", "decibel"]
    unit_db: float = 1.0

    @property
    def log(self) -> float:
        """Logarithm of the light that the value lets through."""
        return self.log_of(self.value)

    @property
    def log_range(self) -> tuple[float, float]:
        """Least and greatest logarithm."""
        return self.log_of(self.low), self.log_of(self.high)

    def log_of(self, value: float) -> float:
        """Return the logarithm of the light at a value."""
        if self.law == "decibel":
            return value * self.unit_db * _LOG_PER_DECIBEL
        return math.log(max(value, 1e-9))

    def at_log(self, log: float) -> float:
        """Return the value nearest to a logarithm of light that the device has."""
        if self.law == "decibel":
            value = log / (self.unit_db * _LOG_PER_DECIBEL)
        else:
            value = math.exp(min(log, 50.0))
        value = min(max(value, self.low), self.high)
        return value if self.is_absolute else float(round(value))


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Where to turn the knobs.

    Attributes:
        values: Value by feature.
        short: What cannot be reached of ln light in R G B: above 0 too dark, below too bright.
    """

    values: dict[FeatureName, float]
    short: tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Knobs:
    """The knobs of one camera; those it lacks are None."""

    shutter: Knob | None
    gain: Knob | None
    red: Knob | None
    blue: Knob | None
    frame_ms: float
    mains_hz: float

    def __iter__(self) -> Iterator[Knob]:
        """Yield the knobs that are there."""
        yield from (k for k in (self.shutter, self.gain, self.red, self.blue) if k is not None)

    @property
    def values(self) -> dict[FeatureName, float]:
        """Values now."""
        return {knob.name: knob.value for knob in self}

    @property
    def exposure_log(self) -> float:
        """Logarithm of shutter times gain."""
        return sum(knob.log for knob in (self.shutter, self.gain) if knob is not None)

    def with_values(self, values: dict[FeatureName, float]) -> Knobs:
        """Return knobs with values as they were read back."""

        def at(knob: Knob | None) -> Knob | None:
            return None if knob is None else replace(knob, value=values.get(knob.name, knob.value))

        return replace(
            self, shutter=at(self.shutter), gain=at(self.gain), red=at(self.red), blue=at(self.blue)
        )

    def plan(self, logs: Sequence[float]) -> Plan:
        """Return how to let so much more light through, ln by channel R G B."""
        values: dict[FeatureName, float] = {}
        green = self._plan_exposure(logs[1], values)
        short = [green] * 3
        for index, knob in ((0, self.red), (2, self.blue)):
            wanted = logs[index] - logs[1]
            if knob is None:
                short[index] += wanted
                continue
            value = knob.at_log(knob.log + wanted)
            values[knob.name] = value
            rest = wanted - (knob.log_of(value) - knob.log)
            # Rounding to a raw step is no lack of range.
            is_at_end = value in (knob.low, knob.high)
            short[index] += rest if is_at_end else 0.0
        return Plan(values=values, short=(short[0], short[1], short[2]))

    def _plan_exposure(self, more: float, values: dict[FeatureName, float]) -> float:
        """Put shutter and gain into `values`; return what is out of their reach."""
        wanted = self.exposure_log + more
        if self.shutter is None or self.gain is None:
            knob = self.shutter or self.gain
            if knob is None:
                return more
            values[knob.name] = knob.at_log(wanted)
            low, high = knob.log_range
            return max(wanted - high, 0.0) + min(wanted - low, 0.0)
        shutter = self._shutter_for(wanted, self.shutter, self.gain)
        values["shutter"] = shutter
        left = wanted - self.shutter.log_of(shutter)
        values["gain"] = self.gain.at_log(left)
        low, high = self.gain.log_range
        return max(left - high, 0.0) + min(left - low, 0.0)

    def _shutter_for(self, wanted: float, shutter: Knob, gain: Knob) -> float:
        """Return the longest shutter, in whole swings and a frame's time, at the least gain.

        What the steps of a raw gain do is not known, so it stays as long as the shutter
        reaches.
        """
        if not gain.is_absolute:
            return shutter.at_log(wanted - gain.log)
        longest = shutter.at_log(wanted - gain.log_range[0])
        if not shutter.is_absolute:
            return longest
        swing_ms = 500.0 / self.mains_hz
        frame_ms = min(self.frame_ms, shutter.high)
        whole = math.floor(min(longest, frame_ms) / swing_ms + 1e-9) * swing_ms
        if whole < swing_ms or whole < shutter.low:
            return longest
        needs = wanted - shutter.log_of(whole)
        if needs <= gain.log_range[1]:
            return whole
        # Longer than a frame only when the gain is at its end.
        return shutter.at_log(wanted - gain.log_range[1])


def knobs_of(features: Sequence[CameraFeature], mains_hz: float = 50.0) -> Knobs:
    """Return the knobs that a camera's features are."""
    by_name = {feature.name: feature for feature in features}
    rate = by_name.get("frame_rate")
    rate_hz = rate.absolute if rate is not None and rate.absolute else 7.5
    return Knobs(
        shutter=_knob(by_name.get("shutter"), "proportional"),
        gain=_knob(by_name.get("gain"), "decibel"),
        red=_knob(by_name.get("white_balance_red"), "proportional"),
        blue=_knob(by_name.get("white_balance_blue"), "proportional"),
        frame_ms=1000.0 / rate_hz,
        mains_hz=mains_hz,
    )


def turn(camera: str, knobs: Knobs, values: dict[FeatureName, float]) -> Steps[Knobs]:
    """Set what differs and return the knobs as they were read back."""
    read: dict[FeatureName, float] = {}
    for knob in knobs:
        value = values.get(knob.name, knob.value)
        if abs(value - knob.value) <= _LEAST_CHANGE * max(abs(knob.value), 1e-3):
            continue
        if knob.is_absolute:
            feature = yield from set_absolute(camera, knob.name, value)
            read[knob.name] = value if feature.absolute is None else feature.absolute
        else:
            feature = yield from set_raw(camera, knob.name, int(value))
            read[knob.name] = value if feature.raw is None else float(feature.raw)
    return knobs.with_values(read)


def _knob(feature: CameraFeature | None, law: Literal["proportional", "decibel"]) -> Knob | None:
    if feature is None or (feature.is_read_only and feature.control == "manual"):
        return None
    if feature.absolute_range is not None and feature.absolute is not None:
        low, high = feature.absolute_range
        return Knob(
            name=feature.name, is_absolute=True, low=low, high=high, value=feature.absolute, law=law
        )
    if feature.raw_range is None or feature.raw is None:
        return None
    low_raw, high_raw = feature.raw_range
    if high_raw <= low_raw:
        return None
    floor = max(low_raw, 1) if law == "proportional" else low_raw
    return Knob(
        name=feature.name,
        is_absolute=False,
        low=floor,
        high=high_raw,
        value=feature.raw,
        law=law,
        unit_db=_RAW_GAIN_SPAN_DB / (high_raw - low_raw),
    )
