"""The ways to set a camera: by a reference, a grey area, typed values, the table."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from calibration.camera_settings import judge
from calibration.camera_settings.knobs import Knobs, turn
from calibration.camera_settings.presets import TABLE_C1, TABLE_SOURCE
from calibration.camera_settings.search import Found, search
from calibration.camera_settings.setting import Outcome, Setting, kept_record_target
from calibration.camera_settings.target import (
    FULL_SIZE,
    Target,
    grey_target,
    target_of,
)
from calibration.catalogue import Site
from calibration.procedure import (
    Steps,
    ask_choice,
    ask_number,
    ask_numbers,
    ask_text,
    capture,
    read_picture,
)
from calibration.record import Sample
from calibration.requests import Picture
from calibration.verdict import Finding, Grade, worst
from cell.devices.camera import CameraSettings
from cell.devices.camera_features import UNITS, FeatureName


def by_reference(
    site: Site, setting: Setting, knobs: Knobs, method: str, before: Picture
) -> Steps[Outcome]:
    """Search the settings at which the picture looks like a reference."""
    what = f"searched until the patches match {'grey' if method == 'grey' else 'a reference'}"
    basis_log = _exposure_log(knobs, setting.settings)
    basis = "the profile's settings"
    target: Target | None = None
    finding: Finding | None = None
    if method == "grey":
        target = yield from _ask_grey()
    else:
        kept = kept_record_target(site, setting.subject)
        path = yield from ask_text(
            "reference",
            "Which picture shows how it was when it was right? Empty for the one kept.",
            default="",
        )
        if path:
            target, finding = yield from _read_target(path)
        elif kept is not None:
            target = kept[0]
            if kept[1] is not None:
                basis_log, basis = kept[1], target.source
        else:
            finding = _no_reference(setting)
    if target is None:
        refused = () if finding is None else (finding,)
        return Outcome(knobs=knobs, method=what, findings=refused, last=before)
    early = tuple(judge.target_findings(target))
    if worst(early) is Grade.BAD:
        return Outcome(knobs=knobs, method=what, findings=early, target=target, last=before)
    found = yield from search(setting.camera, target, knobs, gamma=setting.settings.gamma)
    findings = (*early, *_judged(found, target, setting, method, basis_log, basis))
    best = found.best
    return Outcome(
        knobs=best.knobs,
        method=f"{what}, {len(found.tries)} pictures",
        samples=_samples(before, found),
        findings=findings,
        target=target,
        last=best.picture,
        error=best.match.error if math.isfinite(best.match.error) else None,
        held_out=best.match.held_out,
        fit_error=best.match.fit_error if math.isfinite(best.match.fit_error) else None,
    )


def _judged(
    found: Found, target: Target, setting: Setting, method: str, basis_log: float, basis: str
) -> list[Finding]:
    best = found.best
    findings = list(
        judge.scene_findings(
            target, best.match, best.picture.pixels, is_whole_picture=method != "grey"
        )
    )
    if worst(findings) is Grade.BAD:
        return findings
    if setting.are_lights_on:
        green = best.match.log_ratios[1]
        findings += judge.light_findings(
            math.exp(basis_log - best.knobs.exposure_log - green), basis
        )
    if worst(findings) is not Grade.BAD:
        findings += judge.search_findings(found, target)
    return findings


def _ask_grey() -> Steps[Target]:
    box = yield from ask_numbers(
        "grey_area",
        "Where is something grey or white? Left, top, right, bottom in the picture.",
        count=4,
        unit="px",
    )
    level = yield from ask_number(
        "grey_level", "How bright shall it be?", unit="grey levels", default=200.0
    )
    return grey_target((box[0], box[1], box[2], box[3]), level)


def _read_target(path: str) -> Steps[tuple[Target | None, Finding | None]]:
    picture = yield from read_picture(path)
    if picture.pixels.shape != FULL_SIZE:
        height, width = picture.pixels.shape[:2]
        return None, Finding(
            code="reference-size",
            grade=Grade.BAD,
            text=f"the reference {path} has {width} x {height} px, the camera's pictures 1280 x "
            "960: it is of another camera or was changed",
            hint="take the reference with this camera, in its full size",
        )
    return target_of(picture.pixels, f"the reference {path}"), None


def _no_reference(setting: Setting) -> Finding:
    return Finding(
        code="no-reference",
        grade=Grade.BAD,
        text=f"no reference of camera {setting.subject} is kept and none was given",
        hint="set the camera from the table (`--set method=table`), by a grey area (grey) or by "
        "hand (by-hand) first; its picture is then the reference",
    )


def by_values(setting: Setting, knobs: Knobs, method: str) -> Steps[Outcome]:
    """Set typed values, or those of the table."""
    if method == "table":
        default = setting.camera if setting.camera in TABLE_C1 else None
        row = yield from ask_choice(
            "table_row", "Which camera of table C.1?", tuple(TABLE_C1), default=default
        )
        chosen, what = TABLE_C1[row], f"{TABLE_SOURCE}, camera {row}"
    else:
        chosen, what = (yield from _ask_values(setting.settings)), "typed by hand"
    values = _values_of(chosen)
    listed = [(name, value, UNITS.get(name, "")) for name, value in values.items()]
    refused = tuple(judge.range_findings(knobs, listed))
    if refused:
        return Outcome(knobs=knobs, method=what, findings=refused)
    raw_only = [k.name for k in knobs if not k.is_absolute and k.name in ("shutter", "gain")]
    if raw_only:
        unset = Finding(
            code="raw-only",
            grade=Grade.BAD,
            text=f"{', '.join(raw_only)} of this camera can be set by raw values alone",
            hint="search by a reference or a grey area, which needs no units",
        )
        return Outcome(knobs=knobs, method=what, findings=(unset,))
    knobs = yield from turn(setting.camera, knobs, values)
    picture = yield from capture(setting.camera, "as set")
    sample = Sample(label="as set", given=given(knobs), picture=picture.digest)
    return Outcome(knobs=knobs, method=what, samples=(sample,), last=picture)


def _ask_values(now: CameraSettings) -> Steps[CameraSettings]:
    shutter = yield from ask_number("shutter", "Shutter?", unit="ms", default=now.shutter_ms)
    gain = yield from ask_number("gain", "Gain?", unit="dB", default=now.gain_db)
    red = yield from ask_number(
        "white_balance_red", "White balance red?", default=float(now.white_balance_red)
    )
    blue = yield from ask_number(
        "white_balance_blue", "White balance blue?", default=float(now.white_balance_blue)
    )
    return replace(
        now,
        shutter_ms=shutter,
        gain_db=gain,
        white_balance_red=round(red),
        white_balance_blue=round(blue),
    )


def _samples(before: Picture, found: Found) -> tuple[Sample, ...]:
    samples = [Sample(label="as it was", picture=before.digest, is_used=False)]
    for number, one in enumerate(found.tries, start=1):
        means = one.picture.pixels[::8, ::8].reshape(-1, 3).mean(axis=0)
        error = one.match.fit_error if math.isfinite(one.match.fit_error) else 255.0
        samples.append(
            Sample(
                label=f"picture {number}" + (", the best" if one is found.best else ""),
                given=given(one.knobs),
                measured=tuple(float(v) for v in np.round(means, 2)),
                residual=(error,),
                picture=one.picture.digest if one is found.best else "",
            )
        )
    return tuple(samples)


def _values_of(settings: CameraSettings) -> dict[FeatureName, float]:
    return {
        "shutter": settings.shutter_ms,
        "gain": settings.gain_db,
        "white_balance_red": float(settings.white_balance_red),
        "white_balance_blue": float(settings.white_balance_blue),
    }


def _exposure_log(knobs: Knobs, settings: CameraSettings) -> float:
    """Return the logarithm of the exposure that settings stand for."""
    values = _values_of(settings)
    return knobs.with_values(
        {n: v for n, v in values.items() if _is_absolute(knobs, n)}
    ).exposure_log


def _is_absolute(knobs: Knobs, name: FeatureName) -> bool:
    return any(knob.name == name and knob.is_absolute for knob in knobs)


def given(knobs: Knobs) -> tuple[float, ...]:
    """Return the values of the knobs, in their order, for a sample."""
    return tuple(knobs.values.values())
