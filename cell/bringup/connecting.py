"""Opens every device of a cell and reports all failures at once."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from cell.devices.camera import MODES
from cell.errors import CellError
from cell.events import DeviceFailed
from cell.robot_cell import RobotCell


@dataclass(frozen=True, slots=True)
class Connected:
    """What came of opening a device.

    Attributes:
        device: Its name.
        identity: What it is; empty if it was not opened.
        problem: Why it was not opened; empty if it was.
    """

    device: str
    identity: str = ""
    problem: str = ""


def connect_devices(cell: RobotCell, *, in_parallel: bool) -> tuple[Connected, ...]:
    """Open arm, gripper, television and cameras, and close them again.

    The arm goes first, for its controller feeds the gripper; the others wait for nobody.
    One that fails keeps no other from being tried.

    Args:
        cell: The cell, closed.
        in_parallel: Whether devices are opened at the same time, as real ports can be; an
            emulated cell has one clock, and opens them one after the other.
    """
    profile = cell.profile
    results: list[Connected] = []
    arm_first: list[tuple[str, Callable[[], str]]] = []
    others: list[tuple[str, Callable[[], str]]] = []
    if profile.arm.enabled:
        arm_first.append(("arm", cell.arm.open))
    if profile.gripper.enabled:
        others.append(("gripper", lambda: _open_gripper(cell)))
    if profile.display.enabled:
        others.append(("display", lambda: _open_display(cell)))
    others.extend((f"camera {name}", _camera_opener(cell, name)) for name in cell.cameras)
    try:
        results.extend(_try(device, work) for device, work in arm_first)
        if in_parallel:
            with ThreadPoolExecutor(max_workers=max(1, len(others))) as pool:
                results.extend(pool.map(lambda one: _try(*one), others))
        else:
            results.extend(_try(device, work) for device, work in others)
    finally:
        _close_all(cell)
    return tuple(results)


def _open_gripper(cell: RobotCell) -> str:
    cell.set_output(cell.profile.outputs.gripper_power, is_on=True)
    return cell.gripper.open()


def _open_display(cell: RobotCell) -> str:
    identity = cell.display.open()
    cell.display.switch_on()
    return identity


def _camera_opener(cell: RobotCell, name: str) -> Callable[[], str]:
    return lambda: cell.cameras[name].open(MODES[0])


def _try(device: str, work: Callable[[], str]) -> Connected:
    try:
        return Connected(device, identity=work())
    except CellError as error:
        return Connected(device, problem=str(error))


def _close_all(cell: RobotCell) -> None:
    """Close everything; what does not close says so when it is opened for work."""
    steps: tuple[Callable[[], None], ...] = (
        cell.gripper.close,
        cell.display.switch_off,
        cell.display.close,
        lambda: cell.set_output(cell.profile.outputs.gripper_power, is_on=False),
        cell.arm.close,
        cell.close_cameras,
    )
    for step in steps:
        try:
            step()
        except CellError as error:
            cell.events.emit(DeviceFailed("cell", str(error)))
