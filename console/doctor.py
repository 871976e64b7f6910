"""`cell doctor`: why the cell does not work, with evidence, and what to do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from console.assembling import assemble, clock_for, plan_of
from console.calibrating import with_calibrations
from console.exits import Exit
from console.options import AsJson, ProfileName, Wires, WiresOption
from console.output import put, put_json, say, styled
from console.places import cell_folder, recordings_folder

if TYPE_CHECKING:
    from cell.doctor import Environment, Finding, PageState, Patient, Report
    from cell.doctor.learned import LearnedPicture
    from cell.profile import Profile

ComponentName = Literal[
    "computer", "profile", "arm", "gripper", "display", "screen", "cameras", "calibration", "store"
]


def doctor(
    *,
    profile: ProfileName = "mash",
    script: str = "mash",
    wires: WiresOption = "memory",
    component: ComponentName | None = None,
    learn: Annotated[
        bool,
        Parameter(
            negative="", help="Bring the healthy cell up and keep its pictures for later; it moves."
        ),
    ] = False,
    verbose: Annotated[
        bool, Parameter(negative="", help="Also say what was checked and is fine.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Examine the cell; exit code 1 if anything is wrong, 3 if the doctor itself cannot work.

    Nothing moves, and what is switched on in order to look is switched back.

    Args:
        profile: Profile of the cell.
        script: The script whose store and views the cell serves.
        wires: How the devices are reached.
        component: Look only at this, and at what it depends on.
        learn: Whether to keep what healthy pictures look like, instead of examining.
        verbose: Whether to tell also what is fine.
        as_json: Write JSON for programs.
    """
    from cell.doctor import report_of_invalid_profile
    from cell.errors import ProfileError
    from cell.profile import load_profile, profile_text

    # A profile that is not there is a wrong use; one that says nonsense is a finding.
    profile_text(profile)
    try:
        used = load_profile(profile)
    except ProfileError as error:
        return show(report_of_invalid_profile(error), profile, verbose=verbose, as_json=as_json)
    # Tells which calibrations do not fit the profile any more.
    with_calibrations(used)
    if learn:
        return _learn(used, script, wires, as_json=as_json)
    report = examine_cell(used, script, wires, component=component)
    return show(report, used.name, verbose=verbose, as_json=as_json)


def examine_cell(
    profile: Profile, script: str, wires: Wires, *, component: ComponentName | None = None
) -> Report:
    """Examine the cell of a profile; progress goes to stderr."""
    return _examine(
        profile, script, wires, component, lambda what: say(f"looking at: {what}", "dim")
    )


def examine_quietly(
    profile: Profile, script: str, wires: Wires, component: ComponentName
) -> Report:
    """Examine one component of the cell of a profile, and what it depends on."""
    return _examine(profile, script, wires, component, lambda what: None)


def _examine(
    profile: Profile,
    script: str,
    wires: Wires,
    component: ComponentName | None,
    progress: Callable[[str], None],
) -> Report:
    from cell.doctor import examine

    folder = cell_folder(profile.name)
    known = with_calibrations(profile, is_quiet=True).profile
    return examine(
        known,
        environment_of(known, script, wires),
        meeting(known, script, wires, truth=profile),
        only=component,
        learned=_learned(folder),
        progress=progress,
    )


def meeting(
    profile: Profile, script: str, wires: Wires, *, truth: Profile
) -> Callable[[], AbstractContextManager[Patient]]:
    """Return how the doctor meets the cell of a profile.

    Args:
        profile: What is known of the cell: its file, with the calibrations in force.
        script: The script whose store and views it serves.
        wires: How the devices are reached.
        truth: What its file says, which a twin is made by.
    """
    from cell.clock import SimulatedClock, SystemClock
    from cell.doctor.meeting import meet_hardware, meet_twin
    from console.scripts import load_script
    from sessions.binding import camera_of
    from sessions.hosting import store_plan

    loaded = load_script(script)
    places = loaded.program.environments.values()
    views = tuple(sorted({camera_of(view.name) for place in places for view in place.views}))
    lattice = (
        max((place.world.width for place in places), default=1),
        max((place.world.height for place in places), default=1),
    )
    folder = cell_folder(profile.name)
    plan = store_plan(loaded)
    if wires == "hardware":
        from cell.assembly.cameras import hardware_cameras

        clock = SystemClock()
        return partial(
            meet_hardware,
            profile,
            plan,
            clock=clock,
            cameras=hardware_cameras(profile, clock),
            state_folder=folder,
            lattice=lattice,
            views=views,
        )
    return partial(
        meet_twin,
        profile,
        plan,
        clock=SimulatedClock(),
        state_folder=folder,
        wires=wires,
        lattice=lattice,
        views=views,
        truth=truth,
    )


