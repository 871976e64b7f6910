"""The check for drift: two pictures on the screen, two of each camera that stands still."""

from __future__ import annotations

from calibration.catalogue import Site
from calibration.drift import check
from calibration.drift.check import Blind
from calibration.drift.dots import dots
from calibration.drift.motion import Motion
from calibration.errors import CalibrationError
from calibration.playground import PLAYGROUND_MM
from calibration.procedure import Procedure, capture, show, stand_aside
from calibration.record import Accuracy, CalibrationRecord, Measurement, Region, Sample
from cell.profile import Profile


def drift(site: Site) -> Procedure:
    """Check all cameras that stand still, against the calibration by the screen in force."""
    record = next((r for r in reversed(site.current) if r.kind == "screen"), None)
    return _check(site, record)


def check_screen(site: Site, record: CalibrationRecord) -> Procedure:
    """Check a calibration by the screen on fresh pictures."""
    return _check(site, record)


def _check(site: Site, record: CalibrationRecord | None) -> Procedure:
    profile = site.profile
    if not isinstance(profile, Profile) or not profile.display.enabled:
        raise CalibrationError(f"the cell {profile.name} has no screen to check its cameras with")
    panel = check.panel_of(profile, record)
    references, blind = check.references(profile, record)
    if profile.arm.enabled:
        yield from stand_aside()
    yield from show("drift dots", dots(panel))
    lit = {}
    for one in references:
        lit[one.camera] = yield from capture(one.camera, "dots on the screen")
    yield from show("drift black", panel.field(0))
    seen: list[Motion | Blind] = list(blind)
    samples = []
    for one in references:
        dark = yield from capture(one.camera, "black screen")
        motion = check.motion_seen(one, lit[one.camera].pixels, dark.pixels, profile)
        seen.append(motion)
        if isinstance(motion, Motion):
            samples.append(
                Sample(
                    label=one.camera,
                    measured=(float(motion.dots), motion.noise_px),
                    residual_mm=motion.rms_mm,
                    is_used=False,
                    picture=lit[one.camera].digest,
                )
            )
    motions = [one for one in seen if isinstance(one, Motion)]
    stated = None if record is None else record.accuracy.stated
    return Measurement(
        kind="drift",
        subject="cell",
        method="dots on the screen, seen before and now; a small motion of each camera fitted "
        "robustly, and one of the screen",
        samples=tuple(samples),
        accuracy=Accuracy(
            held_out_rms=max((m.rms_mm for m in motions), default=None),
            held_out_max=max((m.max_mm for m in motions), default=None),
            held_out_count=sum(m.dots for m in motions),
            how="by how much the cameras' word about the playground is off now",
        ),
        region=Region(text="the playground at the block tops", outline_mm=PLAYGROUND_MM),
        findings=check.judge(seen, stated_mm=stated),
        details={"cameras": dict(check.as_details(seen))},
        based_on=() if record is None else (record.identity,),
        not_known=tuple(f"whether {b.camera} moved: {b.reason}" for b in blind),
    )
