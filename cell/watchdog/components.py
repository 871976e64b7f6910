"""The test of each component, as the reference has them: each brings up what it needs only."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass

import numpy as np

from cell.devices.camera import Frame
from cell.errors import CellError, DeviceError
from cell.robot_cell import RobotCell

ARM_FROM_MM = (600.0, 0.0, 300.0)
"""Where the arm's test begins and ends (reference 5.2)."""
ARM_TO_MM = (500.0, 0.0, 300.0)
GRIPPER_OPEN_MM = 60.0
GRIPPER_NARROW_MM = 50.0
LEAST_BRIGHTENING = 1.2
"""How much brighter a picture has to be with the lights on; ours, the twin's is twice that."""

Run = Callable[[RobotCell, list[Frame]], str]


@dataclass(frozen=True, slots=True)
class ComponentTest:
    """One test.

    Attributes:
        component: What is tested: `arm`, `gripper`, `display`, `lights`, `camera NAME` or
            `calibrations`.
        needs: Components that have to work for the test to mean anything.
        run: Does it, adds pictures it took to the list, and returns what it saw; raises a
            `CellError` when the component fails.
    """

    component: str
    needs: tuple[str, ...]
    run: Run


def component_tests(cell: RobotCell) -> tuple[ComponentTest, ...]:
    """Return the tests of the devices that the profile enables, the arm's first."""
    profile = cell.profile
    tests: list[ComponentTest] = []
    if profile.arm.enabled:
        tests.append(ComponentTest("arm", (), _test_arm))
        if profile.gripper.enabled:
            tests.append(ComponentTest("gripper", ("arm",), _test_gripper))
    if profile.display.enabled:
        tests.append(ComponentTest("display", (), _test_display))
    if profile.arm.enabled:
        tests.append(ComponentTest("lights", ("arm",), _test_lights))
    tests += [ComponentTest(f"camera {name}", (), _camera_test(name)) for name in cell.cameras]
    return tuple(tests)


def _test_arm(cell: RobotCell, pictures: list[Frame]) -> str:
    with _open_arm(cell):
        for x_mm, y_mm, z_mm in (ARM_FROM_MM, ARM_TO_MM, ARM_FROM_MM):
            cell.move_to(x_mm, y_mm, z_mm)
        reached = cell.read_pose()
        cell.arm.rest()
    return f"moved to x {ARM_TO_MM[0]:g} mm and back to {reached}"


def _test_gripper(cell: RobotCell, pictures: list[Frame]) -> str:
    held = cell.ledger.open_transfer()
    if held is not None and held.phase == "gripped":
        return f"not moved: the fingers hold the block of slot {held.slot}"
    with _open_arm(cell), _powered_gripper(cell):
        for opening_mm in (GRIPPER_OPEN_MM, GRIPPER_NARROW_MM, GRIPPER_OPEN_MM):
            cell.gripper.move_to(opening_mm)
        state = cell.gripper.read_state()
    return f"moved to {GRIPPER_NARROW_MM:g} mm and back to {state.position_mm:.1f} mm"


def _test_display(cell: RobotCell, pictures: list[Frame]) -> str:
    display = cell.display
    display.open()
    was_on = False
    try:
        was_on = display.is_on()
        for is_on in (True, False):
            (display.switch_on if is_on else display.switch_off)()
            if display.is_on() != is_on:
                wanted = "on" if is_on else "off"
                raise DeviceError("display", f"does not go {wanted}, though it says it would")
    finally:
        with suppress(CellError):
            if was_on:
                display.switch_on()
        display.close()
    return "went on and off"


def _test_lights(cell: RobotCell, pictures: list[Frame]) -> str:
    """Switch the lights; where a camera looks on, its picture has to become brighter."""
    bit = cell.profile.outputs.lights
    brightness = []
    with _open_arm(cell):
        try:
            for is_on in (False, True):
                cell.switch_lights(is_on=is_on)
                if cell.arm.arm.read_output(bit) != is_on:
                    raise DeviceError("lights", f"output {bit} does not follow its command")
                brightness.append(_brightness(cell, pictures))
        finally:
            cell.switch_lights(is_on=False)
    dark, bright = brightness
    if dark is None or bright is None:
        return "the output went on and off; no camera saw it"
    if bright < LEAST_BRIGHTENING * max(dark, 1.0):
        raise DeviceError(
            "lights",
            f"output {bit} is on, but the picture stays dark: mean grey {dark:.0f} without, "
            f"{bright:.0f} with the lights",
            hint="check lamps, their supply and the relay",
        )
    return f"mean grey {dark:.0f} without, {bright:.0f} with the lights"


def _camera_test(name: str) -> Run:
    def test(cell: RobotCell, pictures: list[Frame]) -> str:
        with lights_if_possible(cell) as is_lit:
            try:
                frame = cell.grab(name)
            finally:
                cell.close_cameras()
        pictures.append(frame)
        height_px, width_px, _ = frame.pixels.shape
        if int(frame.pixels.max()) == int(frame.pixels.min()):
            raise DeviceError(
                f"camera {name}", "its picture is one even colour", hint="check lens and cable"
            )
        light = "" if is_lit else ", taken without the lights"
        return f"picture of {width_px}x{height_px} px, mean grey {_mean(frame):.0f}{light}"

    return test


def _brightness(cell: RobotCell, pictures: list[Frame]) -> float | None:
    """Return the mean grey of the first camera that gives a picture; its test tells of others."""
    try:
        for name in cell.cameras:
            try:
                frame = cell.grab(name)
            except CellError:
                continue
            pictures.append(frame)
            return _mean(frame)
    finally:
        cell.close_cameras()
    return None


def _mean(frame: Frame) -> float:
    return float(np.mean(frame.pixels[::8, ::8]))


@contextmanager
def lights_if_possible(cell: RobotCell) -> Iterator[bool]:
    """Light the cell, if the arm's controller that switches the lights answers.

    The arm is open as long as it lasts. What fails here is told by the tests of arm and lights.
    """
    with ExitStack() as undo:
        is_lit = False
        if cell.profile.arm.enabled:
            with suppress(CellError):
                undo.callback(_quietly, cell.arm.close)
                cell.arm.open()
                undo.callback(_quietly, lambda: cell.switch_lights(is_on=False))
                cell.switch_lights(is_on=True)
                is_lit = True
        yield is_lit


def _quietly(do: Callable[[], None]) -> None:
    with suppress(CellError):
        do()


@contextmanager
def _open_arm(cell: RobotCell) -> Iterator[None]:
    cell.arm.open()
    try:
        yield
    finally:
        cell.arm.close()


@contextmanager
def _powered_gripper(cell: RobotCell) -> Iterator[None]:
    power = cell.profile.outputs.gripper_power
    cell.set_output(power, is_on=True)
    try:
        cell.gripper.open()
        yield
    finally:
        try:
            cell.gripper.close()
        finally:
            cell.set_output(power, is_on=False)
