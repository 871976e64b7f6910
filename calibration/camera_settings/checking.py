"""Whether a camera's settings still hold: is it set as it was, does the picture look so."""

from __future__ import annotations

import math

from pydantic import JsonValue

from calibration.camera_settings import judge
from calibration.camera_settings.setting import KIND, Setting, prepare
from calibration.camera_settings.target import Match, Target, match, target_from_json
from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.procedure import Procedure, capture, read_features
from calibration.record import Accuracy, CalibrationRecord, Measurement, Region, Sample
from calibration.verdict import Finding, Grade, worst
from cell.devices.camera_features import UNITS, CameraFeature, quantity

_MOST_LEVEL_CHANGE = 0.07
_BAD_LEVEL_CHANGE = 0.25
_MOST_COLOUR_CHANGE = 0.04
_SAME_VALUE = 2e-3


def check_camera_settings(site: Site, record: CalibrationRecord) -> Procedure:
    """Compare features and a fresh picture with what a record keeps."""
    setting = _setting_of(site, record)
    target = target_from_json(
        record.details.get("patches"), f"the picture of {record.measured_at:%Y-%m-%d}"
    )
    yield from prepare(site, setting)
    picture = yield from capture(setting.camera, "fresh picture")
    features = yield from read_features(setting.camera)
    findings = list(judge.auto_finding(features, "are", Grade.BAD))
    findings += _changed_features(features, record.details.get("features"))
    seen = match(target, picture.pixels, setting.settings.gamma)
    scene = list(judge.scene_findings(target, seen, picture.pixels, is_whole_picture=True))
    findings += scene
    if worst(scene) is not Grade.BAD:
        findings += _light_changes(target, seen, setting)
        findings += judge.focus_findings(judge.sharpness_of(picture.pixels), target.sharpness)
    factor = [math.exp(-log) for log in seen.log_ratios]
    return Measurement(
        kind=KIND,
        subject=record.subject,
        method="a fresh picture compared with the kept patches",
        samples=(
            Sample(
                label="fresh picture",
                measured=(factor[0], factor[1], factor[2]),
                picture=picture.digest,
            ),
        ),
        accuracy=Accuracy(
            held_out_rms=seen.error if math.isfinite(seen.error) else None,
            held_out_count=seen.held_out,
            how="mean difference of the patches",
            unit="grey levels",
        ),
        region=Region(text=record.region.text),
        findings=tuple(findings),
        details={"light_factor": [factor[0], factor[1], factor[2]]},
        based_on=(record.identity,),
    )


def _setting_of(site: Site, record: CalibrationRecord) -> Setting:
    camera, lights, screen = (record.details.get(k) for k in ("camera", "lights", "screen"))
    if not isinstance(camera, str) or camera not in site.profile.cameras:
        raise CalibrationError(
            f"the record is about camera {camera!r}, which the profile does not have; calibrate "
            "again"
        )
    is_on = lights != "off"
    return Setting(
        camera=camera,
        are_lights_on=is_on,
        screen=screen if isinstance(screen, str) else "",
        settings=site.profile.cameras[camera].settings_for(are_lights_on=is_on),
    )


def _changed_features(features: tuple[CameraFeature, ...], kept: JsonValue) -> list[Finding]:
    if not isinstance(kept, dict):
        return []
    changed = []
    for feature in features:
        was = kept.get(feature.name)
        has_unit = feature.absolute is not None
        now = feature.absolute if has_unit else feature.raw
        if not isinstance(was, int | float) or now is None:
            continue
        if not math.isclose(now, was, rel_tol=_SAME_VALUE, abs_tol=1e-2):
            unit = UNITS.get(feature.name, "")
            changed.append(f"{feature.name} {quantity(now, unit)} instead of {was:g}")
    if not changed:
        return []
    return [
        Finding(
            code="settings-changed",
            grade=Grade.BAD,
            text=f"the camera is not set as it was: {', '.join(changed)}",
            hint="open the camera again; see that no other program sets it",
        )
    ]


def _light_changes(target: Target, seen: Match, setting: Setting) -> list[Finding]:
    """Return how light or camera have changed since."""
    if seen.usable == 0 and seen.clipped_share > seen.dark_share:
        text = "the picture is clipped all over where the kept one was not"
        return [Finding(code="light-changed", grade=Grade.BAD, text=text, hint=_AGAIN)]
    red, green, blue = (math.exp(-log) for log in seen.log_ratios)
    if setting.are_lights_on and (green < 0.1 or seen.usable == 0):
        return list(judge.light_findings(min(green, 0.05), target.source))
    findings = []
    if abs(green - 1.0) > _MOST_LEVEL_CHANGE:
        is_bad = abs(math.log(green)) > math.log1p(_BAD_LEVEL_CHANGE)
        findings.append(
            Finding(
                code="light-changed",
                grade=Grade.BAD if is_bad else Grade.DEGRADED,
                text=f"there is {100 * green:.0f} % of the light of {target.source}: lamps age "
                "and sunlight comes and goes",
                hint=_AGAIN,
            )
        )
    tint = max(abs(red / green - 1.0), abs(blue / green - 1.0))
    if tint > _MOST_COLOUR_CHANGE:
        findings.append(
            Finding(
                code="colour-changed",
                grade=Grade.DEGRADED,
                text=f"against green, red is {100 * red / green:.0f} % and blue "
                f"{100 * blue / green:.0f} % of what they were in {target.source}",
                hint=_AGAIN,
            )
        )
    return findings


_AGAIN = "replace the lamps or shut out the sun, or set the camera again"
