"""`cell webcam`: the web camera by hand, its pictures and where it looks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter, validators

from console.exits import ConsoleError
from console.output import put, put_json, say

if TYPE_CHECKING:
    from cell.clock import Clock
    from cell.drivers.axis_vapix import AxisCamera, AxisStream, HeadPosition
    from cell.profile import WebCameraProfile

app = App(name="webcam")

Direction = Literal["up", "down", "left", "right", "upleft", "upright", "downleft", "downright"]
Size = Annotated[str, Parameter(help="Width and height, as 640x480.")]
Compression = Annotated[int, Parameter(help="0 to 100; the higher, the smaller the file.")]
Pan = Annotated[float | None, Parameter(help="Degrees, to the right.")]
Tilt = Annotated[float | None, Parameter(help="Degrees, upward.")]
Zoom = Annotated[int | None, Parameter(help="1 (wide) to 9999.")]
_TELL_EVERY_S = 1.0


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class WebcamOptions:
    """Options of every command of the web camera."""

    profile: Annotated[str, Parameter(help="Name of a profile, or the path of one.")] = "mash"
    wires: Annotated[
        Literal["memory", "hardware"],
        Parameter(help="An emulated camera, for this call only, or the profile's camera."),
    ] = "memory"
    url: Annotated[
        str | None, Parameter(help="Another camera, as http://192.168.0.90; no profile is read.")
    ] = None
    user: Annotated[str, Parameter(help="User of the camera at --url.")] = ""
    password_variable: Annotated[
        str, Parameter(help="Environment variable with the password of the camera at --url.")
    ] = ""
    timeout: Annotated[
        float,
        Parameter(help="Seconds the camera at --url may take.", validator=validators.Number(gt=0)),
    ] = 5.0
    as_json: Annotated[
        bool, Parameter(name="--json", negative="", help="Write JSON for programs.")
    ] = False


DEFAULTS = WebcamOptions()


@app.command
def info(*, options: WebcamOptions = DEFAULTS) -> None:
    """Tell what camera it is, how far it turns and what positions it has stored.

    Args:
        options: Options of every command of the web camera.
    """
    with _camera(options) as camera:
        identity = camera.open()
        limits = asdict(camera.limits()) if camera.has_head else {}
        presets = camera.presets() if camera.has_head else {}
    if options.as_json:
        put_json({"identity": identity, "limits": limits, "presets": presets})
        return
    put(identity)
    for name, span in limits.items():
        if span is not None:
            put(f"{name:9} {span[0]:g} to {span[1]:g}")
    for number, preset_name in presets.items():
        put(f"preset {number:2} {preset_name}")


@app.command
def still(
    file: Path = Path("webcam.jpg"),
    /,
    *,
    size: Size = "640x480",
    compression: Compression = 30,
    options: WebcamOptions = DEFAULTS,
) -> None:
    """Take a picture.

    Args:
        file: Where the JPEG file goes.
        size: Its size.
        compression: How small it shall be.
        options: Options of every command of the web camera.
    """
    width_px, height_px = _size(size)
    with _camera(options) as camera:
        picture = camera.still(width_px, height_px, compression)
    file.write_bytes(picture.jpeg)
    if options.as_json:
        put_json({"file": str(file), "bytes": len(picture.jpeg)})
    else:
        put(str(file))


@app.command
def watch(
    folder: Path = Path("webcam"),
    /,
    *,
    frames: Annotated[int, Parameter(validator=validators.Number(gte=1))] = 100,
    rate: Annotated[int, Parameter(help="Pictures a second, 0 for the camera's own.")] = 0,
    size: Size = "640x480",
    compression: Compression = 30,
    options: WebcamOptions = DEFAULTS,
) -> None:
    """Keep the pictures of the camera's stream, one file each, until there are enough.

    Args:
        folder: Where the JPEG files go.
        frames: How many.
        rate: How many a second.
        size: Their size.
        compression: How small they shall be.
        options: Options of every command of the web camera.
    """
    width_px, height_px = _size(size)
    folder.mkdir(parents=True, exist_ok=True)
    with (
        _camera(options) as camera,
        camera.stream(width_px, height_px, compression, rate) as stream,
    ):
        size_bytes, duration_s = _keep(stream, folder, frames)
    told = {
        "folder": str(folder),
        "frames": frames,
        "bytes": size_bytes,
        "duration_s": round(duration_s, 3),
        "reconnects": stream.reconnects,
        "broken": stream.broken,
    }
    if options.as_json:
        put_json(told)
    else:
        rate_hz = frames / duration_s if duration_s > 0 else 0.0
        put(f"{folder}: {frames} pictures, {size_bytes / 1e6:.1f} MB, {rate_hz:.1f} a second")


@app.command
def position(*, options: WebcamOptions = DEFAULTS) -> None:
    """Tell where the camera looks and how its lens is set.

    Args:
        options: Options of every command of the web camera.
    """
    with _camera(options) as camera:
        _tell(camera.position(), options)


@app.command
def move(
    *,
    pan: Pan = None,
    tilt: Tilt = None,
    zoom: Zoom = None,
    speed: Annotated[int | None, Parameter(help="1 to 100 % of the head's speed.")] = None,
    by: Annotated[bool, Parameter(negative="", help="From where it looks now.")] = False,
    options: WebcamOptions = DEFAULTS,
) -> None:
    """Turn and zoom the camera, wait until it stands, and tell where it looks.

    Args:
        pan: Where to, sideways.
        tilt: Where to, up and down.
        zoom: How near.
        speed: How fast.
        by: Whether the figures are differences.
        options: Options of every command of the web camera.
    """
    with _camera(options) as camera:
        go = camera.move_by if by else camera.move_to
        go(pan_deg=pan, tilt_deg=tilt, zoom=zoom, speed=speed)
        _tell(camera.wait_until_still(), options)


@app.command
def step(direction: Direction, /, *, options: WebcamOptions = DEFAULTS) -> None:
    """Turn the camera a bit.

    Args:
        direction: Where to.
        options: Options of every command of the web camera.
    """
    with _camera(options) as camera:
        camera.step(direction)
        _tell(camera.wait_until_still(), options)


@app.command
def sweep(
    pan: int,
    tilt: int = 0,
    /,
    *,
    seconds: Annotated[float, Parameter(validator=validators.Number(gt=0, lte=60))] = 1.0,
    options: WebcamOptions = DEFAULTS,
) -> None:
    """Turn the camera on and on for a while, then stop it; Ctrl-C stops it at once.

    Args:
        pan: Speed sideways, -100 to 100 %.
        tilt: Speed up and down, -100 to 100 %.
        seconds: How long.
        options: Options of every command of the web camera.
    """
    clock = _clock(options)
    with _camera(options, clock) as camera:
        try:
            camera.sweep(pan, tilt)
            clock.sleep(seconds)
        finally:
            camera.stop()
        _tell(camera.wait_until_still(), options)


@app.command
def stop(*, options: WebcamOptions = DEFAULTS) -> None:
    """Stop the camera's head and lens.

    Args:
        options: Options of every command of the web camera.
    """
    with _camera(options) as camera:
        camera.stop()
        _tell(camera.position(), options)


@app.command
def home(*, options: WebcamOptions = DEFAULTS) -> None:
    """Turn the camera to its home position.

    Args:
        options: Options of every command of the web camera.
    """
    with _camera(options) as camera:
        camera.home()
        _tell(camera.wait_until_still(), options)


@app.command
def preset(name: str | None = None, /, *, options: WebcamOptions = DEFAULTS) -> None:
    """Turn the camera to a stored position; without a name, list them.

    Args:
        name: Name of the position.
        options: Options of every command of the web camera.
    """
    with _camera(options) as camera:
        if name is not None:
            camera.go_to_preset(name)
            _tell(camera.wait_until_still(), options)
            return
        presets = camera.presets()
    if options.as_json:
        put_json(presets)
    else:
        put("\n".join(presets.values()))


@app.command
def centre(
    column: int, row: int, /, *, size: Size = "640x480", options: WebcamOptions = DEFAULTS
) -> None:
    """Turn the camera so that a point of its picture comes to the middle.

    Args:
        column: Column of the point, in pixels from the left.
        row: Row of the point, in pixels from the top.
        size: Size of the picture that the point was read in.
        options: Options of every command of the web camera.
    """
    width_px, height_px = _size(size)
    with _camera(options) as camera:
        camera.centre_on(column, row, width_px, height_px)
        _tell(camera.wait_until_still(), options)


@app.command
def lens(
    *,
    focus: Annotated[str | None, Parameter(help="`auto`, or 1 to 9999.")] = None,
    iris: Annotated[str | None, Parameter(help="`auto`, or 1 to 9999.")] = None,
    brightness: Annotated[int | None, Parameter(help="1 to 9999.")] = None,
    options: WebcamOptions = DEFAULTS,
) -> None:
    """Set focus, iris and brightness, and tell how they are set.

    Args:
        focus: The focus.
        iris: The iris.
        brightness: The brightness.
        options: Options of every command of the web camera.
    """
    focus_value, iris_value = _automatic("focus", focus), _automatic("iris", iris)
    with _camera(options) as camera:
        if focus_value is not None:
            camera.set_focus(focus_value)
        elif focus is not None:
            camera.set_autofocus(is_on=True)
        if iris_value is not None:
            camera.set_iris(iris_value)
        elif iris is not None:
            camera.set_autoiris(is_on=True)
        if brightness is not None:
            camera.set_brightness(brightness)
        _tell(camera.position(), options)


@app.command
def parameters(group: str = "", /, *, options: WebcamOptions = DEFAULTS) -> None:
    """List the camera's own parameters.

    Args:
        group: Only those of a group, such as Brand or Image.
        options: Options of every command of the web camera.
    """
    with _camera(options) as camera:
        told = camera.parameters(group)
    if options.as_json:
        put_json(told)
    else:
        put("\n".join(f"{name}={value}" for name, value in told.items()))


@contextmanager
def _camera(options: WebcamOptions, clock: Clock | None = None) -> Iterator[AxisCamera]:
    """Give the camera that the options mean; a wrong value is wrong usage."""
    from cell.drivers.axis_vapix import AxisCamera
    from cell.drivers.axis_vapix.requests import ValueRefused
    from cell.twin.emulators.axis_vapix import EmulatedAxisCamera

    used_clock = _clock(options) if clock is None else clock
    table = _table(options)
    try:
        if table is not None:
            yield AxisCamera(table, used_clock)
            return
        with EmulatedAxisCamera(clock=used_clock) as emulated:
            say("an emulated camera, for this call only", "dim")
            yield AxisCamera(_at(emulated.url, options), used_clock)
    except ValueRefused as error:
        raise ConsoleError(str(error)) from error


def _table(options: WebcamOptions) -> WebCameraProfile | None:
    """Return the table of the camera that is meant, or None for the emulated one."""
    if options.url is not None:
        return _at(options.url, options)
    if options.wires == "memory":
        return None
    from cell.profile import load_cell_profile

    found = load_cell_profile(options.profile).web_camera
    if found is None:
        raise ConsoleError(
            f"profile {options.profile} has no web camera; add a [web_camera] table with its "
            f"url, or give --url"
        )
    return found


def _at(url: str, options: WebcamOptions) -> WebCameraProfile:
    from pydantic import ValidationError

    from cell.profile import WebCameraProfile

    try:
        return WebCameraProfile(
            url=url,
            user=options.user,
            password_variable=options.password_variable,
            timeout_s=options.timeout,
        )
    except ValidationError as error:
        if any(one["type"] == "value_error" for one in error.errors()):
            raise ConsoleError(
                "--url holds a name or a password; give --user, and in --password-variable the "
                "name of an environment variable with the password"
            ) from None
        raise ConsoleError(
            "--url is no address of a camera; http://HOST or http://HOST:PORT is expected"
        ) from None


def _clock(options: WebcamOptions) -> Clock:
    """Return real time, or a clock that waits for nobody where all is emulated."""
    from cell.clock import SimulatedClock, SystemClock

    is_emulated = options.url is None and options.wires == "memory"
    return SimulatedClock() if is_emulated else SystemClock()


def _keep(stream: AxisStream, folder: Path, frames: int) -> tuple[int, float]:
    """Write so many pictures; return their bytes and how long it took."""
    from cell.clock import SystemClock

    clock = SystemClock()
    size_bytes, told_s = 0, 0.0
    for picture in stream:
        (folder / f"{picture.number:06}.jpg").write_bytes(picture.jpeg)
        size_bytes += len(picture.jpeg)
        is_last = picture.number >= frames
        if is_last or clock.now_s() - told_s >= _TELL_EVERY_S:
            told_s = clock.now_s()
            say(f"{picture.number} of {frames}", "dim")
        if is_last:
            break
    return size_bytes, clock.now_s()


def _tell(where: HeadPosition, options: WebcamOptions) -> None:
    values = {name: value for name, value in asdict(where).items() if value is not None}
    if options.as_json:
        put_json(values)
    else:
        put("\n".join(f"{name:13} {_shown(value)}" for name, value in values.items()))


def _shown(value: float | bool) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}"


def _size(text: str) -> tuple[int, int]:
    width, x, height = text.partition("x")
    if not (x and width.isascii() and width.isdigit() and height.isascii() and height.isdigit()):
        raise ConsoleError(f"{text!r} is no size; WIDTHxHEIGHT is expected, as 640x480")
    return int(width), int(height)


def _automatic(what: str, text: str | None) -> int | None:
    """Return a value, or None for `auto` and for nothing."""
    if text is None or text == "auto":
        return None
    if not (text.isascii() and text.isdigit()):
        raise ConsoleError(f"{what} {text!r}: `auto` or a number is expected")
    return int(text)
