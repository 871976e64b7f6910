"""`cell serve`: a script for experiment clients, until somebody stops it."""

from __future__ import annotations

import logging
import signal
import sys
from contextlib import ExitStack
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter, validators

from console.calibrating import with_calibrations
from console.drifting import drift_check, tell_last_check
from console.exits import ConsoleError, Exit
from console.options import ProfileName, Wires, WiresOption
from console.output import put, say
from console.places import calibrations_folder, cell_folder, recordings_folder
from console.signals import signals_handled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from calibration.applying import Calibrated
    from cell.profile import Profile
    from cell.robot_cell import RobotCell
    from cell.twin_cell import TwinCell
    from sessions.hosting import Hosted
    from sessions.server import Listener, MasServer

DialectName = Literal["1.2", "1.3", "1.4", "1.5"]
_DIALECTS = ("1.2", "1.3", "1.4", "1.5")


def serve(
    script: str,
    /,
    *,
    profile: ProfileName = "mash",
    host: str | None = None,
    port: Annotated[int | None, Parameter(validator=validators.Number(gte=0, lte=65535))] = None,
    dialect: DialectName | None = None,
    listen: Annotated[
        list[str] | None,
        Parameter(negative="", help="Another listener, HOST:PORT/DIALECT; may be given again."),
    ] = None,
    seed: int | None = None,
    real_time: Annotated[
        bool, Parameter(negative="", help="Move as fast as the arm would, not as fast as it can.")
    ] = False,
    views: Annotated[
        Literal["jpeg", "lossless", "none"], Parameter(help="How recordings keep pictures.")
    ] = "jpeg",
    no_record: Annotated[bool, Parameter(negative="", help="Record nothing.")] = False,
    no_watchdog: Annotated[
        bool, Parameter(negative="", help="Test no components between sessions.")
    ] = False,
    wires: WiresOption = "memory",
) -> int:
    """Serve a script over MAS, on the twin or on hardware.

    Writes one line `listening on HOST:PORT dialect D` for each listener as soon as it
    accepts connections. SIGTERM ends it cleanly: the running reply is sent, connections
    are closed, blocks are brought home, the recording is closed.

    Args:
        script: Path of a script, or the name of a shipped one.
        host: Address to listen on; the profile's unless given.
        port: Port to listen on, 0 for a free one; the profile's unless given.
        dialect: MAS version to speak; the profile's unless given.
        seed: Seed of the first session; drawn and told unless given.
        profile: Profile of the cell.
        listen: Further listeners.
        real_time: Whether time passes as it does for people.
        views: How recordings keep pictures.
        no_record: Whether nothing is recorded.
        no_watchdog: Whether no component is tested between sessions.
        wires: How devices are reached; `hardware` takes ports and cameras of the profile, in
            real time, and shows pictures on the television's page.
    """
    further = [parse_listener(one) for one in listen or ()]
    from cell.profile import parse_profile, profile_text
    from sessions.hosting import settle_memory
    from sessions.seeds import random_seed
    from sessions.server import Listener, MasServer

    text = profile_text(profile)
    used = parse_profile(text, profile)
    first = Listener(
        used.server.host if host is None else host,
        used.server.port if port is None else port,
        dialect or used.server.dialect,
    )
    listeners = [first, *(Listener(*one) for one in further)]
    _log_to_stderr()
    drawn = random_seed() if seed is None else seed
    with ExitStack() as stack:
        hosted = _host(
            script,
            used,
            text,
            stack,
            seed=drawn,
            wires=wires,
            in_real_time=real_time,
            views=views,
            recordings=None if no_record else recordings_folder(),
        )
        say(f"seed {drawn}", "dim")
        if used.watchdog.enabled and not no_watchdog:
            _start_watchdog(hosted, stack)
        settle_memory()
        return run_until_stopped(MasServer(hosted.desk, listeners, ready=_announce))


