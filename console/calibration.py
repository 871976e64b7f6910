"""`cell calibration`: the kept calibrations: look at them, check, compare, take back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from console.calibrating import age_of, archive_of, now, stated_accuracy, with_calibrations
from console.exits import ConsoleError, Exit
from console.options import AsJson, ProfileName, WiresOption
from console.output import put, put_json, put_table, say

if TYPE_CHECKING:
    from collections.abc import Container

    from calibration.applying import Misfit
    from calibration.archive import Archive, Slot
    from calibration.record import CalibrationRecord
    from cell.profile import CellProfile

app = App(name="calibration")

_NONE = "no calibration of the cell {} is in force; `cell calibrate` lists what can be calibrated"


@app.command(name="list")
def list_calibrations(*, profile: ProfileName = "mash", as_json: AsJson = False) -> None:
    """List the calibrations in force.

    Args:
        profile: Profile of the cell.
        as_json: Write JSON for programs.
    """
    from calibration.checks import grade_in
    from console.drifting import last_check_of

    loaded = _load(profile)
    archive = archive_of(loaded)
    records, problems = archive.readable()
    # Tells those that do not fit the profile.
    found = with_calibrations(loaded)
    known, left_out = found.profile, {one.record.identity: one.problem for one in found.misfits}
    last, at = last_check_of(loaded), now()
    words = {record.identity: grade_in(last, known, record) for record in records}
    day = "" if last is None else f" {last.at:%Y-%m-%d %H:%M}"
    if as_json:
        put_json([{**_in_list(record, archive, age_s=(at - record.measured_at).total_seconds()),
                   "last_check": words[record.identity] or None,
                   "left_out": left_out.get(record.identity)}
                  for record in records])  # fmt: skip
        return
    if not records:
        if not problems:
            say(_NONE.format(loaded.name))
        return
    rows = [
        (
            record.kind,
            record.subject,
            "left out" if record.identity in left_out else record.grade.value,
            stated_accuracy(record),
            age_of(record, at),
            words[record.identity] + day if words[record.identity] else "-",
            " ".join(one[:8] + _base_word(archive, one, left_out) for one in record.based_on)
            or "-",
            record.identity[:8],
        )
        for record in records
    ]  # fmt: skip
    put_table(("kind", "subject", "grade", "accuracy", "age", "last check", "based on", "id"), rows)
    for misfit in found.misfits:
        put(_left_out_words(misfit))


@app.command
def show(
    calibration: Annotated[str, Parameter(help="First digits of its id, or a kind.")],
    subject: Annotated[str, Parameter(help="Of what, where a kind has several.")] = "",
    /,
    *,
    profile: ProfileName = "mash",
    picture: Annotated[
        Path | None, Parameter(help="Write a picture of its samples to this PNG file.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show everything that a kept calibration holds, also one that is not in force.

    Args:
        calibration: Which one.
        subject: Of what.
        profile: Profile of the cell.
        picture: File for a picture of its samples.
        as_json: Write JSON for programs.
    """
    from console.calibration_views import put_whole

    archive = archive_of(_load(profile))
    record = _find(archive, calibration, subject)
    in_force = archive.in_force(_slot(record))
    put_whole(
        record,
        is_in_force=in_force is not None and in_force.identity == record.identity,
        as_json=as_json,
    )
    if picture is not None:
        from calibration.overview import overview_of
        from calibration.pictures import encode_png

        png = encode_png(overview_of(record, archive))
        try:
            picture.write_bytes(png)
        except OSError as error:
            raise ConsoleError(
                f"the picture cannot be written to {picture}: {error.strerror or error}; name a "
                "file that can be",
                Exit.ENVIRONMENT,
            ) from error
        say(f"the samples are drawn in {picture}", "dim")


