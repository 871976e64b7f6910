"""The procedure `eye_in_hand`: a person drives the arm and reads joints and pixels.

Two-stage pairs first, then a touch of the point, then looks at it, each from where it helps
most, more touches, looks at an edge, fresh points. All of it may come from a file.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from calibration.catalogue import Site
from calibration.errors import CalibrationError, FitFailed
from calibration.eye_in_hand.checking import LIMIT_MM, checked, eye_of
from calibration.eye_in_hand.guidance import Reach, next_look, viewing_joints
from calibration.eye_in_hand.judge import Fresh, point_guess
from calibration.eye_in_hand.measurement import measure_eye_in_hand
from calibration.eye_in_hand.refine import refine
from calibration.eye_in_hand.samples import LineLook, Look, Noise, Samples, Stages, Touch
from calibration.eye_in_hand.two_stage import two_stage
from calibration.procedure import Procedure, Steps, ask_number, ask_numbers, tell
from calibration.record import CalibrationRecord
from cell.geometry.eye_in_hand import EyeInHand
from cell.profile.ibm7545 import EyeInHandProfile, Ibm7545Profile

_PAIRS: Final = 3
_LOOKS: Final = 10
_TOUCHES: Final = 2
_MOST: Final = 200
_CHECKED: Final = 3


def eye_in_hand(site: Site) -> Procedure:
    """Measure where the camera sits on link 2.

    Raises:
        CalibrationError: The cell's arm carries no camera on its second link.
        FitFailed: What was measured tells too little.
    """
    arm = site.profile.arm
    if not isinstance(arm, Ibm7545Profile):
        raise CalibrationError(
            f"the arm of {site.profile.name} is a {arm.model}; an eye in hand is calibrated on "
            "an ibm-7545, whose second link carries the camera (such as `--profile avrs`)"
        )
    eye = (arm.eye_in_hand or EyeInHandProfile()).value(arm.link_mm)
    (low_1, low_2, _, _), (high_1, high_2, _, _) = arm.joint_min, arm.joint_max
    reach = Reach(joint_min_deg=(low_1, low_2), joint_max_deg=(high_1, high_2))
    stages = yield from _stages(eye)
    known = two_stage(stages, eye).put_into(eye) if stages else eye
    noise = yield from _noise()
    touches = [(yield from _touch(1, "A point to look at, such as a small black dot"))]
    looks = yield from _looks(known, touches[0], reach, noise)
    count = yield from _count("touches", "How often will the point be touched in all", _TOUCHES, 1)
    for number in range(2, count + 1):
        touches.append((yield from _touch(number, "The same point once more")))
    lines = yield from _lines()
    fresh = yield from _fresh(0, 0)
    samples = Samples(looks=tuple(looks), touches=tuple(touches), lines=tuple(lines), noise=noise)
    return measure_eye_in_hand(samples, stages, fresh, eye, reach=reach)


def check_eye_in_hand(site: Site, record: CalibrationRecord) -> Procedure:
    """Check an eye in hand: fresh points are seen, then met with the gripper.

    Raises:
        CalibrationError: The record holds no eye in hand.
    """
    eye_of(record)
    limit_mm = yield from ask_number(
        "limit", "Up to which miss of the gripper is it good?", unit="mm", default=LIMIT_MM
    )
    fresh = yield from _fresh(_CHECKED, 1)
    return checked(record, fresh, limit_mm)


def _stages(eye: EyeInHand) -> Steps[list[Stages]]:
    u, v = eye.reference_px
    count = yield from _count("pairs", "How many two-stage measurements will be taken", _PAIRS, 0)
    pairs = []
    for number in range(1, count + 1):
        seen = yield from _joints(
            f"pair-{number}-seen",
            f"Drive so that a point of the table falls on the reference pixel ({u:g}, {v:g}). "
            "Joints 1 and 2?",
        )
        over = yield from _joints(
            f"pair-{number}-over", "Drive the gripper over that point. Joints 1 and 2?"
        )
        pairs.append(Stages(label=f"pair {number}", seen_deg=seen, over_deg=over))
    return pairs


def _noise() -> Steps[Noise]:
    usual = Noise()
    look = yield from ask_number(
        "look-noise", "How exactly is a point found?", unit="px", default=usual.look_px
    )
    touch = yield from ask_number(
        "touch-noise", "How exactly is the gripper put over it?", unit="mm", default=usual.touch_mm
    )
    line = yield from ask_number(
        "line-noise", "How exactly is an edge's direction found?", unit="deg",
        default=usual.line_deg,
    )  # fmt: skip
    for key, value in (("look-noise", look), ("touch-noise", touch), ("line-noise", line)):
        if not value > 0.0:
            raise CalibrationError(f"{key}: {value:g} is not above 0; nothing is exact")
    return Noise(look_px=look, touch_mm=touch, line_deg=line)


def _touch(number: int, what: str) -> Steps[Touch]:
    j1, j2 = yield from _joints(
        f"touch-{number}", f"{what}: drive the gripper over it. Joints 1 and 2?"
    )
    return Touch(label=f"touch {number}", j1_deg=j1, j2_deg=j2)


def _looks(eye: EyeInHand, touch: Touch, reach: Reach, noise: Noise) -> Steps[list[Look]]:
    count = yield from _count("looks", "From how many places will it be looked at", _LOOKS, 4)
    looks: list[Look] = []
    for number in range(1, count + 1):
        yield from tell(f"look {number} of {count}", number - 1, count)
        u, v, j1, j2 = yield from ask_numbers(
            f"look-{number}",
            "Drive so that the point is in the picture"
            + _where(eye, touch, looks, reach, noise)
            + ". Column, row (px), joint 1, joint 2 (deg)?",
            count=4,
        )
        looks.append(Look(label=f"look {number}", u_px=u, v_px=v, j1_deg=j1, j2_deg=j2))
    return looks


def _lines() -> Steps[list[LineLook]]:
    count = yield from _count("edges", "How many looks at one straight edge will there be", 0, 0)
    if count == 0:
        return []
    known = yield from ask_numbers(
        "edge-direction",
        "The edge's direction in the robot frame, if it is known, such as from two of its points "
        "that the gripper stood over (no number if not)?",
        unit="deg",
        default=(),
    )
    lines = []
    for number in range(1, count + 1):
        alpha, j1, j2 = yield from ask_numbers(
            f"edge-{number}",
            "The edge's direction in the picture (counter-clockwise from its right, on the "
            "table's scale), joint 1, joint 2?",
            count=3,
            unit="deg",
        )
        lines.append(
            LineLook(
                label=f"edge {number}",
                alpha_deg=alpha,
                j1_deg=j1,
                j2_deg=j2,
                direction_deg=known[0] if known else None,
            )
        )
    return lines


def _fresh(usual: int, least: int) -> Steps[list[Fresh]]:
    count = yield from _count(
        "fresh", "How many other points will be seen and met by the gripper, to check", usual, least
    )
    points = []
    for number in range(1, count + 1):
        u, v, j1, j2, over_1, over_2 = yield from ask_numbers(
            f"fresh-{number}",
            "Another point: column, row (px), joints 1 and 2 when it was seen, joints 1 and 2 "
            "with the gripper over it (deg)?",
            count=6,
        )
        label = f"fresh {number}"
        points.append(
            Fresh(
                look=Look(label=label, u_px=u, v_px=v, j1_deg=j1, j2_deg=j2),
                touch=Touch(label=label, j1_deg=over_1, j2_deg=over_2),
            )
        )
    return points


def _where(eye: EyeInHand, touch: Touch, looks: list[Look], reach: Reach, noise: Noise) -> str:
    """Return from where to look next; empty where nobody knows."""
    samples = Samples(looks=tuple(looks), touches=(touch,), noise=noise)
    if len(looks) >= 4:
        try:
            best = next_look(refine(samples, eye), reach, noise)
        except FitFailed:
            best = None
        if best is not None:
            return (
                f", best from joints ({best.j1_deg:.0f}, {best.j2_deg:.0f}) deg, where it should "
                f"appear near ({best.u_px:.0f}, {best.v_px:.0f}) px"
            )
    point = point_guess(eye, touch)
    joints = viewing_joints(eye, point, reach, step_deg=2.5)
    if not len(joints):
        return ""
    taken = np.array([(look.j1_deg, look.j2_deg) for look in looks]).reshape(-1, 2)
    if len(taken):
        distance = np.linalg.norm(joints[:, None] - taken[None], axis=2).min(axis=1)
        j1, j2 = joints[int(distance.argmax())]
    else:
        j1, j2 = joints[0]
    u, v = eye.pixels(np.array(point), np.array([j1, j2]), height_mm=0.0)
    return (
        f", such as from joints ({j1:.0f}, {j2:.0f}) deg, where it should appear near "
        f"({u:.0f}, {v:.0f}) px"
    )


def _joints(key: str, question: str) -> Steps[tuple[float, float]]:
    j1, j2 = yield from ask_numbers(key, question, count=2, unit="deg")
    return j1, j2


def _count(key: str, question: str, default: int, least: int) -> Steps[int]:
    answer = yield from ask_number(key, f"{question}?", default=default)
    if answer != int(answer) or not least <= answer <= _MOST:
        raise CalibrationError(f"{key}: {answer:g} is not a whole number from {least} to {_MOST}")
    return int(answer)
