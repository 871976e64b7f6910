"""`cell check`: what is wrong with a script, and whether it fits a cell."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from console.exits import Exit
from console.options import AsJson, ProfileName
from console.output import has_colour, put, put_json, say

if TYPE_CHECKING:
    from dsl.diagnostics import Diagnostic


def check(
    script: str,
    /,
    *,
    profile: ProfileName = "mash",
    no_profile: Annotated[
        bool, Parameter(negative="", help="Check only what needs no cell.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Check a script; exit code 1 if it has errors.

    Args:
        script: Path of a script, or the name of a shipped one.
        profile: Profile of the cell that it shall run in.
        no_profile: Whether no cell is looked at.
        as_json: Write JSON for programs.
    """
    from console.scripts import read_script
    from dsl.compiler import compile_script
    from dsl.render import render_diagnostics
    from dsl.site import check_on_site

    file_name, text = read_script(script)
    compiled = compile_script(text, file_name)
    found = compiled.diagnostics
    if compiled.program is not None and not no_profile:
        from calibration.checks import Checks
        from calibration.demands import unusable_demands
        from cell.profile import load_profile
        from console.calibrating import with_calibrations
        from console.places import calibrations_folder
        from sessions.quality import shortcomings
        from sessions.site import ProfileSite

        known = with_calibrations(load_profile(profile))
        found += check_on_site(compiled.program, ProfileSite(known.profile, known.records))
        checks = Checks(calibrations_folder(known.profile.name))
        for kind, problem in unusable_demands(known.profile.demands).items():
            say(f"warning: [demands] {kind}: {problem}", "yellow")
        for problem in shortcomings(known.profile, known.records, checks=checks):
            say(f"warning: no task will begin: {problem}", "yellow")
    is_good = not any(one.severity == "error" for one in found)
    if as_json:
        put_json(
            {
                "script": file_name,
                "is_good": is_good,
                "diagnostics": [_as_json(one) for one in found],
            }
        )
    elif found:
        put(render_diagnostics(found, text, file_name, colour=has_colour(sys.stdout)))
    else:
        where = "" if no_profile else f", and fits the cell {profile}"
        put(f"{file_name} is good{where}")
    return Exit.DONE if is_good else Exit.FAILED


def _as_json(one: Diagnostic) -> dict[str, object]:
    return {
        "code": one.code,
        "severity": one.severity,
        "line": one.span.line,
        "column": one.span.column,
        "end_line": one.span.end_line,
        "end_column": one.span.end_column,
        "message": one.message,
        "hint": one.hint,
    }
