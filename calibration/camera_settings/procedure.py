"""The procedure: one camera, one state of the lights, settings by reference, hand or table."""

from __future__ import annotations

from typing import Final

from pydantic import JsonValue

from calibration.camera_settings import judge
from calibration.camera_settings.keeping import look, measurement, profile_values
from calibration.camera_settings.knobs import knobs_of, turn
from calibration.camera_settings.presets import TABLE_C1
from calibration.camera_settings.setting import (
    ask_setting,
    kept_record_target,
    prepare,
    set_the_others,
    take_back,
)
from calibration.camera_settings.ways import by_reference, by_values
from calibration.catalogue import Site
from calibration.procedure import (
    Procedure,
    ask_choice,
    ask_number,
    capture,
    read_features,
)
from calibration.verdict import Grade, worst

METHODS: Final = ("reference", "grey", "by-hand", "table")


def camera_settings(site: Site) -> Procedure:
    """Set shutter, gain and white balance of a camera, and say how good the picture is.

    Where that cannot be done, the camera gets back what it had.
    """
    setting = yield from ask_setting(site)
    yield from prepare(site, setting)
    before = yield from capture(setting.camera, "as it is")
    features = yield from read_features(setting.camera)
    findings = list(judge.auto_finding(features, "were", Grade.OK))
    yield from take_back(setting.camera, features)
    yield from set_the_others(setting.camera, features, setting.settings)
    features = yield from read_features(setting.camera)
    mains_hz = yield from ask_number(
        "mains", "Which frequency has the mains?", unit="Hz", default=50.0
    )
    knobs = knobs_of(features, mains_hz)
    has_reference = kept_record_target(site, setting.subject) is not None
    method = yield from ask_choice(
        "method",
        "How shall the camera be set?",
        METHODS,
        default="table" if setting.camera in TABLE_C1 and not has_reference else "reference",
    )
    if method in ("reference", "grey"):
        outcome = yield from by_reference(site, setting, knobs, method, before)
    else:
        outcome = yield from by_values(setting, knobs, method)
    findings += outcome.findings
    if worst(findings) is Grade.BAD:
        yield from turn(setting.camera, outcome.knobs, knobs.values)
        return measurement(setting, outcome, findings, {}, values={})
    details, more = yield from look(setting, outcome)
    findings += more
    features = yield from read_features(setting.camera)
    findings += judge.auto_finding(features, "are again", Grade.BAD)
    values: dict[str, JsonValue] = {}
    if worst(findings) is not Grade.BAD:
        values = profile_values(site, setting, outcome.knobs, findings)
    return measurement(setting, outcome, findings, details, values=values)
