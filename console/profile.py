"""`cell profile`: write, check, show, compare and list the profiles of cells."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from console.exits import ConsoleError, Exit
from console.options import AsJson
from console.output import has_colour, put, put_json, put_table, say

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from calibration.applying import Calibrated
    from cell.profile import CellProfile
    from cell.profile.checking import CheckedProfile
    from cell.profile.compare import Absent
    from cell.profile.listing import Leaf, ListedValue
    from cell.profile.sources import ProfileSource

app = App(name="profile")


@app.command
def new(
    name: str,
    /,
    *,
    base: Annotated[
        str, Parameter(name="--from", help="Profile whose figures it begins with.")
    ] = "mash",
    out: Annotated[
        str | None, Parameter(help="File to write; the folder of your own profiles unless given.")
    ] = None,
    force: Annotated[bool, Parameter(negative="", help="Write over a file that is there.")] = False,
) -> int:
    """Write a new profile, every field with what it is for, its unit and what it takes.

    On a terminal the serial ports that there are are offered for the devices.

    Args:
        name: Name of the new cell.
        base: Profile whose figures it begins with.
        out: File to write.
        force: Whether a file that is there is written over.
    """
    from cell.profile.fresh import fresh_profile
    from cell.profile.sources import find_profile, shipped_profiles

    if name in shipped_profiles():
        raise ConsoleError(f"{name} is the name of a shipped profile; choose another")
    source = find_profile(base)
    path = _place_for(name, out)
    if path.exists() and not force:
        raise ConsoleError(f"{path} is there already; --force writes over it")
    text = fresh_profile(name, source, _asked_ports(source))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, "utf-8")
    put(str(path))
    say(f"next: change it to your cell, then `cell profile check {out or name}`", "dim")
    return Exit.DONE


@app.command
def check(
    name: str = "mash",
    /,
    *,
    strict: Annotated[
        bool, Parameter(negative="", help="Let warnings fail the check, too.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Check a profile; exit code 1 if it has mistakes.

    Shows all mistakes and warnings with their lines, and counts the defaults taken.

    Args:
        name: Name of a profile, or the path of one.
        strict: Whether warnings fail the check, too.
        as_json: Write JSON for programs.
    """
    from cell.profile.findings import render_findings

    checked = _with_demands(_checked(name))
    source = checked.source
    defaults = _defaults_taken(checked)
    is_good = checked.profile is not None and not (strict and checked.findings)
    if as_json:
        put_json(
            {
                "profile": source.name,
                "is_good": is_good,
                "findings": [one.as_json() for one in checked.findings],
                "defaults": defaults,
            }
        )
        return Exit.DONE if is_good else Exit.FAILED
    if checked.findings:
        colour = has_colour(sys.stdout)
        put(render_findings(checked.findings, source.text, source.name, colour=colour))
    if is_good:
        put(f"{source.name} is good")
    if defaults:
        say(f"{len(defaults)} fields have their default; `cell profile show {name}` tells which")
    return Exit.DONE if is_good else Exit.FAILED