def environment_of(profile: Profile, script: str, wires: Wires) -> Environment:
    """Return this computer as the doctor sees it."""
    from cell.doctor import SystemEnvironment

    folder = cell_folder(profile.name)
    return SystemEnvironment(
        state_folder=folder,
        recordings_folder=recordings_folder(),
        page_state=partial(_page_state, profile) if wires == "hardware" else None,
        world_check=None if wires == "hardware" else partial(_why_no_world, profile, script),
    )


def _page_state(profile: Profile) -> PageState:
    """Ask the program that serves the television's page; of several pages, one that is wrong."""
    from cell.doctor import PageState
    from cell.drivers.kiosk import ask_screen

    told = ask_screen(profile.display.page_port)
    if told is None:
        return PageState(is_connected=False, is_served=False)
    if not told.pages:
        return PageState(is_connected=False)
    page = next((page for page in told.pages if page.covers_px != told.size), told.pages[0])
    width_px, height_px = page.covers_px or (0, 0)
    return PageState(
        is_connected=True, width_px=width_px, height_px=height_px, trouble=page.trouble
    )


def show(report: Report, name: str, *, verbose: bool, as_json: bool) -> int:
    """Write a report; return the exit code that belongs to it."""
    if as_json:
        put_json(report_as_json(report, name))
    else:
        _put_report(report, name, verbose=verbose)
    return Exit.DONE if report.is_healthy else Exit.FAILED


def report_as_json(report: Report, name: str) -> dict[str, object]:
    """Return a report as data."""
    return {
        "profile": name,
        "is_healthy": report.is_healthy,
        "findings": [_finding_as_json(finding) for finding in report.findings],
        "fine": [{"component": one.component, "what": one.what} for one in report.fine],
        "not_checked": [
            {"component": one.component, "what": one.what, "why": one.why}
            for one in report.unchecked
        ],
    }


def _finding_as_json(finding: Finding) -> dict[str, object]:
    return {
        "cause": finding.cause.id,
        "title": finding.cause.title,
        "component": finding.component,
        "problem": finding.problem,
        "evidence": list(finding.facts),
        "fix": finding.fix,
        "undo": finding.undo,
        "link": finding.cause.link,
    }


def _put_report(report: Report, name: str, *, verbose: bool) -> None:
    for number, finding in enumerate(report.findings, 1):
        if number == 2:
            put("Also found, perhaps only a consequence:\n")
        put(styled(f"{finding.cause.title} ({finding.component})", "bold"))
        put(f"  {finding.problem}")
        for fact in finding.facts:
            put(f"  evidence  {fact}")
        put(f"  do        {finding.fix}")
        if finding.undo:
            put(f"  undo      {finding.undo}")
        put(f"  more      {finding.cause.link}\n")
    if verbose:
        for fine in report.fine:
            put(f"fine         {fine.component}: {fine.what}")
    for one in report.unchecked:
        put(f"not checked  {one.component}: {one.what}: {one.why}")
    if report.is_healthy:
        count = len(report.fine)
        put(f"{name}: nothing is wrong; {count} things were checked and are fine")


def _learned(folder: Path) -> Mapping[str, LearnedPicture]:
    from cell.doctor.learned import load_learned
    from cell.errors import CellError

    try:
        return load_learned(folder)
    except CellError as error:
        say(f"focus and place of the cameras are not compared: {error}", "yellow")
        return {}


def _learn(profile: Profile, script: str, wires: Wires, *, as_json: bool) -> int:
    """Bring a healthy cell up, keep its pictures, and switch it off again."""
    from cell.doctor.learned import keep_learned, learn

    say("bringing the cell up; the arm will stand aside", "dim")
    cell = assemble(profile, script, wires, clock_for(wires))
    try:
        cell.open()
        learned = learn(cell)
        cell.close()
    finally:
        cell.dispose()
    keep_learned(cell_folder(profile.name), learned)
    if as_json:
        put_json({"learned": sorted(learned)})
    else:
        put(f"kept healthy pictures of {', '.join(sorted(learned))}")
    return Exit.DONE


def _why_no_world(profile: Profile, script: str) -> str:
    """Return why the twin's kept world cannot be used; empty if it can or there is none."""
    from cell.assembly.emulated import blocks_in_store
    from cell.clock import SimulatedClock
    from cell.errors import CellError
    from cell.kinematics import SixAxisArm
    from cell.twin.keeping import WorldFile
    from cell.twin.world import World

    file = WorldFile(cell_folder(profile.name) / "world.json")
    if not file.exists():
        return ""
    plan = plan_of(script)
    try:
        arm = SixAxisArm.from_profile(profile.arm)
        world = World(profile, arm, SimulatedClock(), blocks_in_store(profile, plan))
        file.load_into(world)
    except CellError as error:
        return str(error)
    return ""
