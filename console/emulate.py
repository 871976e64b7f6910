"""`cell emulate`: emulated devices behind ports, for our drivers or anybody's."""

from __future__ import annotations

import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from console.exits import ConsoleError, Exit
from console.options import AsJson
from console.output import put, put_json, put_table, say
from console.serve import parse_address
from console.signals import signals_handled

if TYPE_CHECKING:
    from types import FrameType

    from cell.assembly.models import EmulatedDevice
    from cell.clock import Clock
    from cell.links.base import Direction
    from cell.stop import Bell
    from cell.store import StorePlan
    from cell.twin.serving.ends import DeviceEnd
    from cell.twin.serving.server import EmulatorServer

WEB_CAMERA = "axis-211"
"""The one model that speaks HTTP; it has no line, and nothing of the cell's world."""


def emulate(
    model: str | None = None,
    /,
    *,
    profile: Annotated[str | None, Parameter(help="Profile of the cell.")] = None,
    pty: Annotated[
        Path | None, Parameter(help="Path of the port; of a folder when a whole cell is emulated.")
    ] = None,
    tcp: Annotated[
        str | None, Parameter(help="HOST:PORT to listen on; port 0 is a free one.")
    ] = None,
    script: Annotated[
        str | None, Parameter(help="Script whose blocks stand in the store; none unless given.")
    ] = None,
    seed: int = 1,
    pace: Annotated[
        bool, Parameter(negative="", help="Send replies byte by byte, as fast as the line does.")
    ] = False,
    trace: Annotated[bool, Parameter(negative="", help="Write the traffic to stderr.")] = False,
    as_json: AsJson = False,
) -> int:
    """Run emulated devices behind ports until SIGTERM or Ctrl-C, in real time.

    With a MODEL, that device is emulated and its port written to stdout. Without one, all
    serial devices of a cell are, in one world, and a table of their ports is written; with
    those ports in a profile, `cell serve --wires hardware` uses them like hardware. The web
    camera `axis-211` is served over HTTP, and its address written.

    Args:
        model: Model of one device; all devices of a cell unless given.
        profile: Profile of the cell; a shipped one that has the model unless given.
        pty: Path of the port, or of a folder for the ports; a new one unless given.
        tcp: Host and port to listen on instead of a pseudo-terminal.
        script: Script whose blocks stand in the store.
        seed: Seed of the world's chance.
        pace: Whether replies are sent byte by byte.
        trace: Whether the traffic is written.
        as_json: Write JSON for programs.
    """
    if pty is not None and tcp is not None:
        raise ConsoleError("--pty and --tcp exclude each other: a device has one port")
    if tcp is not None and model is None:
        raise ConsoleError("--tcp needs a MODEL: an address is one device's")
    if model == WEB_CAMERA:
        return _emulate_web_camera(pty, tcp, seed, as_json=as_json)
    from cell.clock import SystemClock

    clock = SystemClock()
    devices = _devices(model, profile, _plan(script), clock, seed, on_network=tcp is not None)
    with ExitStack() as stack, _stopping() as (received, stopped):
        ends = _ends(devices, stack, pty, tcp, is_one=model is not None, seed=seed)
        servers = _start(devices, ends, stack, clock, paces=pace, traces=trace)
        _announce(devices, servers, is_one=model is not None, as_json=as_json)
        _watch(servers, stopped)
        say("stopping: the ports vanish", "dim")
    return Exit.INTERRUPTED if signal.SIGINT in received else Exit.DONE


@contextmanager
def _stopping() -> Iterator[tuple[list[int], Bell]]:
    """Collect SIGTERM and Ctrl-C for a while; the bell rings when one has come."""
    from cell.stop import Bell

    received: list[int] = []
    stopped = Bell()

    def stop(number: int, frame: FrameType | None) -> None:
        received.append(number)
        stopped.ring()

    with signals_handled(stop):
        yield received, stopped


def _emulate_web_camera(pty: Path | None, tcp: str | None, seed: int, *, as_json: bool) -> int:
    """Serve a web camera over HTTP until somebody stops it."""
    if pty is not None:
        raise ConsoleError(f"--pty is for serial devices; {WEB_CAMERA} is on the network: --tcp")
    from cell.twin.emulators.axis_vapix import EmulatedAxisCamera

    host, port = ("127.0.0.1", 0) if tcp is None else parse_address(tcp)
    with (
        _stopping() as (received, stopped),
        EmulatedAxisCamera(host=host, port=port, seed=seed) as camera,
    ):
        if as_json:
            row = {"device": "web_camera", "model": WEB_CAMERA, "port": camera.url, "line": "HTTP"}
            put_json([row])
        else:
            put(camera.url)
        stopped.wait()
        say("stopping: the camera vanishes", "dim")
    return Exit.INTERRUPTED if signal.SIGINT in received else Exit.DONE


