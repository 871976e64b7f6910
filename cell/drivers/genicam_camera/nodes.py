"""Features as nodes of the Standard Features Naming Convention (SFNC).

Whole-number nodes are raw values, all others absolute ones. Exposure times are microseconds
there and milliseconds here. White balance is one node behind a selector, and a ratio: the
raw balance of an IIDC camera means nothing to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
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
from cell.drivers.genicam_camera.toolkit import NodeMap
from cell.errors import DeviceError

_READ_WRITE = 4
"""GenApi's access mode RW; 3 is read-only, 2 write-only, 1 not available, 0 not there."""

_LEAST_READABLE = 3


class Node(Protocol):
    """One node of the map; numbers have limits, enumerations and switches have none."""

    value: float | int | str | bool
    min: float
    max: float

    def get_access_mode(self) -> int:
        """Return GenApi's access mode."""


@dataclass(frozen=True, slots=True)
class Sfnc:
    """Where a feature lies.

    Attributes:
        node: Name of its node.
        scale: One unit of the node in ours.
        auto: Node of its automatic mode (`Off`, `Once`, `Continuous`), empty without one.
        selector: Node and entry to select first, None without.
    """

    node: str
    scale: float = 1.0
    auto: str = ""
    selector: tuple[str, str] | None = None


NODES: Mapping[FeatureName, Sfnc] = MappingProxyType(
    {
        "brightness": Sfnc("BlackLevel", auto="BlackLevelAuto"),
        "sharpness": Sfnc("Sharpness", auto="SharpnessAuto"),
        "hue": Sfnc("Hue", auto="HueAuto"),
        "saturation": Sfnc("Saturation", auto="SaturationAuto"),
        "gamma": Sfnc("Gamma"),
        "shutter": Sfnc("ExposureTime", scale=1e-3, auto="ExposureAuto"),
        "gain": Sfnc("Gain", auto="GainAuto"),
        "white_balance_red": Sfnc(
            "BalanceRatio", auto="BalanceWhiteAuto", selector=("BalanceRatioSelector", "Red")
        ),
        "white_balance_blue": Sfnc(
            "BalanceRatio", auto="BalanceWhiteAuto", selector=("BalanceRatioSelector", "Blue")
        ),
        "frame_rate": Sfnc("AcquisitionFrameRate"),
    }
)

_CONTROLS: Mapping[str, FeatureControl] = MappingProxyType(
    {"Off": "manual", "Once": "one-push", "Continuous": "auto"}
)


