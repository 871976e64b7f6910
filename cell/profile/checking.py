"""All checks of a profile: every mistake and warning at once, each where it stands."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from pydantic import ValidationError, create_model

from cell.profile.cell import CellProfile, Profile
from cell.profile.findings import Finding, InvalidProfile, dotted
from cell.profile.rules import Problem, broken_rules
from cell.profile.sources import ProfileSource
from cell.profile.toml_places import Place, TomlPlaces, locate, place_at
from cell.profile.validation import PLAYGROUND_TABLES, Explainer

_TOP: Final = Place(0, 1, 1, 1)
_PLAYGROUND_ARM: Final = "melfa-rv6sdl"
_SURELY: Final = 3
"""So many tables of a playground mean one, even if the arm is another."""


@dataclass(frozen=True, slots=True)
class CheckedProfile:
    """A profile's text after all checks.

    Attributes:
        source: The text.
        places: Where everything in it stands.
        findings: Mistakes and warnings, in the order of the text.
        profile: The profile; None if there are mistakes.
    """

    source: ProfileSource
    places: TomlPlaces
    findings: tuple[Finding, ...]
    profile: CellProfile | None

    @property
    def errors(self) -> tuple[Finding, ...]:
        """The findings that keep the profile from being used."""
        return tuple(one for one in self.findings if one.severity == "error")

    def require(self) -> CellProfile:
        """Return the profile.

        Raises:
            InvalidProfile: There are mistakes; the text shows all.
        """
        if self.profile is None:
            raise InvalidProfile(self.source.name, self.source.text, self.errors)
        return self.profile


def check_profile(source: ProfileSource) -> CheckedProfile:
    """Check a profile: all mistakes and warnings at once."""
    places = locate(source.text)
    try:
        data = tomllib.loads(source.text)
    except tomllib.TOMLDecodeError as error:
        return CheckedProfile(source, places, (_no_toml(source.text, places, error),), None)
    except RecursionError:
        deep = Finding(severity="error", field="", place=_TOP, message="it is nested too deeply")
        return CheckedProfile(source, places, (deep,), None)
    model = _model_of(data)
    profile, sound, findings = _validated(model, data, places)
    findings += [_found(problem, places) for problem in broken_rules(profile, sound)]
    findings.sort(key=lambda one: (one.place.start, one.severity, one.field))
    is_good = not any(one.severity == "error" for one in findings)
    return CheckedProfile(source, places, tuple(findings), profile if is_good else None)


def _model_of(data: Mapping[str, object]) -> type[CellProfile]:
    """Return which kind of profile a document is meant to be."""
    arm = data.get("arm")
    model = arm.get("model") if isinstance(arm, dict) else None
    tables = sum(table in data for table in PLAYGROUND_TABLES)
    is_playground = tables >= (1 if model == _PLAYGROUND_ARM else _SURELY)
    return Profile if is_playground else CellProfile


def _validated(
    model: type[CellProfile], data: Mapping[str, object], places: TomlPlaces
) -> tuple[CellProfile, list[str], list[Finding]]:
    """Return the profile or what is sound of it, the names of its sound tables, and mistakes."""
    text = json.dumps(data, default=str)
    try:
        return model.model_validate_json(text, strict=True), list(model.model_fields), []
    except ValidationError as error:
        findings = Explainer(model, data, places).findings(error)
        wrong = {one["loc"][0] for one in error.errors()}
    sound = [name for name in model.model_fields if name not in wrong]
    part_model = create_model(
        "Part",
        __base__=None,
        __config__=model.model_config,
        **{n: (model.model_fields[n].annotation, model.model_fields[n]) for n in sound},  # type: ignore[call-overload]
    )
    part = part_model.model_validate_json(
        json.dumps({k: v for k, v in data.items() if k in sound}, default=str), strict=True
    )
    return model.model_construct(**{n: part.__dict__[n] for n in sound}), sound, findings


def _found(problem: Problem, places: TomlPlaces) -> Finding:
    return Finding(
        severity=problem.severity,
        field=dotted(problem.path),
        place=places.of_value(problem.path) or places.enclosing(problem.path) or _TOP,
        message=problem.message,
        hint=problem.hint,
        other=None if problem.other is None else places.of_value(problem.other),
    )


def _no_toml(text: str, places: TomlPlaces, error: tomllib.TOMLDecodeError) -> Finding:
    if places.repeated and "overwrite" in str(error) or "twice" in str(error):
        for path, again in places.repeated:
            return Finding(
                severity="error",
                field=dotted(path),
                place=again,
                message=f"`{dotted(path)}` is given twice",
                hint="keep one of them",
                other=places.keys.get(path) or places.tables.get(path),
            )
    found = re.match(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)$", str(error))
    what = found.group(1) if found else str(error)
    if found and found.group(2):
        place = place_at(text, int(found.group(2)), int(found.group(3)))
    else:
        place = place_at(text, text.rstrip().count("\n") + 1, len(text))
    what = what[:1].lower() + what[1:]
    return Finding(
        severity="error",
        field="",
        place=place,
        message=f"this is not TOML: {what}",
        hint="texts stand in quotation marks, decimals have a point, lists stand in [ ]",
    )