def _plan(script: str | None) -> StorePlan:
    from cell.store import StorePlan

    if script is None:
        return StorePlan(())
    from console.scripts import load_script
    from sessions.hosting import store_plan

    return store_plan(load_script(script))


def _devices(
    model: str | None,
    profile: str | None,
    plan: StorePlan,
    clock: Clock,
    seed: int,
    *,
    on_network: bool,
) -> tuple[EmulatedDevice, ...]:
    from cell.assembly.models import MODELS, emulate_cell, emulate_model
    from cell.profile import load_cell_profile

    if model is None:
        return emulate_cell(load_cell_profile(profile or "mash"), plan, clock, seed=seed)
    if model not in MODELS:
        known = ", ".join(sorted([*MODELS, WEB_CAMERA]))
        raise ConsoleError(f"there is no model {model}; there are {known}")
    return (emulate_model(model, profile, plan, clock, seed=seed, on_network=on_network),)


def _ends(
    devices: tuple[EmulatedDevice, ...],
    stack: ExitStack,
    pty: Path | None,
    tcp: str | None,
    *,
    is_one: bool,
    seed: int,
) -> list[DeviceEnd]:
    """Return the device's end of each port; they vanish when the stack is closed."""
    from cell.twin.serving.ends import PtyEnd, TcpEnd
    from cell.twin.serving.pty_port import PtyPort

    ends: list[DeviceEnd] = []
    if tcp is not None:
        ends.append(TcpEnd(*parse_address(tcp), on_connect=devices[0].on_connect))
    else:
        folder = None if pty is None else pty.parent if is_one else pty
        if folder is None:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="robocell-")))
        elif not folder.is_dir():
            raise ConsoleError(f"there is no folder {folder}; make it first", Exit.ENVIRONMENT)
        for device in devices:
            path = pty if is_one and pty is not None else folder / device.name
            ends.append(PtyEnd(PtyPort(path, device.line, seed=seed)))
    for end in ends:
        stack.callback(end.unplug)
    return ends


def _start(
    devices: tuple[EmulatedDevice, ...],
    ends: list[DeviceEnd],
    stack: ExitStack,
    clock: Clock,
    *,
    paces: bool,
    traces: bool,
) -> list[EmulatorServer]:
    from cell.twin.emulators.uart import line_byte_s
    from cell.twin.serving.server import EmulatorServer

    return [
        stack.enter_context(
            EmulatorServer(
                device.name,
                device.emulator,
                end,
                clock,
                lock=device.lock,
                tap=_trace if traces else None,
                byte_s=line_byte_s(device.line) if paces else 0.0,
            )
        )
        for device, end in zip(devices, ends, strict=True)
    ]


def _announce(
    devices: tuple[EmulatedDevice, ...],
    servers: list[EmulatorServer],
    *,
    is_one: bool,
    as_json: bool,
) -> None:
    from cell.links.settings_text import settings_text

    rows = [
        (device.name, device.model, server.place, settings_text(device.line))
        for device, server in zip(devices, servers, strict=True)
    ]
    if as_json:
        fields = ("device", "model", "port", "line")
        put_json([dict(zip(fields, row, strict=True)) for row in rows])
    elif is_one:
        put(rows[0][2])
    else:
        put_table(("device", "model", "port", "line"), rows)
        sys.stdout.flush()


def _watch(servers: list[EmulatorServer], stopped: Bell) -> None:
    """Wait until somebody stops the command; an emulator that ends by itself is an error."""
    while not stopped.wait(1.0):
        for server in servers:
            if not server.is_running:
                raise ConsoleError(f"the emulator of {server.name} has ended", Exit.ENVIRONMENT)


def _trace(link: str, direction: Direction, data: bytes) -> None:
    arrow = "->" if direction == "to_device" else "<-"
    is_text = all(32 <= byte < 127 or byte in b"\r\n" for byte in data)
    say(f"{link} {arrow} {ascii(data.decode('ascii')) if is_text else data.hex(' ')}", "dim")