class NodeFeatures:
    """Reads and sets features by the nodes of a camera."""

    def __init__(self, camera: str, nodes: NodeMap, errors: tuple[type[Exception], ...]) -> None:
        """Make the features of a camera.

        Args:
            camera: Its name in the profile, for messages.
            nodes: Its node map.
            errors: The library's errors.
        """
        self._camera = camera
        self._nodes = nodes
        self._errors = errors

    def all(self) -> tuple[CameraFeature, ...]:
        """Return every feature that can be read."""
        return tuple(
            self._feature(name, NODES[name])
            for name in FEATURE_NAMES
            if name in NODES and self._node(NODES[name].node) is not None
        )

    def set_raw(self, name: FeatureName, value: int) -> CameraFeature:
        """Set a whole-number node by hand.

        Raises:
            FeatureError: Another value is read back, or the node is not a whole number.
        """
        return self._set(name, value, is_absolute=False)

    def set_absolute(self, name: FeatureName, value: float) -> CameraFeature:
        """Set a node with a fraction by hand.

        Raises:
            FeatureError: Another value is read back, or the node has no fraction.
        """
        return self._set(name, value, is_absolute=True)

    def set_auto(self, name: FeatureName, *, is_auto: bool) -> CameraFeature:
        """Leave a feature to the camera, or take it back at the value it has.

        Raises:
            FeatureError: The camera does not do so.
        """
        asked = "auto" if is_auto else "manual"
        where, before = self._present(name, asked)
        if asked != before.control:
            self._write(where.auto, "Continuous" if is_auto else "Off")
        after = self._feature(name, where)
        if after.control != asked:
            has = f"{after.absolute or after.raw} ({after.control})"
            raise self._refusal(name, asked, ", ".join(sorted(after.controls)), has)
        return after

    def put(self, node: str, value: float | str | bool) -> bool:
        """Set any node; return False if the camera has none of that name or refuses."""
        return self._write(node, value)

    def _set(self, name: FeatureName, value: float, *, is_absolute: bool) -> CameraFeature:
        asked = quantity(value, UNITS.get(name, "")) if is_absolute else str(value)
        where, before = self._present(name, asked)
        span = before.absolute_range if is_absolute else before.raw_range
        allowed = before.allowed(is_absolute=is_absolute)
        if span is not None and span[0] <= value <= span[1]:
            self._write(where.auto, "Off")
            self._select(where)
            self._write(where.node, value / where.scale if is_absolute else int(value))
        after = self._feature(name, where)
        has = after.absolute if is_absolute else after.raw
        is_same = span is not None and (is_taken(value, has, span) if is_absolute else has == value)
        if not is_same or after.control != "manual":
            told = quantity(after.absolute, after.unit) if is_absolute else str(after.raw)
            raise self._refusal(name, asked, allowed, f"{told} ({after.control})")
        return after

    def _feature(self, name: FeatureName, where: Sfnc) -> CameraFeature:
        self._select(where)
        node = self._node(where.node)
        if node is None:
            raise DeviceError(f"camera {self._camera}", f"no longer offers {where.node}")
        try:
            value, low, high = node.value, node.min, node.max
            is_writable = node.get_access_mode() == _READ_WRITE
        except self._errors as error:
            raise DeviceError(
                f"camera {self._camera}", f"cannot read {where.node}: {error}"
            ) from error
        auto = self._node(where.auto)
        control = "manual" if auto is None else _CONTROLS.get(str(auto.value), "auto")
        is_raw = isinstance(value, int)
        number = float(value)
        return CameraFeature(
            name=name,
            unit="" if is_raw else UNITS.get(name, ""),
            raw_range=(int(low), int(high)) if is_raw else None,
            absolute_range=None if is_raw else (low * where.scale, high * where.scale),
            controls=frozenset({"manual", "auto", "one-push"} if auto else {"manual"}),
            control=control,
            raw=int(number) if is_raw else None,
            absolute=None if is_raw else number * where.scale,
            is_absolute=not is_raw,
            is_read_only=control != "manual" or not is_writable,
        )

    def _present(self, name: FeatureName, asked: str) -> tuple[Sfnc, CameraFeature]:
        where = NODES.get(name)
        if where is None or self._node(where.node) is None:
            raise FeatureError(
                self._camera,
                [NotTaken(feature=name, asked=asked, allowed="nothing", read_back="")],
            )
        return where, self._feature(name, where)

    def _select(self, where: Sfnc) -> None:
        if where.selector is not None:
            self._write(*where.selector)

    def _node(self, name: str) -> Node | None:
        """Return a node that can be read, None if there is none."""
        node: Node | None = getattr(self._nodes, name, None) if name else None
        if node is None or node.get_access_mode() < _LEAST_READABLE:
            return None
        return node

    def _write(self, name: str, value: float | str | bool) -> bool:
        node = self._node(name)
        if node is None or node.get_access_mode() != _READ_WRITE:
            return False
        try:
            node.value = value
        except self._errors:
            # What was refused shows when it is read back, with the value that is there.
            return False
        return True

    def _refusal(self, name: FeatureName, asked: str, allowed: str, has: str) -> FeatureError:
        item = NotTaken(feature=name, asked=asked, allowed=allowed, read_back=has)
        return FeatureError(self._camera, [item])
