"""What serving over MAS costs: action round trips and views, beside bare sockets.

Server and client are two processes on one machine. "Two cores" pins the server to
one and the client to another, "one core" pins both to the same. The bare server is
a blocking socket that answers each line with the same bytes. Targets of times are for
two cores, where a client on its own machine comes nearest.
"""

from __future__ import annotations

import multiprocessing
import os
import socket
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import TypeVar

import numpy as np

from benchmarks.measure import Result
from cell.clock import SimulatedClock
from cell.devices.camera import CameraSettings, Frame
from cell.events import EventBus
from cell.manipulation import Deployment
from cell.profile import load_profile, profile_text
from dsl.library import library_script
from sessions.cell_script import CellScript
from sessions.desk import Desk
from sessions.script_source import served_script
from sessions.server import Listener, MasServer
from sessions.session import Session
from sessions.task import TaskRun
from sessions.wire.dialects import DIALECTS

ROUND_TRIPS = 4000
VIEWS = 60
TO_READY = b"INITIALIZE_TASK ReachRedCube STATIC_12x12\nBEGIN_TASK_SETUP\nEND_TASK_SETUP\n"
_ALL_CORES = sorted(os.sched_getaffinity(0))
"""Cores of this machine that may be used, before anything is pinned to one of them."""
_WAYS = ("RIGHT", "LEFT")
ACTIONS = tuple(f"ACTION {way}\n".encode() for way in _WAYS)
_ACTION_REPLY = b"REWARD 0\nEVENT 'Robot move'\nSTATE_UPDATED\n"
_GET_VIEW = b"GET_VIEW CAMERA_TOP\n"
_VIEW_LINE = b"VIEW CAMERA_TOP image/mif 3686408\n"
_VIEW_BYTES = len(_VIEW_LINE) + 3686408
_SETTINGS = CameraSettings(shutter_ms=1, gain_db=0, white_balance_red=1, white_balance_blue=1)

_T = TypeVar("_T")
Serve = Callable[[Connection], None]


class IdleCell:
    """A cell that does nothing at once, so that only serving is measured."""

    def __init__(self) -> None:
        pixels = np.full((960, 1280, 3), 128, np.uint8)
        self._frame = Frame(camera="top", number=1, time_s=0, pixels=pixels, settings=_SETTINGS)

    def begin_session(self, seed: int) -> None:
        """Draw nothing."""

    def world_json(self) -> str:
        """Return nothing."""
        return ""

    def open(self) -> None:
        """Bring nothing up."""

    def close(self) -> None:
        """Switch nothing off."""

    def show(self, picture: str) -> None:
        """Show nothing."""

    def lay_out(self, deployments: Sequence[Deployment]) -> None:
        """Lay nothing out."""

    def move_to(self, x_mm: float, y_mm: float, z_mm: float) -> None:
        """Move nothing."""

    def clean(self) -> object:
        """Clean nothing."""
        return None

    def grab(self, camera: str, width_px: int, height_px: int) -> Frame:
        """Return the same frame, whatever is asked for."""
        return self._frame


def run() -> list[Result]:
    results: list[Result] = []
    for name, serve, desk in (
        ("idle cell", _serve_idle, _idle_desk()),
        ("twin", _serve_twin, _twin_desk()),
    ):
        step_us = _step_in_process_us(desk)
        handled_us = _handled_us(desk)
        results.append(
            Result(
                name=f"{name}: action by a session, no socket",
                value=handled_us,
                unit="us",
                peer="the task's step alone",
                peer_value=step_us,
            )
        )
        for cores in (2, 1):
            results += _round_trips(f"{name}, {_cores(cores)}", serve, cores, step_us)
        results.append(_views(f"{name}, {_cores(2)}", serve))
    return results


def _cores(cores: int) -> str:
    return "two cores" if cores == 2 else "one core"


# In process


def _script() -> CellScript:
    return served_script(library_script("mash"), "mash.cell")


def _idle_desk() -> Desk:
    events = EventBus(SimulatedClock())
    return Desk(IdleCell(), _script(), load_profile("mash"), events=events, seed=1)


def _twin_desk() -> Desk:
    from sessions.hosting import host_twin  # the servers of the other rows need no twin

    text = profile_text("mash")
    return host_twin(_script(), load_profile("mash"), text, seed=1, clock=SimulatedClock()).desk


def _step_in_process_us(desk: Desk) -> float:
    desk.cell.begin_session(1)
    run = TaskRun(desk, desk.script.task("ReachRedCube", "STATIC_12x12"), 1)
    run.set_up()
    median_us = _median_us(run.act, _WAYS)
    run.end("measured")
    desk.cell.close()
    return median_us


def _handled_us(desk: Desk) -> float:
    session = Session(desk, DIALECTS["1.5"], "benchmark")
    for line in TO_READY.splitlines():
        session.handle(line)
    median_us = _median_us(session.handle, [line.rstrip() for line in ACTIONS])
    session.end("measured")
    return median_us


def _median_us(work: Callable[[_T], object], arguments: Sequence[_T]) -> float:
    times: list[float] = []
    for number in range(ROUND_TRIPS):
        start = time.perf_counter()
        work(arguments[number % len(arguments)])
        times.append(time.perf_counter() - start)
    return statistics.median(times) * 1e6


# Over sockets


