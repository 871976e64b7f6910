"""What is kept of a camera's settings: what the profile gets, and what `check` needs."""

from __future__ import annotations

from dataclasses import asdict, replace

from pydantic import JsonValue

from calibration.camera_settings import judge
from calibration.camera_settings.knobs import TURNED, Knobs
from calibration.camera_settings.setting import KIND, Outcome, Setting
from calibration.camera_settings.target import (
    match,
    target_of,
)
from calibration.catalogue import Site
from calibration.procedure import (
    Steps,
    capture,
    tell,
)
from calibration.record import Accuracy, Measurement, Parameter, Region
from calibration.verdict import Finding, Grade
from cell.devices.camera_features import UNITS, FeatureName
from cell.vision.picture_measures import flicker, histogram

_FLICKER_PICTURES = 5


def look(
    setting: Setting, outcome: Outcome
) -> Steps[tuple[dict[str, JsonValue], tuple[Finding, ...]]]:
    """Look at the picture with the settings in force: histogram, focus, flicker."""
    findings = list(judge.knob_findings(outcome.knobs))
    pictures = []
    digests = set()
    for number in range(_FLICKER_PICTURES):
        picture = yield from capture(setting.camera, f"flicker {number + 1}")
        pictures.append(picture.pixels)
        digests.add(picture.digest)
    last = pictures[-1]
    swing = flicker(pictures)
    if setting.are_lights_on:
        findings += judge.flicker_findings(swing, outcome.knobs)
    fresh = target_of(last, "the picture as set")
    target = outcome.target
    is_scene = target is not None and target.sharpness > 0.0
    kept = target if target is not None and is_scene else fresh
    findings += judge.focus_findings(fresh.sharpness, kept.sharpness)
    if not is_scene:
        if judge.contrast(last) < 0.06:
            findings += judge.scene_findings(fresh, match(fresh, last), last, is_whole_picture=True)
        findings += judge.target_findings(fresh)
    counts = histogram(last)
    yield from tell(f"clipped {100 * max(counts.clipped_share):.1f} %, focus {fresh.sharpness:.2f}")
    details: dict[str, JsonValue] = {
        "camera": setting.camera,
        "lights": "on" if setting.are_lights_on else "off",
        "screen": setting.screen,
        "patches": kept.as_json(),
        "exposure_log": outcome.knobs.exposure_log,
        "features": dict(outcome.knobs.values.items()),
        "mains_hz": outcome.knobs.mains_hz,
        "histogram_means": list(counts.means),
        "clipped_share": list(counts.clipped_share),
        "focus": fresh.sharpness,
        # Pictures that are the same to the last bit were not taken one after the other.
        "flicker_share": swing.swing_share if len(digests) == len(pictures) else None,
    }
    return details, tuple(findings)


def profile_values(
    site: Site, setting: Setting, knobs: Knobs, findings: list[Finding]
) -> dict[str, JsonValue]:
    """Return what the profile is to have."""
    where = f"cameras.{setting.camera}"
    raw: dict[str, JsonValue] = {
        k.name: int(k.value) for k in knobs if not k.is_absolute and k.name in TURNED[:2]
    }
    settings = replace(
        setting.settings,
        shutter_ms=_absolute(knobs, "shutter", setting.settings.shutter_ms),
        gain_db=_absolute(knobs, "gain", setting.settings.gain_db),
        white_balance_red=round(
            knobs.values.get("white_balance_red", setting.settings.white_balance_red)
        ),
        white_balance_blue=round(
            knobs.values.get("white_balance_blue", setting.settings.white_balance_blue)
        ),
    )
    if raw and not setting.are_lights_on:
        findings.append(
            Finding(
                code="raw-only",
                grade=Grade.BAD,
                text=f"{', '.join(raw)} of this camera can be set by raw values alone, which the "
                "profile keeps for one state of the lights",
                hint="keep the settings of lights on, or reach the camera through a backend "
                "with absolute values",
            )
        )
        return {}
    field = "settings" if setting.are_lights_on else "settings_lights_off"
    values: dict[str, JsonValue] = {f"{where}.{field}": dict(asdict(settings))}
    if raw:
        before = site.profile.cameras[setting.camera].raw
        merged: dict[str, JsonValue] = dict(before.items())
        values[f"{where}.raw"] = merged | raw
    return values


def measurement(
    setting: Setting,
    outcome: Outcome,
    findings: list[Finding],
    details: dict[str, JsonValue],
    *,
    values: dict[str, JsonValue],
) -> Measurement:
    """Return what the procedure leaves behind."""
    parameters = tuple(
        Parameter(name=knob.name, value=knob.value, unit=UNITS.get(knob.name, ""))
        for knob in outcome.knobs
    )
    not_known = ["whether the light stays as it is; `cell calibration check` tells"]
    if details.get("flicker_share") is None:
        not_known.append("whether the light flickers: there were no pictures in a row")
    if outcome.error is None:
        not_known.append("how far colours are from what they should be: there was no reference")
    return Measurement(
        kind=KIND,
        subject=setting.subject,
        method=outcome.method,
        samples=outcome.samples,
        parameters=parameters,
        accuracy=Accuracy(
            fit_rms=outcome.fit_error,
            held_out_rms=outcome.error,
            held_out_max=None,
            held_out_count=outcome.held_out,
            how="mean difference of the patches that the search did not use"
            if outcome.error is not None
            else "",
            unit="grey levels",
        ),
        region=Region(
            text=f"pictures of camera {setting.camera} with the lights "
            f"{'on' if setting.are_lights_on else 'off'}"
        ),
        findings=tuple(findings),
        values=values,
        details=details,
        not_known=tuple(not_known),
    )


def _absolute(knobs: Knobs, name: FeatureName, default: float) -> float:
    knob = next((k for k in knobs if k.name == name), None)
    return knob.value if knob is not None and knob.is_absolute else default