def _host(
    script: str,
    profile: Profile,
    text: str,
    stack: ExitStack,
    *,
    seed: int,
    wires: Wires,
    in_real_time: bool,
    views: Literal["jpeg", "lossless", "none"],
    recordings: Path | None,
) -> Hosted[TwinCell] | Hosted[RobotCell]:
    """Put the cell together; it is given back when the stack is closed."""
    from calibration.checks import Checks
    from cell.clock import SimulatedClock, SystemClock
    from console.scripts import load_script
    from sessions.hosting import host_hardware, host_twin

    known = with_calibrations(profile)
    checks = Checks(calibrations_folder(profile.name))
    hosted: Hosted[TwinCell] | Hosted[RobotCell]
    if wires == "hardware":
        from cell.drivers.kiosk import KioskScreen, KioskSettings

        folder = cell_folder(profile.name)
        settings = KioskSettings.from_profile(known.profile.display, state_folder=folder)
        screen = stack.enter_context(KioskScreen(settings))
        say(f"the television's browser must have {screen.url} open", "dim")
        hosted = host_hardware(
            load_script(script),
            profile,
            text,
            seed=seed,
            clock=SystemClock(),
            state_folder=folder,
            screen=screen,
            recordings=recordings,
            views=views,
            calibrations=known.records,
            checks=checks,
        )
    else:
        hosted = host_twin(
            load_script(script),
            profile,
            text,
            seed=seed,
            clock=SystemClock() if in_real_time else SimulatedClock(),
            state_folder=cell_folder(profile.name),
            recordings=recordings,
            views=views,
            wires=wires,
            calibrations=known.records,
            checks=checks,
        )
    stack.callback(hosted.close)
    _tell_calibrations(known)
    return hosted


def _tell_calibrations(known: Calibrated[Profile]) -> None:
    """Tell which calibrations are in force, whether they hold, and what is demanded and missing."""
    from calibration.checks import Checks
    from calibration.demands import unusable_demands
    from calibration.verdict import Grade
    from console.calibrating import in_a_line, now
    from sessions.quality import shortcomings

    at = now()
    for record in known.records:
        say(in_a_line(record, at), "dim" if record.grade is Grade.OK else "yellow")
    tell_last_check(known.profile)
    for kind, problem in unusable_demands(known.profile.demands).items():
        say(f"warning: [demands] {kind}: {problem}", "yellow")
    checks = Checks(calibrations_folder(known.profile.name))
    for problem in shortcomings(known.profile, known.records, checks=checks):
        say(f"warning: no task will begin: {problem}", "yellow")


def _start_watchdog(hosted: Hosted[TwinCell] | Hosted[RobotCell], stack: ExitStack) -> None:
    """Let the watchdog run beside the server, until the stack is closed."""
    from cell.clock import SystemClock
    from cell.watchdog import WatchdogThread
    from sessions.hosting import versions
    from sessions.watching import lend_from, watch

    watching = watch(
        hosted.cell,
        lend_from(hosted.desk),
        cell_folder(hosted.cell.profile.name),
        SystemClock(),
        wire=hosted.wire,
        versions=versions(),
        calibrations=drift_check(hosted.cell.profile, hosted.desk.calibrations),
        is_wanted=lambda: hosted.desk.is_wanted,
    )
    stack.callback(watching.close)
    thread = WatchdogThread(watching.watchdog)
    stack.callback(thread.stop)
    thread.start()


def run_until_stopped(server: MasServer) -> int:
    """Serve until SIGTERM (exit code 0) or Ctrl-C (130), then shut down cleanly."""
    received: list[int] = []

    def stop(number: int, frame: FrameType | None) -> None:
        received.append(number)
        server.request_stop()

    with signals_handled(stop):
        server.start()
        server.wait()
        say("stopping: the cell is brought in order", "dim")
        server.shutdown()
    return Exit.INTERRUPTED if signal.SIGINT in received else Exit.DONE


def parse_listener(text: str) -> tuple[str, int, str]:
    """Return host, port and dialect of `HOST:PORT/DIALECT`.

    Raises:
        ConsoleError: The text is no such thing.
    """
    address, _, dialect = text.partition("/")
    if dialect not in _DIALECTS:
        raise ConsoleError(
            f"--listen {text}: HOST:PORT/DIALECT is expected, the dialect one of "
            f"{', '.join(_DIALECTS)}"
        )
    host, port = parse_address(address)
    return host, port, dialect


def parse_address(text: str) -> tuple[str, int]:
    """Return host and port of `HOST:PORT`; an IPv6 host stands in brackets.

    Raises:
        ConsoleError: The text is no such thing.
    """
    host, colon, port = text.rpartition(":")
    if not (colon and port.isascii() and port.isdigit() and int(port) <= 65535):
        raise ConsoleError(f"{text!r} is no address; HOST:PORT is expected, as 127.0.0.1:10993")
    return host.removeprefix("[").removesuffix("]") or "127.0.0.1", int(port)


def _announce(listeners: Sequence[Listener]) -> None:
    for listener in listeners:
        put(f"listening on {listener.host}:{listener.port} dialect {listener.dialect}")


def _log_to_stderr() -> None:
    logging.basicConfig(
        stream=sys.stderr, level=logging.INFO, format="%(asctime)s %(levelname)s %(message)s"
    )