def _round_trips(name: str, serve: Serve, cores: int, step_us: float) -> list[Result]:
    with server_process(_serve_bare_lines, cores) as bare, server_process(serve, cores) as mas:
        make_ready(mas)
        # Turn about, so that both see the same machine.
        bare_us, mas_us = (
            statistics.median(times)
            for times in zip(
                *((_exchange_us(bare), _exchange_us(mas)) for _ in range(7)), strict=True
            )
        )
    return [
        Result(
            name=f"{name}: action round trip",
            value=mas_us,
            unit="us",
            peer="bare exchange of two lines",
            peer_value=bare_us,
        ),
        Result(
            name=f"{name}: actions",
            value=1e6 / mas_us,
            unit="1/s",
            peer="bare exchange",
            peer_value=1e6 / bare_us,
            target=3000,
            target_is="at least",
        ),
        Result(
            name=f"{name}: round trip adds to the step",
            value=mas_us - step_us,
            unit="us",
            peer="the step in process",
            peer_value=step_us,
            target=150 if cores == 2 else None,
        ),
        Result(
            name=f"{name}: server adds to step and bare exchange",
            value=mas_us - step_us - bare_us,
            unit="us",
            target=60 if cores == 2 else None,
        ),
    ]


def _views(name: str, serve: Serve) -> Result:
    buffer = bytearray(_VIEW_BYTES)
    with server_process(_serve_bare_view, 2) as bare, server_process(serve, 2) as mas:
        make_ready(mas)
        bare_s, mas_s = (
            statistics.median(times)
            for times in zip(
                *((_view_s(bare, buffer), _view_s(mas, buffer)) for _ in range(VIEWS)), strict=True
            )
        )
    return Result(
        name=f"{name}: unchanged view, 1280x960 MIF",
        value=_VIEW_BYTES / mas_s / 1e9,
        unit="GB/s",
        peer="bare server, same buffer",
        peer_value=_VIEW_BYTES / bare_s / 1e9,
        target=0.6,
        target_is="at least",
        of="ratio",
    )


def make_ready(connected: socket.socket) -> None:
    connected.sendall(TO_READY)
    data = b""
    while not data.endswith(b"OK\nOK\n"):
        data += connected.recv(4096)
    connected.sendall(_GET_VIEW)
    _fill(connected, bytearray(_VIEW_BYTES))


def _exchange_us(connected: socket.socket) -> float:
    return _median_us(lambda line: exchange(connected, line), ACTIONS)


def exchange(connected: socket.socket, line: bytes) -> None:
    """Send an action and take its reply."""
    connected.sendall(line)
    data = connected.recv(4096)
    while not data.endswith(b"STATE_UPDATED\n"):
        data += connected.recv(4096)


def _view_s(connected: socket.socket, buffer: bytearray) -> float:
    start = time.perf_counter()
    connected.sendall(_GET_VIEW)
    _fill(connected, buffer)
    return time.perf_counter() - start


def _fill(connected: socket.socket, buffer: bytearray) -> None:
    view = memoryview(buffer)
    while view:
        view = view[connected.recv_into(view) :]


# Server processes


@contextmanager
def server_process(serve: Serve, cores: int) -> Iterator[socket.socket]:
    """Start a server process, pin it and this one, and yield a connection to it."""
    mine = os.sched_getaffinity(0)
    client_core, *others = _ALL_CORES
    server_core = others[0] if others and cores == 2 else client_core
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process: BaseProcess = context.Process(
        target=_pinned, args=(serve, server_core, there), daemon=True
    )
    process.start()
    try:
        port: int = here.recv()
        os.sched_setaffinity(0, {client_core})
        with socket.create_connection(("127.0.0.1", port), timeout=60) as connected:
            connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            yield connected
    finally:
        os.sched_setaffinity(0, mine)
        here.send("stop")
        process.join(60)


def _pinned(serve: Serve, core: int, pipe: Connection) -> None:
    """Serve on one core; threads inherit it, so it is set before there are any."""
    os.sched_setaffinity(0, {core})
    serve(pipe)


def _serve_idle(pipe: Connection) -> None:
    serve_desk(_idle_desk(), pipe)


def _serve_twin(pipe: Connection) -> None:
    from sessions.hosting import settle_memory  # as `cell serve` does

    desk = _twin_desk()
    settle_memory()
    serve_desk(desk, pipe)


def serve_desk(desk: Desk, pipe: Connection) -> None:
    with MasServer(desk, [Listener("127.0.0.1", 0, "1.5")]) as server:
        pipe.send(server.addresses[0].port)
        pipe.recv()


def _serve_bare_lines(pipe: Connection) -> None:
    _serve_bare(pipe, [_ACTION_REPLY])


def _serve_bare_view(pipe: Connection) -> None:
    # Real pages: a buffer of zeros would be one page of the kernel's, and always in the cache.
    picture = bytes(range(256)) * (_VIEW_BYTES // 256 + 1)
    _serve_bare(pipe, [_VIEW_LINE, picture[: _VIEW_BYTES - len(_VIEW_LINE)]])


def _serve_bare(pipe: Connection, reply: list[bytes]) -> None:
    size = sum(map(len, reply))
    with socket.create_server(("127.0.0.1", 0)) as listening:
        pipe.send(listening.getsockname()[1])
        connected, _ = listening.accept()
    with connected:
        connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        while connected.recv(4096):
            if connected.sendmsg(reply) != size:
                raise OSError("the bare server sent a part only")
