"""`cell camera`: the cameras by hand."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from console.exits import ConsoleError
from console.figures import Figure
from console.hand import DEFAULTS, HandOptions, by_hand, tell
from console.output import put_json, put_table, say

if TYPE_CHECKING:
    from cell.by_hand import ByHand
    from cell.devices.camera import Camera
    from cell.devices.camera_features import CameraFeature, FeatureName

app = App(name="camera")


@app.command(name="list")
def list_cameras(*, options: HandOptions = DEFAULTS) -> int:
    """List the cameras: number, model, GUID, and whether each is there.

    Args:
        options: Options of every command by hand.
    """
    from cell.errors import CellError

    def found(camera: Camera | None) -> str:
        if camera is None:
            return "not reached over these wires"
        try:
            return str(camera.identity)
        except CellError as error:
            return f"not there: {error}"

    def work(hands: ByHand) -> None:
        rows = [
            (
                name,
                str(entry.number),
                entry.model,
                entry.guid,
                found(hands.playground.cameras.get(name)),
            )
            for name, entry in hands.playground.profile.cameras.items()
        ]
        headings = ("name", "number", "model", "guid", "found")
        if options.as_json:
            put_json([dict(zip(headings, row, strict=True)) for row in rows])
        else:
            put_table(headings, rows)

    return by_hand(options, work)


@app.command
def grab(
    name: str,
    /,
    *,
    size: Annotated[str, Parameter(help="Size of the picture, as 1280x960.")] = "1280x960",
    out: Annotated[str | None, Parameter(help="PNG file to write; NAME.png unless given.")] = None,
    feature: Annotated[
        list[str] | None,
        Parameter(name="--set", negative="", help="Feature set before, as shutter=20; may recur."),
    ] = None,
    options: HandOptions = DEFAULTS,
) -> int:
    """Take a picture and write it as PNG.

    Args:
        name: The camera.
        size: Width x height in pixels.
        out: File to write.
        feature: Features to set before.
        options: Options of every command by hand.
    """
    from pathlib import Path

    width_px, height_px = _size(size)
    wanted = [_assignment(one) for one in feature or ()]
    path = Path(out or f"{name}.png")
    if path.suffix.lower() != ".png":
        raise ConsoleError(f"--out {path}: the picture is written as PNG; let the name end in .png")

    def work(hands: ByHand) -> None:
        from sessions.views import encode_png

        camera = _camera(hands, name)
        if wanted:
            _open(camera, width_px, height_px)
        for which, value in wanted:
            camera.set_absolute(which, value)
        frame = hands.playground.grab(name, width_px, height_px)
        if not path.parent.exists():
            path.parent.mkdir(parents=True)
            say(f"made the folder {path.parent}")
        path.write_bytes(encode_png(frame.pixels))
        height, width = frame.pixels.shape[:2]
        told = {"file": str(path), "width_px": width, "height_px": height, "number": frame.number}
        tell(told, str(path), options)

    return by_hand(options, work)


@app.command
def features(name: str, /, *, options: HandOptions = DEFAULTS) -> int:
    """Tell every feature of a camera: value, ranges, and who sets it.

    Args:
        name: The camera.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        camera = _camera(hands, name)
        _open(camera)
        found = camera.features()
        if options.as_json:
            put_json([_feature_json(one) for one in found])
            return
        rows = [
            (f.name, _value(f), f.allowed(is_absolute=True), _raw(f), _raw_range(f), f.control)
            for f in found
        ]
        put_table(("feature", "value", "allowed", "raw", "raw range", "set by"), rows)

    return by_hand(options, work)


@app.command(name="set")
def set_feature(
    name: str,
    feature: str,
    value: Figure,
    /,
    *,
    raw: Annotated[
        bool, Parameter(negative="", help="The register's value, without unit.")
    ] = False,
    options: HandOptions = DEFAULTS,
) -> int:
    """Set a feature of a camera and read it back.

    Args:
        name: The camera.
        feature: The feature, such as shutter.
        value: Its value, in the feature's own unit.
        raw: Whether the value is the register's own.
        options: Options of every command by hand.
    """
    which = _feature(feature)
    if raw and value != int(value):
        raise ConsoleError(f"{value:g} is no raw value; raw values are whole numbers")

    def work(hands: ByHand) -> None:
        camera = _camera(hands, name)
        _open(camera)
        if raw:
            _tell_feature(camera.set_raw(which, int(value)), options)
        else:
            _tell_feature(camera.set_absolute(which, value), options)

    return by_hand(options, work)


@app.command
def auto(
    name: str, feature: str, switch: Literal["on", "off"], /, *, options: HandOptions = DEFAULTS
) -> int:
    """Leave a feature to the camera, or take it back.

    Args:
        name: The camera.
        feature: The feature, such as shutter.
        switch: on or off.
        options: Options of every command by hand.
    """
    which = _feature(feature)

    def work(hands: ByHand) -> None:
        camera = _camera(hands, name)
        _open(camera)
        _tell_feature(camera.set_auto(which, is_auto=switch == "on"), options)

    return by_hand(options, work)


def _camera(hands: ByHand, name: str) -> Camera:
    camera = hands.playground.cameras.get(name)
    if camera is None:
        known = ", ".join(hands.playground.cameras) or "none"
        raise ConsoleError(f"there is no camera {name!r}; there are {known}")
    return camera


def _open(camera: Camera, width_px: int = 1280, height_px: int = 960) -> None:
    from cell.robot_cell import camera_mode

    camera.open(camera_mode(camera.name, width_px, height_px))


def _feature(name: str) -> FeatureName:
    from cell.devices.camera_features import FEATURE_NAMES

    if name not in FEATURE_NAMES:
        raise ConsoleError(f"there is no feature {name!r}; there are {', '.join(FEATURE_NAMES)}")
    return name


def _assignment(text: str) -> tuple[FeatureName, float]:
    name, _, value = text.partition("=")
    which = _feature(name)
    try:
        number = float(value)
        if not math.isfinite(number):
            raise ValueError(value)
        return which, number
    except ValueError as error:
        raise ConsoleError(f"--set {text}: FEATURE=NUMBER is expected, as shutter=20") from error


def _size(text: str) -> tuple[int, int]:
    from cell.devices.camera import MODES

    sizes = {f"{mode.width_px}x{mode.height_px}": (mode.width_px, mode.height_px) for mode in MODES}
    if text not in sizes:
        raise ConsoleError(f"--size {text}: there are {', '.join(sizes)}")
    return sizes[text]


def _tell_feature(feature: CameraFeature, options: HandOptions) -> None:
    is_auto = feature.control != "manual"
    text = f"{feature.name} {_value(feature)} (raw {_raw(feature)})"
    tell(_feature_json(feature), text + (", set by the camera" if is_auto else ""), options)


def _value(feature: CameraFeature) -> str:
    return "-" if feature.absolute is None else f"{feature.absolute:g} {feature.unit}".strip()


def _raw(feature: CameraFeature) -> str:
    return "-" if feature.raw is None else str(feature.raw)


def _raw_range(feature: CameraFeature) -> str:
    return feature.allowed(is_absolute=False)


def _feature_json(feature: CameraFeature) -> dict[str, object]:
    return {
        "name": feature.name,
        "unit": feature.unit,
        "absolute": feature.absolute,
        "absolute_range": feature.absolute_range,
        "raw": feature.raw,
        "raw_range": feature.raw_range,
        "control": feature.control,
        "controls": sorted(feature.controls),
    }
