"""`cell watchdog`: test the components now, and see what the watchdog saw and told."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter, validators

from console.exits import ConsoleError, Exit
from console.options import AsJson, ProfileName, WiresOption
from console.output import put, put_json, put_table, say
from console.places import cell_folder

if TYPE_CHECKING:
    from cell.watchdog import History, Outbox
    from cell.watchdog.history import TestRecord

app = App(name="watchdog")


@app.command
def run(
    *,
    profile: ProfileName = "mash",
    script: str = "mash",
    only: Annotated[
        list[str] | None,
        Parameter(negative="", help="A component to test, such as arm; may be given again."),
    ] = None,
    wires: WiresOption = "memory",
    as_json: AsJson = False,
) -> int:
    """Test every component now, as the watchdog does between sessions.

    Args:
        profile: Profile of the cell.
        script: The script whose store it is; path, or the name of a shipped one.
        only: Components to test; all unless given.
        wires: How devices are reached.
        as_json: Write JSON for programs.
    """
    from contextlib import nullcontext

    from cell.profile import load_profile
    from cell.watchdog import WireLog
    from console.assembling import assemble_known, clock_for, plan_of
    from console.calibrating import with_calibrations
    from console.drifting import drift_check
    from sessions.hosting import versions
    from sessions.watching import watch

    used = load_profile(profile)
    clock, folder = clock_for(wires), cell_folder(used.name)
    wire = WireLog(clock)
    known = with_calibrations(used)
    cell = assemble_known(known, used, plan_of(script), wires, clock, wire)
    try:
        watching = watch(
            cell,
            lambda: nullcontext(True),
            folder,
            clock,
            wire=wire,
            versions=versions(),
            calibrations=drift_check(known.profile, known.records),
        )
        try:
            components = [test.component for test in watching.watchdog.tests()]
            unknown = sorted(set(only or ()) - set(components))
            if unknown:
                raise ConsoleError(
                    f"--only {unknown[0]}: there is no such component; there are "
                    f"{', '.join(components)}"
                )
            say("testing " + ", ".join(only or components), "dim")
            done = watching.watchdog.run_round(only or ())
            watching.outbox.deliver()
        finally:
            watching.close()
    finally:
        cell.dispose()
    records = () if done is None else done.records
    _tell(records, as_json=as_json)
    return Exit.FAILED if done is None or done.failed else Exit.DONE


@app.command
def history(
    *,
    profile: ProfileName = "mash",
    rounds: Annotated[
        int,
        Parameter(
            validator=validators.Number(gte=1, lte=1_000_000), help="How many rounds to show."
        ),
    ] = 10,
    as_json: AsJson = False,
) -> None:
    """Show the last rounds and every fault.

    Args:
        profile: Profile of the cell.
        rounds: How many rounds to show, 1 to 1000000.
        as_json: Write JSON for programs.
    """
    kept, _ = _kept(profile)
    try:
        tests, faults = kept.tests(rounds), kept.faults()
    finally:
        kept.close()
    if as_json:
        put_json(
            {
                "tests": [_test_as_dict(test) for test in tests],
                "faults": [
                    {
                        "number": f.number, "component": f.component, "summary": f.summary,
                        "first": f.first, "last": f.last, "times": f.times, "ended": f.ended,
                    }
                    for f in faults
                ],
            }
        )  # fmt: skip
        return
    _tell(tuple(tests), as_json=False)
    if faults:
        put("")
        rows = [
            (str(f.number), f.first, str(f.times), f.ended or "lasts", f.summary) for f in faults
        ]
        put_table(("fault", "first", "times", "ended", "what"), rows)


@app.command
def reports(*, profile: ProfileName = "mash", as_json: AsJson = False) -> None:
    """Show every report, and how far it is on its way to each tracker.

    Args:
        profile: Profile of the cell.
        as_json: Write JSON for programs.
    """
    kept, outbox = _kept(profile)
    try:
        waiting = outbox.waiting()
    finally:
        kept.close()
    if as_json:
        put_json(
            [
                {
                    "fault": w.fault, "reporter": w.reporter, "attempts": w.attempts,
                    "reference": w.reference, "problem": w.problem, "is_done": w.is_done,
                }
                for w in waiting
            ]
        )  # fmt: skip
        return
    if not waiting:
        put("there is no report")
        return
    rows = [
        (
            str(w.fault),
            w.reporter,
            f"sent as {w.reference}" if w.is_done else "waits",
            str(w.attempts),
            w.problem,
        )
        for w in waiting
    ]
    put_table(("fault", "to", "state", "attempts", "problem"), rows)


@app.command
def send(*, profile: ProfileName = "mash") -> int:
    """Try at once to send the reports that wait.

    Args:
        profile: Profile of the cell.
    """
    kept, outbox = _kept(profile)
    try:
        outbox.hurry()
        sent = outbox.deliver()
        left = [w for w in outbox.waiting() if not w.is_done]
    finally:
        kept.close()
    put(f"sent {sent}, waiting {len(left)}")
    for one in left:
        say(f"fault {one.fault}: {one.problem or 'not tried yet'}", "yellow")
    return Exit.FAILED if left else Exit.DONE


def _kept(name: str) -> tuple[History, Outbox]:
    from datetime import UTC, datetime
    from time import time

    from cell.profile import load_profile
    from cell.watchdog import Outbox
    from cell.watchdog.reporters import reporters_of
    from sessions.watching import open_history

    profile = load_profile(name)
    kept = open_history(cell_folder(profile.name), datetime.now(UTC))
    return kept, Outbox(kept, reporters_of(profile.reports), time)


def _tell(records: tuple[TestRecord, ...], *, as_json: bool) -> None:
    if as_json:
        put_json([_test_as_dict(record) for record in records])
    elif records:
        rows = [(r.time, r.component, r.outcome, r.detail) for r in records]
        put_table(("time", "component", "outcome", "detail"), rows)
    else:
        put("no test was made yet")


def _test_as_dict(record: TestRecord) -> dict[str, object]:
    return {
        "round": record.round,
        "time": record.time,
        "component": record.component,
        "outcome": record.outcome,
        "detail": record.detail,
    }
