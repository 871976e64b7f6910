"""How good fitted servo maps are: held-out sights, sights apart, play of the gears."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.servo.fitting import ServoFit, ServoModel
from calibration.servo.samples import BACK, JOINTS, TOP, MarkerNoise, Mount, Sight
from calibration.statistics import f_quantile, t_quantile
from calibration.verdict import Finding, Grade
from cell.geometry import Pose, Transform
from cell.kinematics.lynx import LynxArm, LynxGeometry
from cell.kinematics.servo_map import Five

Array = NDArray[np.float64]

_FALSE_ALARMS: Final = 0.01
_PLAY_DEG: Final = 0.3
_LOWEST_MM: Final = 60.0
_BACK_FROM_DEG: Final = 45.0
"""From this pitch of the hand downwards the marker on its back is seen from above."""
_SEEN_PITCH_DEG: Final = (-45.0, 105.0)
_TOOL: Final = Mount(name="tool", tool_from_marker=Transform.identity())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Residues:
    """What is left of each sight.

    Attributes:
        inside_mm: Distance in x and y from the fit, shape (n,).
        left_out_mm: Distance in x and y from a fit without the sight, shape (n,).
        uncorrected_mm: Distance in x and y from where the arm would be if it did as told.
        worst: Index of the sight that the others believe least; None if they believe all.
    """

    inside_mm: Array
    left_out_mm: Array
    uncorrected_mm: Array
    worst: int | None


def residues(found: ServoFit, model: ServoModel, noise: MarkerNoise) -> Residues:
    """Return what is left of each sight, left-out ones by their leverage."""
    units = noise.units[noise.used]
    count, width = len(model.commanded), int(noise.used.sum())
    rows = found.fit.residuals[: count * width].reshape(count, width)
    slopes = found.fit.jacobian[: count * width].reshape(count, width, -1)
    covariance = found.fit.covariance
    rest = np.eye(width) - slopes @ covariance @ slopes.transpose(0, 2, 1)
    left_out = np.linalg.solve(rest, rows[..., None])[..., 0]
    square = np.einsum("ni,ni->n", rows, left_out)
    freedom = found.freedom - width
    worst = None
    if freedom > 2:
        total = found.noise_factor**2 * found.freedom
        ratio = square / width / (np.maximum(total - square, 1e-12) / freedom)
        limit = f_quantile(1.0 - _FALSE_ALARMS / count, width, freedom)
        worst = int(ratio.argmax()) if ratio.max() > limit else None
    plain = model.chain.places(model.commanded)[0] - model.seen_mm
    return Residues(
        inside_mm=np.hypot(*(rows[:, :2] / units[:2]).T),
        left_out_mm=np.hypot(*(left_out[:, :2] / units[:2]).T),
        uncorrected_mm=np.hypot(plain[:, 0], plain[:, 1]),
        worst=worst,
    )


def play_findings(
    found: ServoFit, model: ServoModel, sights: Sequence[Sight], noise: MarkerNoise
) -> list[Finding]:
    """Return the joints that stand otherwise when they are reached from above than from below."""
    count, width = len(sights), int(noise.used.sum())
    rows = found.fit.residuals[: count * width].reshape(count, width)
    joints, _ = model.reached(found.parameters)
    by_joints = model.chain.places(joints)[2] * noise.units[:, None]
    findings = []
    for joint, name in enumerate(JOINTS):
        slope = by_joints[:, noise.used, joint]
        miss = -np.einsum("ni,ni->n", slope, rows) / np.einsum("ni,ni->n", slope, slope)
        up = miss[[sight.came_from == joint + 1 for sight in sights]]
        down = miss[[sight.came_from == -joint - 1 for sight in sights]]
        if min(up.size, down.size) < 3:
            continue
        gap = abs(float(up.mean() - down.mean()))
        spread = float(np.sqrt(up.var(ddof=1) / up.size + down.var(ddof=1) / down.size))
        if gap > _PLAY_DEG and gap > t_quantile(0.998, up.size + down.size - 2) * spread:
            findings.append(
                Finding(
                    code="play",
                    grade=Grade.DEGRADED,
                    text=f"{name} stands {gap:.1f} deg apart when it comes from below and from "
                    "above; the map is the middle",
                    hint="approach places from one side, or tighten the gears and the horn",
                )
            )
    return findings


def gripper_deviation(found: ServoFit, commanded_deg: Array, geometry: LynxGeometry) -> Array:
    """Return the standard deviation (n,) in mm of where the gripper is after commands (n, 5)."""
    sights = [
        Sight(label="", commanded_deg=_five(row), seen=Pose(0.0, 0.0, 0.0), mount="tool")
        for row in commanded_deg
    ]
    model = ServoModel(sights, geometry, (_TOOL,), MarkerNoise(), found.knots_deg)
    slopes = model.gripper_slopes(found.parameters)
    variance = np.einsum("nij,jk,nik->n", slopes, found.covariance, slopes)
    return np.asarray(np.sqrt(variance))


def next_pose(found: ServoFit, arm: LynxArm, tries: int = 300) -> tuple[Five, float] | None:
    """Return the command whose result is known worst, with its deviation in mm.

    Of poses spread over what was measured, with the arm over the table and a marker in view;
    None if there is none.
    """
    low = np.array([knots[0] for knots in found.knots_deg])
    high = np.array([knots[-1] for knots in found.knots_deg])
    poses = np.array([row for row in _spread(low, high, tries) if is_viewable(arm, row)])
    if not len(poses):
        return None
    deviation = gripper_deviation(found, poses, arm.geometry)
    worst = int(deviation.argmax())
    return _five(poses[worst]), float(deviation[worst])


def sweep_plan(arm: LynxArm, steps: int = 9, reaches: int = 20) -> tuple[Five, ...]:
    """Return commands: each joint up and down again with the others held, then all over.

    Poses with the arm too near the table or no marker in view from above are left out.
    """
    low, high = np.array(arm.joint_min) + 2.0, np.array(arm.joint_max) - 2.0
    home = np.clip(np.array([0.0, 10.0, 20.0, 40.0, 0.0]), low, high)
    rows = []
    for joint in range(5):
        angles = np.linspace(low[joint], high[joint], steps)
        for angle in [*angles, *angles[-2::-3]]:
            row = home.copy()
            row[joint] = angle
            rows.append(row)
    rows = [row for row in rows if is_viewable(arm, row)]
    over = [row for row in _spread(low, high, 12 * reaches) if is_viewable(arm, row)]
    return tuple(_five(row) for row in [*rows, *over[:reaches]])


def is_viewable(arm: LynxArm, commanded_deg: Array) -> bool:
    """Return whether the arm is over the table and its hand shows a marker upwards."""
    pitch = float(commanded_deg[1:4].sum())
    points = arm.link_points_mm(tuple(commanded_deg.tolist()))
    low, high = _SEEN_PITCH_DEG
    return low <= pitch <= high and min(point[2] for point in points[1:]) > _LOWEST_MM


def mount_for(commanded_deg: Sequence[float]) -> Mount:
    """Return the marker that is seen from above."""
    return BACK if sum(commanded_deg[1:4]) > _BACK_FROM_DEG else TOP


def _spread(low: Array, high: Array, count: int) -> Array:
    """Return points spread evenly over a box (Roberts' additive recurrence in 5 dimensions)."""
    ratio = 1.1673039782614187
    steps = ratio ** -np.arange(1, 6)
    part = (0.5 + np.outer(np.arange(1, count + 1), steps)) % 1.0
    return np.asarray(low + part * (high - low))


def _five(row: Array) -> Five:
    a, b, c, d, e = (float(value) for value in row)
    return a, b, c, d, e
