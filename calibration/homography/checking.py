"""Whether a camera's map still holds, at freshly placed points."""

from __future__ import annotations

import numpy as np

from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.homography.finding import ObjectNotFound
from calibration.homography.knowledge import knowledge_of, playground_profile
from calibration.homography.planning import fresh_places
from calibration.homography.procedure import automatic_features
from calibration.homography.sampling import Pair, Sampler, prepared
from calibration.procedure import Procedure, ask_whole, ask_within, return_block
from calibration.reach import TableReach
from calibration.record import Accuracy, CalibrationRecord, Measurement, Sample
from calibration.verdict import Finding, Grade

_BAD_SHARE = 2.5


def check_homography(site: Site, record: CalibrationRecord) -> Procedure:
    """Place the object at fresh points and compare where the camera sees it."""
    profile = playground_profile(site)
    known = knowledge_of(site, record.subject)
    own = profile.store.calibration
    limit_mm = yield from ask_within(
        "quality", "Most that is good?", low=0.0, high=100.0, unit="mm", default=2.0
    )
    count = yield from ask_whole("fresh", "How many fresh points?", low=1, high=40, default=3)
    guid = record.details.get("guid")
    if guid != known.guid:
        return _another_camera(record, str(guid), known.guid)
    if known.before is None:
        raise CalibrationError(f"camera {record.subject} has no map to check")
    found = list((yield from automatic_features(record.subject)))
    by_arm = own is not None and profile.arm.enabled and profile.gripper.enabled
    sampler = Sampler(
        known=known,
        radius_mm=profile.blocks[own.kind].width_mm / 2.0 if own else 16.5,
        slot=own.number if own is not None and by_arm else None,
        with_screen=profile.display.enabled,
    )
    pairs: list[Pair] = []
    try:
        sampler = yield from prepared(sampler)
        places = fresh_places(count, TableReach(profile).why_not_lay)
        for index, place in enumerate(places):
            pairs.append((yield from sampler.take(f"fresh {index + 1}", place)))
    except ObjectNotFound as error:
        found.append(error.finding)
    if sampler.slot is not None:
        yield from return_block(sampler.slot)
    return _compared(record, sampler, pairs, found, limit_mm)


def _another_camera(record: CalibrationRecord, then: str, now: str) -> Measurement:
    return Measurement(
        kind=record.kind,
        subject=record.subject,
        method=f"the camera of {record.identity[:8]} held against the profile",
        findings=(
            Finding(
                code="wrong-camera",
                grade=Grade.BAD,
                text=f"it was measured with the camera {then}, the profile has {now} as "
                f"{record.subject} now",
                hint="put the cameras back where they were, or calibrate again",
            ),
        ),
        based_on=(record.identity,),
        not_known=("whether the map holds: nothing was measured",),
    )


def _compared(
    record: CalibrationRecord,
    sampler: Sampler,
    pairs: list[Pair],
    found: list[Finding],
    limit_mm: float,
) -> Measurement:
    samples, off = [], []
    for pair in pairs:
        miss = sampler.known.to_robot_before(np.array([pair.pixel]))[0] - np.array(pair.point_mm)
        off.append(float(np.hypot(*miss)))
        samples.append(
            Sample(
                label=pair.label,
                given=pair.point_mm,
                measured=pair.pixel,
                residual=(float(miss[0]), float(miss[1])),
                held_out_mm=off[-1],
                is_used=False,
                picture=pair.picture,
            )
        )
    largest = max(off, default=0.0)
    if largest > limit_mm:
        found.append(
            Finding(
                code="map-moved",
                grade=Grade.BAD if largest > _BAD_SHARE * limit_mm else Grade.DEGRADED,
                text=f"fresh points are seen up to {largest:.1f} mm from where they lie, "
                f"{limit_mm:g} mm are good",
                hint="was the camera bumped? calibrate its homography again",
            )
        )
    return Measurement(
        kind=record.kind,
        subject=record.subject,
        method=f"the map of {record.identity[:8]} held against {len(pairs)} fresh points",
        samples=tuple(samples),
        accuracy=Accuracy(
            held_out_rms=float(np.sqrt(np.mean(np.square(off)))) if off else None,
            held_out_max=largest if off else None,
            held_out_count=len(off),
            how="fresh, with their own scatter and finding error in it",
        ),
        findings=tuple(found),
        based_on=(record.identity,),
    )
