"""Features of an IIDC camera, through whatever reads and writes its registers."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal
from typing import Protocol

from cell.devices.camera_features import (
    FEATURE_NAMES,
    UNITS,
    CameraFeature,
    FeatureControl,
    FeatureError,
    FeatureName,
    NotTaken,
    is_taken,
    quantity,
)
from cell.drivers.iidc.codec import (
    ControlWord,
    InquiryWord,
    decode_absolute,
    decode_control,
    decode_inquiry,
    encode_absolute,
    encode_control,
)
from cell.drivers.iidc.tables import ABSOLUTE_INQUIRY, CONTROL, INQUIRY, SLOTS

_REGISTER_BITS = 12
_VALUE_OFFSET = 8


class RegisterPort(Protocol):
    """Reads and writes 32-bit registers, by bytes from the start of the register space."""

    def read(self, address: int) -> int:
        """Return a register's word.

        Raises:
            DeviceError: The camera does not answer.
        """

    def write(self, address: int, word: int) -> None:
        """Write a register's word.

        Raises:
            DeviceError: The camera does not answer.
        """


class IidcFeatures:
    """Reads and sets features by the words of their registers."""

    def __init__(self, camera: str, port: RegisterPort) -> None:
        """Make the features of a camera.

        Args:
            camera: Its name in the profile, for messages.
            port: Reaches its registers.
        """
        self._camera = camera
        self._port = port

    def all(self) -> tuple[CameraFeature, ...]:
        """Return every feature that the camera has."""
        return tuple(
            self._feature(name, inquiry)
            for name in FEATURE_NAMES
            if (inquiry := self._inquiry(name)).is_present
        )

    def feature(self, name: FeatureName) -> CameraFeature:
        """Return one feature.

        Raises:
            FeatureError: The camera has none of that name.
        """
        return self._feature(name, self._present(name, "to read it"))

    def set_raw(self, name: FeatureName, value: int) -> CameraFeature:
        """Set a raw value: by hand and on, absolute control off.

        Raises:
            FeatureError: The value is not allowed, or another one is read back.
        """
        asked = str(value)
        inquiry = self._present(name, asked)
        before = self._feature(name, inquiry)
        if not inquiry.raw_min <= value <= inquiry.raw_max or value >> _REGISTER_BITS:
            raise self._refusal(before, asked, is_absolute=False)
        word = self._control(name)
        # The absolute bit goes first: while it is set, the camera ignores the raw value.
        manual = replace(word, is_absolute=False, is_one_push=False, is_on=True, is_auto=False)
        self._write(name, manual)
        self._write(name, _with_value(name, self._control(name), value))
        after = self._feature(name, inquiry)
        if after.raw != value or after.control != "manual":
            raise self._refusal(after, asked, is_absolute=False)
        return after

    def set_absolute(self, name: FeatureName, value: float) -> CameraFeature:
        """Set an absolute value: by hand and on, absolute control on.

        Raises:
            FeatureError: The value is not allowed, or another one is read back.
        """
        asked = quantity(value, UNITS.get(name, ""))
        inquiry = self._present(name, asked)
        before = self._feature(name, inquiry)
        span = before.absolute_range
        if span is None or not span[0] <= value <= span[1]:
            raise self._refusal(before, asked, is_absolute=True)
        word = self._control(name)
        self._write(
            name, replace(word, is_absolute=True, is_one_push=False, is_on=True, is_auto=False)
        )
        single = encode_absolute(_shifted(value, -SLOTS[name].scale))
        self._port.write(self._absolute_address(name) + _VALUE_OFFSET, single)
        after = self._feature(name, inquiry)
        if not is_taken(value, after.absolute, span) or after.control != "manual":
            raise self._refusal(after, asked, is_absolute=True)
        return after

    def set_auto(self, name: FeatureName, *, is_auto: bool) -> CameraFeature:
        """Leave a feature to the camera or take it back at the value it has.

        Raises:
            FeatureError: The camera does not do so.
        """
        asked = "auto" if is_auto else "manual"
        inquiry = self._present(name, asked)
        if is_auto and not inquiry.has_auto:
            raise self._refusal(self._feature(name, inquiry), asked, is_absolute=False)
        word = self._control(name)
        self._write(name, replace(word, is_auto=is_auto, is_one_push=False, is_on=True))
        after = self._feature(name, inquiry)
        if after.control != asked:
            raise self._refusal(after, asked, is_absolute=False)
        return after

    def _feature(self, name: FeatureName, inquiry: InquiryWord) -> CameraFeature:
        word = self._control(name)
        span: tuple[float, float] | None = None
        absolute: float | None = None
        if inquiry.has_absolute:
            low, high, absolute = self._absolute_values(name)
            span = (low, high)
        return CameraFeature(
            name=name,
            unit=UNITS.get(name, ""),
            raw_range=(inquiry.raw_min, inquiry.raw_max),
            absolute_range=span,
            controls=_controls(inquiry),
            control=_control_of(word),
            raw=_value_of(name, word) if inquiry.is_readable else None,
            absolute=absolute,
            is_absolute=word.is_absolute,
            is_read_only=_control_of(word) != "manual" or not inquiry.has_manual,
        )

    def _absolute_values(self, name: FeatureName) -> tuple[float, float, float]:
        """Return least, greatest and present absolute value in our unit."""
        address = self._absolute_address(name)
        scale = SLOTS[name].scale
        low, high, value = (
            _shifted(decode_absolute(self._port.read(address + step)), scale)
            for step in (0, 4, _VALUE_OFFSET)
        )
        return low, high, value

    def _absolute_address(self, name: FeatureName) -> int:
        """Return where the absolute registers lie; the camera counts in quadlets."""
        return 4 * self._port.read(ABSOLUTE_INQUIRY + SLOTS[name].offset)

    def _inquiry(self, name: FeatureName) -> InquiryWord:
        return decode_inquiry(self._port.read(INQUIRY + SLOTS[name].offset))

    def _present(self, name: FeatureName, asked: str) -> InquiryWord:
        inquiry = self._inquiry(name)
        if not inquiry.is_present:
            none = NotTaken(feature=name, asked=asked, allowed="nothing", read_back="")
            raise FeatureError(self._camera, [none])
        return inquiry

    def _control(self, name: FeatureName) -> ControlWord:
        return decode_control(self._port.read(CONTROL + SLOTS[name].offset))

    def _write(self, name: FeatureName, word: ControlWord) -> None:
        self._port.write(CONTROL + SLOTS[name].offset, encode_control(word))

    def _refusal(self, feature: CameraFeature, asked: str, *, is_absolute: bool) -> FeatureError:
        allowed = feature.allowed(is_absolute=is_absolute)
        if asked in ("auto", "manual"):
            allowed = ", ".join(sorted(feature.controls))
        has = quantity(feature.absolute, feature.unit) if is_absolute else str(feature.raw)
        if feature.control != "manual" or asked in ("auto", "manual"):
            has = f"{has} ({feature.control})"
        return FeatureError(
            self._camera,
            [NotTaken(feature=feature.name, asked=asked, allowed=allowed, read_back=has)],
        )


def _shifted(value: float, places: int) -> float:
    """Return a number times a power of ten, exact in decimal digits."""
    return float(Decimal(repr(value)).scaleb(places))


def _value_of(name: FeatureName, word: ControlWord) -> int:
    return word.high_value if name == "white_balance_blue" else word.value


def _with_value(name: FeatureName, word: ControlWord, value: int) -> ControlWord:
    if name == "white_balance_blue":
        return replace(word, high_value=value)
    return replace(word, value=value)


def _control_of(word: ControlWord) -> FeatureControl:
    if not word.is_on:
        return "off"
    if word.is_auto:
        return "auto"
    return "one-push" if word.is_one_push else "manual"


def _controls(inquiry: InquiryWord) -> frozenset[FeatureControl]:
    offered: tuple[tuple[bool, FeatureControl], ...] = (
        (inquiry.has_manual, "manual"),
        (inquiry.has_auto, "auto"),
        (inquiry.has_one_push, "one-push"),
        (inquiry.has_on_off, "off"),
    )
    return frozenset(control for is_offered, control in offered if is_offered)
