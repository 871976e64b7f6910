"""Whether the camera on the flange still hangs where a record has it, by fresh poses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.mount.accuracy import miss_mm, rms, table_points_mm
from calibration.mount.fit import ArmNoise
from calibration.mount.model import LENS_NAMES, MountState, MountView
from calibration.mount.procedure import ask_target, look, playground_of, prepare
from calibration.mount.result import KIND, NAMES
from calibration.procedure import Procedure, ask_number, stand_aside
from calibration.record import Accuracy, CalibrationRecord, Measurement, Sample
from calibration.verdict import Finding, Grade, worst
from cell.geometry import Pose, Transform

_POSES = 2
_ASIDE_DEG = 45.0
_LEAST_MM = 0.5
_TIMES = 3.0
_LOST_MM = 3.0

Points = NDArray[np.float64]


def check_mount(site: Site, record: CalibrationRecord) -> Procedure:
    """Look from fresh poses; nothing is fitted but, if it was moved, the target's place.

    Raises:
        CalibrationError: The record holds no mount.
    """
    profile = playground_of(site)
    camera = record.subject
    target = yield from ask_target(site, profile)
    count = yield from ask_number("poses", "From how many fresh poses?", default=float(_POSES))
    if count not in (1.0, 2.0, 3.0, 4.0, 5.0):
        raise CalibrationError(f"poses: 1 to 5 can be taken, not {count:g}")
    state = kept_state(record)
    yield from prepare(profile, target)
    looked = yield from look(
        profile, camera, target, state, ArmNoise(), int(count), aside_deg=_ASIDE_DEG
    )
    yield from stand_aside()
    is_same = record.details.get("target") == target.name
    return compared(record, state, looked.views, looked.findings, knows_place=is_same)


def compared(
    record: CalibrationRecord,
    state: MountState,
    views: Sequence[MountView],
    findings: Sequence[Finding],
    *,
    knows_place: bool,
) -> Measurement:
    """Return how well a record's mount says where fresh views have the target.

    Args:
        record: The record.
        state: Its lens, mount, and target's place.
        views: Fresh views.
        findings: What was found while they were taken.
        knows_place: Whether the target is the one that the record was measured with.
    """
    found = [one for one in findings if views or one.grade is Grade.BAD]
    if not views:
        found.append(
            Finding(
                code="target-not-seen",
                grade=Grade.BAD,
                text="the target was seen from none of the poses: " + _causes(findings),
                hint="see that it is lit and uncovered; if it is, the camera was moved: "
                "`cell calibrate gripper-camera`",
            )
        )
        return _measurement(record, views, [], found)
    limit = max(_LEAST_MM, _TIMES * (record.accuracy.held_out_rms or 0.0))
    misses = [miss_mm(view, state) for view in views]
    off, apart = rms(np.concatenate(misses)), _unlike_mm(views, state)
    if not knows_place:
        misses = [apart]
        off = rms(apart)
    if off > limit and len(views) > 1 and rms(apart) <= limit:
        found.append(
            Finding(
                code="target-moved",
                grade=Grade.DEGRADED,
                text=f"all poses agree that the target lies {off:.1f} mm from where the record "
                "has it: it was moved, or the arm's base",
                hint="calibrate what was moved: `cell calibrate screen` or "
                "`cell calibrate store-place`; the camera on the hand is good",
            )
        )
    elif off > limit:
        found.append(
            Finding(
                code="camera-moved",
                grade=Grade.BAD if off > _LOST_MM else Grade.DEGRADED,
                text=f"what camera {record.subject} sees lies {off:.1f} mm from where its record "
                f"has it, {limit:.1f} mm would do"
                + ("; poses do not agree on the target's place" if len(views) > 1 else ""),
                hint="fasten the camera and calibrate it again: `cell calibrate gripper-camera`",
            )
        )
    return _measurement(record, views, misses, found)


def kept_state(record: CalibrationRecord) -> MountState:
    """Return lens, mount and target's place of a record.

    Raises:
        CalibrationError: It has none.
    """
    kept = {one.name: one.value for one in record.parameters}
    place = record.details.get("target_place")
    if set(kept) != set(NAMES) or not isinstance(place, dict):
        raise CalibrationError("the record holds no mount; calibrate the camera again")
    position, rotation = np.array(place["position_mm"]), np.array(place["rotation_deg"])
    mount = Pose(*(kept[name] for name in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")))
    return MountState(
        lens=np.array([kept[name] for name in LENS_NAMES]),
        flange_from_camera=Transform.from_pose(mount),
        targets=(Transform.from_pose(Pose(*position.tolist(), *rotation.tolist())),),
    )


def _unlike_mm(views: Sequence[MountView], state: MountState) -> Points:
    """Return what is left (n,) of misses when the target may lie anywhere on its plane."""
    place = state.targets[0]
    height = float(place.translation_mm[2])
    seen = np.concatenate(
        [table_points_mm(state, view.robot_from_flange, view.pixels, height) for view in views]
    )
    wanted = np.concatenate([place.apply(view.points_mm)[:, :2] for view in views])
    seen, wanted = seen - seen.mean(axis=0), wanted - wanted.mean(axis=0)
    left, _, right = np.linalg.svd(wanted.T @ seen)
    flip = np.diag([1.0, np.linalg.det(left @ right)])
    return np.asarray(np.linalg.norm(seen - wanted @ left @ flip @ right, axis=1))


def _causes(findings: Sequence[Finding]) -> str:
    return "; ".join(one.text for one in findings) or "no pose could be reached"


def _measurement(
    record: CalibrationRecord,
    views: Sequence[MountView],
    misses: Sequence[Points],
    found: Sequence[Finding],
) -> Measurement:
    flat = np.concatenate(misses) if misses else np.empty(0)
    return Measurement(
        kind=KIND,
        subject=record.subject,
        method="lens and mount held, the target seen from fresh poses",
        samples=tuple(
            Sample(label=view.label, measured=(float(len(view.pixels)),), held_out_mm=rms(miss))
            for view, miss in zip(views, misses, strict=False)
        ),
        accuracy=Accuracy(
            held_out_rms=rms(flat) if len(flat) else None,
            held_out_max=float(flat.max()) if len(flat) else None,
            held_out_count=len(flat),
            how=f"{len(views)} fresh poses" if views else "",
        ),
        region=record.region,
        findings=tuple(found),
        based_on=(record.identity,),
        not_known=()
        if worst(found) is Grade.BAD or len(views) > 1
        else ("whether target or camera moved, if one did: look from two poses",),
    )
