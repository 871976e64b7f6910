"""What a camera's pictures tell: stuck, dark, too bright, soft, moved. Lights on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import Camera
from cell.doctor.learned import LearnedPicture
from cell.doctor.notes import Notes
from cell.errors import VisionError
from cell.vision.picture_health import (
    PictureFault,
    PictureFinding,
    PictureReference,
    judge_picture,
    make_reference,
)

_CAUSES: dict[PictureFault, str] = {
    "dark": "camera-dark",
    "overexposed": "camera-overexposed",
    "out of focus": "camera-defocused",
    "moved": "camera-moved",
    "swapped": "camera-swapped",
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """Two pictures of one camera, one right after the other.

    Attributes:
        camera: Name of the camera.
        guid: Who it is.
        first: R G B, uint8.
        second: The same of the second picture.
    """

    camera: str
    guid: str
    first: NDArray[np.uint8]
    second: NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True)
class Viewpoint:
    """What must be known to judge pictures.

    Attributes:
        cameras: Names of all cameras of the cell.
        riding: Names of those on the arm.
        is_arm_aside: Whether the arm stands where it stood when the pictures were learned.
        dark_because: Why the lights are off; empty if they are on.
    """

    cameras: frozenset[str]
    riding: frozenset[str]
    is_arm_aside: bool
    dark_because: str


def look_through(name: str, guid: str, camera: Camera) -> Look:
    """Take two pictures that the camera really takes.

    Raises:
        DeviceError: It gives none.
    """
    first = camera.grab_fresh().pixels
    return Look(camera=name, guid=guid, first=first, second=camera.grab_fresh().pixels)


def judge_pictures(
    looks: Sequence[Look],
    viewpoint: Viewpoint,
    learned: Mapping[str, LearnedPicture],
    notes: Notes,
) -> None:
    """Write down what is wrong with the pictures of all cameras together.

    Where every camera is in the dark the lamps are at fault, and not the lenses.
    """
    moving = [look for look in looks if not _is_stuck(look, notes)]
    if viewpoint.dark_because:
        for look in moving:
            component = f"camera {look.camera}"
            notes.skip(component, "light, focus and place", viewpoint.dark_because)
        return
    references = _references(moving, viewpoint, learned, notes)
    judged = {look.camera: judge_picture(look.camera, look.second, references) for look in moving}
    dark = [name for name, findings in judged.items() if _is_dark(findings)]
    if len(dark) > 1 and len(dark) == len(judged) == len(viewpoint.cameras):
        problem = "all cameras see nothing although the lights' output reads on"
        facts = [f"camera {n}: {_measure(judged[n][0])}" for n in dark]
        notes.find("lamp-dead", "lights", problem, *facts)
        return
    for name, findings in judged.items():
        component = f"camera {name}"
        for finding in findings:
            notes.find(_CAUSES[finding.fault], component, finding.text, _measure(finding))
        if not findings:
            compared = ", sharp and in its place" if name in references else ""
            notes.fine(component, f"its picture moves and has light{compared}")


def _is_stuck(look: Look, notes: Notes) -> bool:
    """Write down, and return, whether a camera gives the same picture again and again."""
    if not np.array_equal(look.first, look.second):
        return False
    problem = f"camera {look.camera} gives the same picture again and again"
    fact = "two pictures, one after the other, are equal to the last bit; noise makes them differ"
    notes.find("camera-frozen", f"camera {look.camera}", problem, fact)
    return True


def _references(
    looks: Sequence[Look],
    viewpoint: Viewpoint,
    learned: Mapping[str, LearnedPicture],
    notes: Notes,
) -> dict[str, PictureReference]:
    """Return what each camera's picture may be compared with; say what may not be, and why."""
    references: dict[str, PictureReference] = {}
    for look in looks:
        name = look.camera
        why = _why_not_compared(look, viewpoint, learned.get(name))
        if not why:
            try:
                references[name] = make_reference(name, list(learned[name].pixels))
            except VisionError as error:
                why = str(error)
        if why:
            notes.skip(f"camera {name}", "focus and place", why)
    return references


def _why_not_compared(look: Look, viewpoint: Viewpoint, kept: LearnedPicture | None) -> str:
    if kept is None:
        return "no healthy picture is kept; run `cell doctor --learn` when all is well"
    if kept.guid != look.guid:
        return f"the healthy picture is of camera {kept.guid}; learn anew"
    if not viewpoint.is_arm_aside and look.camera in viewpoint.riding:
        return "the arm that carries it does not stand aside, where the healthy picture was taken"
    if not viewpoint.is_arm_aside:
        return "the arm does not stand aside and may hide what the healthy picture shows"
    return ""


def _is_dark(findings: tuple[PictureFinding, ...]) -> bool:
    return any(finding.fault == "dark" for finding in findings)


def _measure(finding: PictureFinding) -> str:
    return f"{finding.fault}: {finding.measured:.3g}, limit {finding.limit:.3g} {finding.unit}"