@app.command
def show(
    name: str = "mash",
    /,
    *,
    text: Annotated[bool, Parameter(negative="", help="The file as it is written.")] = False,
    calibrated: Annotated[
        bool, Parameter(negative="", help="With the calibrations in force, which go before it.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Show every value of a profile, its unit, and where it came from.

    Args:
        name: Name of a profile, or the path of one.
        text: Whether the file is shown as it is written.
        calibrated: Whether the calibrations in force take the place of the file's values.
        as_json: Write JSON for programs.
    """
    from cell.profile.listing import listed_values

    checked = _checked(name)
    profile = checked.require()
    if text and calibrated:
        raise ConsoleError("--text shows the file as it is written; leave out --calibrated")
    if calibrated:
        from console.calibrating import with_calibrations

        known = with_calibrations(profile)
        if as_json:
            put_json(known.profile.model_dump(mode="json"))
        else:
            count = len(known.records)
            in_force = "1 calibration" if count == 1 else f"{count} calibrations"
            say(f"{checked.source.name}, with {in_force} in force", "dim")
            put("\n".join(_calibrated_lines(checked, known)))
    elif as_json:
        put_json(profile.model_dump(mode="json"))
    elif text:
        put(checked.source.text.rstrip())
    else:
        say(checked.source.name, "dim")
        put("\n".join(_lines(listed_values(checked))))


@app.command
def diff(first: str, second: str, /, *, as_json: AsJson = False) -> int:
    """Compare two profiles field by field; exit code 1 if they differ.

    Defaults are filled in; order and form of the text do not matter.

    Args:
        first: Name or path of a profile.
        second: Name or path of another.
        as_json: Write JSON for programs.
    """
    from cell.profile.compare import differences

    one, other = _checked(first), _checked(second)
    found = differences(one.require(), other.require())
    if as_json:
        put_json(
            [
                {
                    "field": d.field,
                    "unit": d.unit,
                    "first": _as_data(d.first),
                    "second": _as_data(d.second),
                }
                for d in found
            ]
        )
    elif found:
        rows = [(d.field, _as_text(d.first), _as_text(d.second), d.unit) for d in found]
        put_table(("field", first, second, "unit"), rows)
        say(f"{len(found)} differences" if len(found) != 1 else "1 difference")
    else:
        put(f"{first} and {second} are the same")
    return Exit.FAILED if found else Exit.DONE


@app.command(name="list")
def list_profiles(*, as_json: AsJson = False) -> None:
    """List the shipped profiles and your own."""
    from cell.profile.sources import shipped_profiles, user_profiles, user_profiles_folder

    shipped, own = shipped_profiles(), user_profiles()
    if as_json:
        put_json([*shipped, *own])
        return
    put("\n".join([*shipped, *own]))
    say(f"your own are in {user_profiles_folder()}", "dim")


def _checked(name: str) -> CheckedProfile:
    from cell.profile.checking import check_profile
    from cell.profile.sources import find_profile

    return check_profile(find_profile(name))


def _with_demands(checked: CheckedProfile) -> CheckedProfile:
    """Return a checked profile with warnings for demands that no calibration can ever meet."""
    from dataclasses import replace

    from calibration.demands import unusable_demands
    from cell.profile.findings import Finding
    from cell.profile.toml_places import Place

    if checked.profile is None:
        return checked
    places, found = checked.places, list(checked.findings)
    for kind, problem in unusable_demands(checked.profile.demands).items():
        path = ("demands", kind)
        place = places.keys.get(path) or places.enclosing(path) or Place(0, 1, 1, 1)
        found.append(
            Finding(severity="warning", field=f"demands.{kind}", place=place, message=problem)
        )
    found.sort(key=lambda one: (one.place.start, one.severity, one.field))
    return replace(checked, findings=tuple(found))


def _place_for(name: str, out: str | None) -> Path:
    from pathlib import Path

    from cell.profile.sources import user_profiles_folder

    if out is None:
        return user_profiles_folder() / f"{name}.toml"
    if not out.endswith(".toml"):
        raise ConsoleError(f"--out {out}: the name of a profile's file ends in .toml")
    return Path(out)


def _asked_ports(source: ProfileSource) -> dict[str, str]:
    """Return the ports that whoever sits there chose; nothing where nobody does."""
    from console.ports import choose_ports, is_asked, ports_there_are

    if not is_asked():
        return {}
    import tomllib

    data = tomllib.loads(source.text)
    devices = [d for d in ("arm", "gripper", "display") if "serial" in data.get(d, {})]
    return choose_ports(devices, ports_there_are())


def _lines(values: Sequence[ListedValue]) -> list[str]:
    """Return a line for each value: `server.port = 10993   # line 6`."""
    return _beside(values, ["default" if v.line is None else f"line {v.line}" for v in values])


def _beside(values: Sequence[ListedValue], origins: Sequence[str]) -> list[str]:
    left = [f"{v.field} = {_as_text(v.value)}{f' {v.unit}' * bool(v.unit)}" for v in values]
    width = min(max(len(one) for one in left), 60)
    return [f"{one:{width}}  # {o}" for one, o in zip(left, origins, strict=True)]


def _calibrated_lines(checked: CheckedProfile, known: Calibrated[CellProfile]) -> list[str]:
    """Return a line for each value of a calibrated profile: the calibration, or the file's line."""
    from calibration.applying import setters
    from cell.profile.findings import dotted
    from cell.profile.listing import ListedValue, field_unit, leaves_of, listed_values

    by = setters(known.records)
    written = {one.path: one for one in listed_values(checked)}
    taken = {stale.path for stale in known.stale}
    values: list[ListedValue] = []
    origins: list[str] = []
    for path, value in leaves_of(known.profile):
        field = dotted(path)
        record = next((r for own, r in by.items() if f"{field}.".startswith(f"{own}.")), None)
        line = written[path].line if path in written else None
        values.append(ListedValue(path, value, field_unit(path), line))
        if record is not None:
            origins.append(f"calibration {record.identity[:8]} ({record.kind} of {record.subject})")
        elif field in taken:
            origins.append("left out: fitted with another lens")
        else:
            origins.append("default" if line is None else f"line {line}")
    return _beside(values, origins)


def _defaults_taken(checked: CheckedProfile) -> list[str]:
    from cell.profile.listing import listed_values

    if checked.profile is None:
        return []
    return [listed.field for listed in listed_values(checked) if listed.line is None]


def _as_text(value: Leaf | Absent) -> str:
    from cell.profile.compare import Absent
    from cell.profile.findings import without_passwords

    if isinstance(value, Absent):
        return "(not there)"
    if value is None:
        return "(none)"
    return without_passwords(json.dumps(value, ensure_ascii=False))


def _as_data(value: Leaf | Absent) -> Leaf:
    from cell.profile.compare import Absent

    return None if isinstance(value, Absent) else value
