"""What is set and looked at: the camera, the lights, the screen; and what came of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from calibration.camera_settings.knobs import TURNED, Knobs
from calibration.camera_settings.target import (
    Target,
    target_from_json,
)
from calibration.catalogue import Site
from calibration.procedure import (
    Steps,
    ask_choice,
    light,
    set_absolute,
    set_raw,
    show,
    stand_aside,
)
from calibration.record import Sample
from calibration.requests import Picture
from calibration.verdict import Finding
from cell.devices.camera import CameraSettings
from cell.devices.camera_configure import wanted
from cell.devices.camera_features import CameraFeature
from cell.pictures import PICTURE_NAMES
from cell.profile import Profile

KIND: Final = "camera-settings"


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What is set, and how it is looked at.

    Attributes:
        camera: Name of the camera.
        are_lights_on: State of the lights that the settings are for.
        screen: Picture on the screen, empty without a screen.
        settings: What the profile has now.
    """

    camera: str
    are_lights_on: bool
    screen: str
    settings: CameraSettings

    @property
    def subject(self) -> str:
        """What the record is about."""
        return self.camera if self.are_lights_on else f"{self.camera} lights-off"


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What a way of setting came to.

    Attributes:
        knobs: In force now.
        method: How, in a sentence.
        samples: Pictures that were taken.
        findings: What is to be said.
        target: What the pictures were compared with; None where they were not.
        last: The last picture.
        error: Mean difference of held-out patches, grey levels.
        held_out: How many patches those are.
        fit_error: The same of those that were searched with.
    """

    knobs: Knobs
    method: str
    samples: tuple[Sample, ...] = ()
    findings: tuple[Finding, ...] = ()
    target: Target | None = None
    last: Picture | None = None
    error: float | None = None
    held_out: int = 0
    fit_error: float | None = None


def ask_setting(site: Site) -> Steps[Setting]:
    """Ask which camera, for which state of the lights, in front of which picture."""
    names = sorted(site.profile.cameras)
    default = "top" if "top" in names else names[0]
    camera = yield from ask_choice("camera", "Which camera?", names, default=default)
    is_on, screen = True, ""
    if isinstance(site.profile, Profile):
        lights = yield from ask_choice(
            "lights", "For which state of the lights?", ("on", "off"), default="on"
        )
        is_on = lights == "on"
        screen = yield from ask_choice(
            "screen",
            "Which picture shall the screen show meanwhile?",
            PICTURE_NAMES,
            default="black" if is_on else "mash",
        )
    settings = site.profile.cameras[camera].settings_for(are_lights_on=is_on)
    return Setting(camera=camera, are_lights_on=is_on, screen=screen, settings=settings)


def prepare(site: Site, setting: Setting) -> Steps[None]:
    """Bring arm, screen and lights to where the settings' pictures are taken."""
    if isinstance(site.profile, Profile):
        yield from stand_aside()
        yield from show(setting.screen)
        yield from light(is_on=setting.are_lights_on)


def take_back(camera: str, features: tuple[CameraFeature, ...]) -> Steps[None]:
    """Set by hand what is left to the camera, at the value it has."""
    for feature in features:
        if feature.control not in ("auto", "one-push") or feature.name == "frame_rate":
            continue
        if feature.absolute is not None and feature.absolute_range is not None:
            yield from set_absolute(camera, feature.name, feature.absolute)
        elif feature.raw is not None:
            yield from set_raw(camera, feature.name, feature.raw)


def set_the_others(
    camera: str, features: tuple[CameraFeature, ...], settings: CameraSettings
) -> Steps[None]:
    """Set what is not searched as the profile has it, where the camera can have it."""
    by_name = {feature.name: feature for feature in features}
    for item in wanted(settings):
        feature = by_name.get(item.name)
        if item.name in TURNED or feature is None:
            continue
        span = feature.raw_range if item.is_raw else feature.absolute_range
        if span is None or not span[0] <= item.value <= span[1]:
            continue
        now = feature.raw if item.is_raw else feature.absolute
        if now is not None and math.isclose(now, item.value, rel_tol=1e-3, abs_tol=1e-6):
            continue
        if item.is_raw:
            yield from set_raw(camera, item.name, int(item.value))
        else:
            yield from set_absolute(camera, item.name, item.value)


def kept_record_target(site: Site, subject: str) -> tuple[Target, float | None] | None:
    """Return the target that the record in force keeps, with its exposure's logarithm."""
    for record in site.current:
        if record.kind == KIND and record.subject == subject and "patches" in record.details:
            source = f"the reference of {record.measured_at:%Y-%m-%d}"
            target = target_from_json(record.details["patches"], source)
            exposure = record.details.get("exposure_log")
            return target, exposure if isinstance(exposure, float) else None
    return None