@app.command
def check(
    kind: Annotated[str, Parameter(help="Only this kind; all that are in force without.")] = "",
    subject: Annotated[str, Parameter(help="Only of this.")] = "",
    /,
    *,
    profile: ProfileName = "mash",
    script: str = "mash",
    wires: WiresOption = "memory",
    set_: Annotated[
        list[str] | None,
        Parameter(name="--set", negative="", help="An answer, KEY=VALUE; may be given again."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Check on fresh pictures whether calibrations still hold; exit code 1 if one is BAD.

    Nothing is kept or changed.

    Args:
        kind: Which kind.
        subject: Of what.
        profile: Profile of the cell.
        script: The script whose store it is; path, or the name of a shipped one.
        wires: How devices are reached.
        set_: Single answers.
        as_json: Write JSON for programs.
    """
    from calibration.answers import GivenAnswers, parse_settings
    from calibration.catalogue import has_check, start_check
    from calibration.errors import CalibrationError
    from calibration.verdict import Grade
    from console.calibrate import open_session
    from console.calibration_views import verdict_lines

    try:
        asked = GivenAnswers(parse_settings(set_ or []))
    except CalibrationError as error:
        raise ConsoleError(str(error)) from error
    session = open_session(profile, script, wires)
    in_force = [
        record
        for record in session.site.current
        if kind in ("", record.kind) and subject in ("", record.subject)
    ]
    wanted = [record for record in in_force if kind or has_check(record)]
    if not wanted:
        left_out = [
            _left_out_words(one)
            for one in session.known.misfits
            if kind in ("", one.record.kind) and subject in ("", one.record.subject)
        ]
        cell_name = session.file_profile.name
        say("\n".join(left_out) or _nothing_to_check(cell_name, kind, in_force))
        return Exit.FAILED if left_out else Exit.USAGE if kind else Exit.DONE
    told, grades = [], []
    for record in wanted:
        found = session.play(start_check(record, session.site), asked, journal=None)
        grades.append(found.grade)
        if as_json:
            told.append({"checked": record.identity, "kind": record.kind, "subject":
                         record.subject, **found.model_dump(mode="json"),
                         "grade": found.grade.value})  # fmt: skip
            continue
        put(f"{record.kind} of {record.subject}  {record.identity[:12]}")
        put("\n".join(verdict_lines(found)))
    if as_json:
        put_json(told)
    return Exit.FAILED if Grade.BAD in grades else Exit.DONE


@app.command
def diff(
    first: Annotated[str, Parameter(help="First digits of a calibration's id.")],
    second: Annotated[str, Parameter(help="First digits of another one's.")],
    /,
    *,
    profile: ProfileName = "mash",
    as_json: AsJson = False,
) -> None:
    """Compare two kept calibrations: values, mm at the playground's corners, parameters.

    Args:
        first: One calibration.
        second: The other.
        profile: Profile of the cell.
        as_json: Write JSON for programs.
    """
    from calibration.diffing import difference
    from cell.profile import Profile
    from console.calibration_views import put_difference

    loaded = _load(profile)
    archive = archive_of(loaded)
    one, other = _find(archive, first, ""), _find(archive, second, "")
    if one.kind != other.kind:
        raise ConsoleError(
            f"{first} is a {one.kind} and {second} a {other.kind}, which have nothing to compare; "
            "give two of one kind"
        )
    playground = loaded if isinstance(loaded, Profile) else None
    put_difference(one, other, difference(one, other, playground), as_json=as_json)


@app.command
def undo(
    kind: Annotated[str, Parameter(help="Which kind.")],
    subject: Annotated[str, Parameter(help="Of what.")],
    /,
    *,
    profile: ProfileName = "mash",
    as_json: AsJson = False,
) -> None:
    """Take a calibration out of force; the one before it counts again.

    Args:
        kind: Which kind.
        subject: Of what.
        profile: Profile of the cell.
        as_json: Write JSON for programs.
    """
    from calibration.archive import Slot

    archive = archive_of(_load(profile))
    slot = Slot(kind, subject)
    if slot not in archive.slots():
        raise ConsoleError(f"no calibration of {slot} is in force; {_in_force_words(archive)}")
    undone = archive.history(slot)[-1]
    now_in_force = archive.undo(slot)
    if as_json:
        put_json({"undone": undone, "in_force": now_in_force})
    elif now_in_force is None:
        put(f"undone {undone[:8]}; no {kind} of {subject} is in force, the profile's own counts")
    else:
        put(f"undone {undone[:8]}; in force is {now_in_force[:8]}")


def _left_out_words(misfit: Misfit) -> str:
    record = misfit.record
    return f"{record.kind} of {record.subject} is left out ({misfit.problem})"


def _base_word(archive: Archive, identity: str, left_out: Container[str]) -> str:
    """Return what has become of a calibration that another one was based on."""
    from calibration.errors import ArchiveError

    if identity not in archive.all():
        return " (missing)"
    try:
        history = archive.history(_slot(archive.read(identity)))
    except ArchiveError:
        return " (damaged)"
    if identity not in history:
        return " (undone)"
    if identity != history[-1]:
        return " (replaced)"
    return " (left out)" if identity in left_out else ""


def _load(profile: str) -> CellProfile:
    from cell.profile import load_cell_profile

    return load_cell_profile(profile)


def _slot(record: CalibrationRecord) -> Slot:
    from calibration.archive import Slot

    return Slot(record.kind, record.subject)


def _find(archive: Archive, name: str, subject: str) -> CalibrationRecord:
    """Return the calibration that is meant by an id or by a kind.

    Raises:
        ConsoleError: There is none, or there are several.
    """
    from calibration.archive import SHORTEST_PREFIX
    from calibration.errors import ArchiveError

    slots = [s for s in archive.slots() if s.kind == name and subject in ("", s.subject)]
    if len(slots) > 1:
        subjects = ", ".join(slot.subject for slot in slots)
        raise ConsoleError(f"there is a {name} of {subjects}; say which")
    if slots:
        record = archive.in_force(slots[0])
        if record is not None:
            return record
    if subject or not all(c in "0123456789abcdefABCDEF" for c in name):
        what = f"{name} of {subject}" if subject else name
        raise ConsoleError(f"no calibration {what} is in force; {_in_force_words(archive)}")
    if len(name) < SHORTEST_PREFIX:
        raise ConsoleError(f"{name} is too short for an id; give at least {SHORTEST_PREFIX} digits")
    if not any(one.startswith(name.lower()) for one in archive.all()):
        raise ConsoleError(f"no calibration begins with {name}; {_in_force_words(archive)}")
    try:
        return archive.find(name)
    except ArchiveError as error:
        if len([one for one in archive.all() if one.startswith(name.lower())]) == 1:
            raise
        raise ConsoleError(str(error)) from error


def _in_force_words(archive: Archive) -> str:
    slots = archive.slots()
    if not slots:
        return "there are none; `cell calibrate` lists what can be calibrated"
    return "in force are " + ", ".join(str(slot) for slot in slots)


def _nothing_to_check(cell: str, kind: str, in_force: list[CalibrationRecord]) -> str:
    if in_force:
        kinds = ", ".join(sorted({record.kind for record in in_force}))
        return f"in force are {kinds}, which have no check; calibrate again instead"
    if kind:
        return f"no {kind} of the cell {cell} is in force; `cell calibration list` tells what is"
    return _NONE.format(cell)


def _in_list(record: CalibrationRecord, archive: Archive, *, age_s: float) -> dict[str, object]:
    return {
        "identity": record.identity,
        "kind": record.kind,
        "subject": record.subject,
        "grade": record.grade.value,
        "accuracy": record.accuracy.stated,
        "unit": record.accuracy.unit,
        "measured_at": record.measured_at.isoformat(),
        "age_s": age_s,
        "based_on": list(record.based_on),
        "before": list(archive.history(_slot(record))[:-1]),
    }
