"""What all commands by hand have in common: the cell, its wires, Ctrl-C, refusals."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from console.assembling import assemble, clock_for
from console.exits import ConsoleError, Exit
from console.options import Wires
from console.output import put, put_json, say
from console.places import cell_folder

if TYPE_CHECKING:
    from pathlib import Path

    from cell.by_hand import ByHand, HandCell
    from cell.errors import CellError
    from cell.links.base import Direction, Link
    from cell.profile import CellProfile, Profile
    from cell.robot_cell import RobotCell
    from cell.twin.keeping_devices import DevicesFile


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class HandOptions:
    """Options of every command by hand."""

    profile: Annotated[str, Parameter(help="Name of a profile, or the path of one.")] = "mash"
    script: Annotated[
        str, Parameter(help="Script whose store it is; path, or the name of a shipped one.")
    ] = "mash"
    wires: Annotated[
        Wires,
        Parameter(
            help="How devices are reached: emulated in memory, emulated behind "
            "pseudo-terminals, or the ports of the profile."
        ),
    ] = "memory"
    real_time: Annotated[
        bool,
        Parameter(negative="", help="Let the twin move as fast as the arm would."),
    ] = False
    show_wire: Annotated[
        bool, Parameter(negative="", help="Show every byte on every wire, on stderr.")
    ] = False
    as_json: Annotated[
        bool, Parameter(name="--json", negative="", help="Write JSON for programs.")
    ] = False


DEFAULTS = HandOptions()


def by_hand(options: HandOptions, work: Callable[[ByHand], int | None]) -> int:
    """Do something by hand with a cell, and put the cell back afterwards.

    Ctrl-C and SIGTERM stop the arm at once and end the command with code 130.

    Returns:
        The exit code; 1 where the guard, the store, the fingers or a value's range said no.
    """
    from cell.by_hand import ByHand
    from cell.errors import CellError, Stopped

    cell = assemble_by_hand(options)
    hands = ByHand(cell)
    with _stopping(cell) as asked:
        try:
            code = work(hands) or Exit.DONE
        except CellError as error:
            if asked or isinstance(error, Stopped):
                return _stopped(hands, asked)
            return _refused(error, options)
        finally:
            _put_back(hands, cell, options)
    return Exit.INTERRUPTED if asked else code


def _refused(error: CellError, options: HandOptions) -> int:
    """Tell a refusal and return exit code 1; any other error goes its way."""
    from cell.devices.camera_features import FeatureError
    from cell.errors import (
        GripFailed,
        LedgerError,
        MotionRefused,
        OutOfRange,
        StoreError,
        UnreachablePose,
        VisionError,
    )

    said_no = (
        MotionRefused, UnreachablePose, StoreError, GripFailed, VisionError, LedgerError,
        OutOfRange, FeatureError,
    )  # fmt: skip
    if not isinstance(error, said_no):
        raise error
    if options.as_json:
        told: dict[str, object] = {"refused": str(error)}
        if isinstance(error, (MotionRefused, UnreachablePose)):
            told |= {
                "what": error.what,
                "value": error.value,
                "limit": error.limit,
                "unit": error.unit,
            }
        if isinstance(error, MotionRefused):
            told |= {"nearest": error.nearest, "nearest_point_mm": error.nearest_point_mm}
        put_json(told)
    raise ConsoleError(str(error), Exit.FAILED) from error


def _stopped(hands: ByHand, asked: list[str]) -> int:
    for failure in hands.stop_everything():
        say(f"could not stop: {failure}", "red")
    say(f"stopped: {asked[0] if asked else 'a stop was asked for'}; the arm stands still", "yellow")
    return Exit.INTERRUPTED


def _put_back(hands: ByHand, cell: HandCell, options: HandOptions) -> None:
    from cell.twin.keeping import WorldFile
    from cell.twin_cell import TwinCell

    try:
        for failure in hands.put_back():
            say(f"could not be closed: {failure}", "yellow")
        if isinstance(cell, TwinCell):
            folder = cell_folder(cell.profile.name)
            WorldFile(folder / "world.json").save(cell.world, cell.clock.now_s())
            _devices_file(folder).save(cell.behind, cell.clock.now_s())
    finally:
        cell.dispose()


@contextmanager
def _stopping(cell: HandCell) -> Iterator[list[str]]:
    """Turn the first Ctrl-C into a safe stop: what drives the arm sees it as a fault.

    A fault in the middle of a motion makes the guarded arm send STOP before it is told to
    anybody. Whatever comes after the first only waits for that.
    """
    from cell.errors import Stopped

    asked: list[str] = []

    def stop(number: int, frame: FrameType | None) -> None:
        if asked:
            return
        asked.append("Ctrl-C" if number == signal.SIGINT else "asked to end")
        cell.stop.stop(asked[0])
        raise Stopped(asked[0])

    before = {n: signal.signal(n, stop) for n in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def assemble_by_hand(options: HandOptions) -> HandCell:
    """Return the cell of a command by hand, closed.

    Raises:
        ProfileError: There is no such profile, or it is wrong.
        StillHeld: Another process has the cell.
        CellError: What is kept of the cell cannot be used.
    """
    from cell.profile import Profile, load_cell_profile

    profile = load_cell_profile(options.profile)
    if isinstance(profile, Profile):
        return _with_playground(profile, options)
    return _without_playground(profile, options)


def _without_playground(profile: CellProfile, options: HandOptions) -> HandCell:
    from cell.assembly.arms import hardware_arm, twin_arm

    folder = cell_folder(profile.name)
    tap = _show_wire if options.show_wire else None
    clock = clock_for(options.wires, in_real_time=options.real_time)
    if options.wires == "hardware":
        return hardware_arm(profile, clock=clock, on_warning=_warn, tap=tap, state_folder=folder)
    return twin_arm(profile, clock=clock, tap=tap, wires=options.wires, state_folder=folder)


def _warn(text: str) -> None:
    say(text, "yellow")


def _with_playground(profile: Profile, options: HandOptions) -> RobotCell:
    from cell.errors import CellError
    from cell.twin_cell import TwinCell

    clock = clock_for(options.wires, in_real_time=options.real_time)
    tap = _show_wire if options.show_wire else None
    cell = assemble(profile, options.script, options.wires, clock, tap)
    if isinstance(cell, TwinCell):
        try:
            _devices_file(cell_folder(profile.name)).load_into(cell.behind)
        except CellError:
            cell.dispose()
            raise
    return cell


def _devices_file(folder: Path) -> DevicesFile:
    from cell.twin.keeping_devices import DevicesFile

    return DevicesFile(folder / "devices.json", folder / "world.json")


def _show_wire(link: str, direction: Direction, data: bytes) -> None:
    arrow = ">" if direction == "to_device" else "<"
    is_text = all(32 <= byte < 127 or byte in b"\r\n" for byte in data)
    shown = repr(data.decode("ascii"))[1:-1] if is_text else data.hex(" ")
    print(f"{link} {arrow} {shown}", file=sys.stderr, flush=True)


def gripper_line(cell: RobotCell) -> Link:
    """Return a line of its own to the gripper, beside the one that its driver has."""
    from cell.links.memory import MemoryLink
    from cell.links.opening import open_wire
    from cell.twin_cell import TwinCell

    if isinstance(cell, TwinCell):
        return MemoryLink("gripper", cell.behind.wires["gripper"], cell.clock)
    return open_wire("gripper", cell.profile.gripper.serial)


def tell(told: dict[str, object], text: str, options: HandOptions) -> None:
    """Write what came of a command: as data if that was asked for, else as text."""
    if options.as_json:
        put_json(told)
    else:
        put(text)


def as_lines(told: dict[str, object]) -> str:
    """Return facts as text, one a line."""
    width = max(len(name) for name in told)
    return "\n".join(f"{k.replace('_', ' '):{width}}  {_word(v)}" for k, v in told.items())


def _word(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.2f}"
    return f"{value}" if value not in ("", None) else "-"
