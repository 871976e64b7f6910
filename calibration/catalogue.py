"""The procedures there are: name, where each is, what it does in a line.

The modules are imported only when their procedure is asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Final, NamedTuple, cast

from calibration.errors import CalibrationError
from calibration.procedure import Procedure
from calibration.record import CalibrationRecord
from cell.profile import CellProfile
from cell.store import StorePlan


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """What a procedure may know of the cell beforehand.

    Attributes:
        profile: The cell's profile, with the calibrations in force applied.
        plan: The store; None for a cell without one.
        current: The calibrations in force.
    """

    profile: CellProfile
    plan: StorePlan | None
    current: tuple[CalibrationRecord, ...]


class Entry(NamedTuple):
    """One procedure.

    Attributes:
        name: What is typed after `cell calibrate`.
        kind: Kind of the record it makes.
        target: Module and function, as `module:function`; the function takes a `Site`.
        check: The same for the procedure that checks a record on fresh pictures; empty where
            there is none. That function takes a `Site` and the record.
        summary: What it does.
    """

    name: str
    kind: str
    target: str
    check: str
    summary: str


CATALOGUE: Final[tuple[Entry, ...]] = (
    Entry(
        name="camera-settings",
        kind="camera-settings",
        target="calibration.camera_settings.procedure:camera_settings",
        check="calibration.camera_settings.checking:check_camera_settings",
        summary="shutter, gain and white balance by a reference, a grey area, by hand or table",
    ),
    Entry(
        name="lens",
        kind="lens",
        target="calibration.lens.procedure:calibrate_lens",
        check="calibration.lens.procedure:check_lens",
        summary="focal length, centre and distortion from views of a board, live or from files",
    ),
    Entry(
        name="homography",
        kind="homography",
        target="calibration.homography.procedure:calibrate_homography",
        check="calibration.homography.checking:check_homography",
        summary="from the top camera's picture to the robot frame, with the calibration object",
    ),
    Entry(
        name="world",
        kind="world",
        target="calibration.world.procedure:calibrate_world",
        check="calibration.world.procedure:check_world",
        summary="the lattice's step, angle and origin: touched, seen or typed",
    ),
    Entry(
        name="screen",
        kind="screen",
        target="calibration.screen.procedure:screen",
        check="calibration.drift.procedure:check_screen",
        summary="lens and place of all cameras that stand still, and of the screen, by patterns",
    ),
    Entry(
        name="drift",
        kind="drift",
        target="calibration.drift.procedure:drift",
        check="",
        summary="whether cameras and screen still stand where they stood, by dots on the screen",
    ),
    Entry(
        name="gripper-camera",
        kind="mount",
        target="calibration.mount.procedure:calibrate_mount",
        check="calibration.mount.checking:check_mount",
        summary="lens and mount of the camera on the flange, from poses over a board or sheet",
    ),
    Entry(
        name="store-place",
        kind="store-place",
        target="calibration.store_place.procedure:store_place",
        check="calibration.store_place.checking:check_store_place",
        summary="where the store's sheet lies, by touched or typed corners or a camera",
    ),
    Entry(
        name="recognition",
        kind="recognition",
        target="calibration.recognition.procedure:learn_recognition",
        check="calibration.recognition.procedure:check_recognition",
        summary="colours and sizes of the blocks, learned from the store's own, laid out",
    ),
    Entry(
        name="eye-in-hand",
        kind="eye-in-hand",
        target="calibration.eye_in_hand.procedure:eye_in_hand",
        check="calibration.eye_in_hand.procedure:check_eye_in_hand",
        summary="where the camera sits on a SCARA's second link, with the links' lengths",
    ),
    Entry(
        name="servo-maps",
        kind="servo-maps",
        target="calibration.servo.procedure:servo_maps",
        check="calibration.servo.procedure:check_servo_maps",
        summary="where hobby servos go when they are told to, and how the arm sags",
    ),
)
"""In the order in which a new cell is calibrated."""


def start(name: str, site: Site) -> Procedure:
    """Return a fresh generator of a procedure.

    Raises:
        CalibrationError: There is no such procedure.
    """
    make = cast(Callable[[Site], Procedure], _load(entry_of(name).target))
    return make(site)


def start_check(record: CalibrationRecord, site: Site) -> Procedure:
    """Return a fresh generator of the procedure that checks a record.

    Raises:
        CalibrationError: Records of this kind cannot be checked.
    """
    target = _check_of(record)
    if not target:
        raise CalibrationError(f"there is no check of a {record.kind}; calibrate it again")
    make = cast(Callable[[Site, CalibrationRecord], Procedure], _load(target))
    return make(site, record)


def has_check(record: CalibrationRecord) -> bool:
    """Return whether records of this kind can be checked on fresh pictures."""
    return bool(_check_of(record))


def entry_of(name: str) -> Entry:
    """Return a procedure's entry.

    Raises:
        CalibrationError: There is no such procedure.
    """
    for entry in CATALOGUE:
        if entry.name == name:
            return entry
    known = ", ".join(entry.name for entry in CATALOGUE)
    raise CalibrationError(f"there is no procedure {name!r}; there are {known}")


def _check_of(record: CalibrationRecord) -> str:
    return next((e.check for e in CATALOGUE if e.kind == record.kind and e.check), "")


def _load(target: str) -> object:
    module, _, name = target.partition(":")
    found: object = getattr(import_module(module), name)
    return found
