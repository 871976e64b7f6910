"""`cell bringup`: the cell from dark to ready, step by step."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from console.assembling import assemble, clock_for
from console.doctor import examine_quietly
from console.exits import Exit
from console.options import AsJson, ProfileName, Wires, WiresOption
from console.output import put, put_json, say
from console.places import cell_folder

if TYPE_CHECKING:
    from cell.bringup import BringUp, BringUpReport, Connected, StepResult
    from cell.doctor import Component, Report
    from cell.profile import Profile

_MARKS = {"done": "ok", "confirmed": "ok, as you say", "skipped": "left out", "failed": "not done"}


def bringup(
    *,
    profile: ProfileName = "mash",
    script: str = "mash",
    wires: WiresOption = "memory",
    yes: Annotated[
        bool,
        Parameter(negative="", help="Ask nothing: believe what cannot be measured, go on."),
    ] = False,
    restart: Annotated[
        bool, Parameter(negative="", help="Forget what an interrupted run was told.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Bring the cell up step by step; exit code 1 if something is missing in the end.

    Each step is looked at by itself; only where nothing can be measured is somebody asked.
    Ctrl-C keeps how far it came, and the next run goes on there.

    Args:
        profile: Profile of the cell.
        script: The script whose store and views the cell serves.
        wires: How the devices are reached.
        yes: Whether to ask nothing.
        restart: Whether to begin anew.
        as_json: Write JSON for programs.
    """
    from cell.bringup import BringUp, ProgressFile, bring_up_steps
    from cell.profile import load_profile

    used = load_profile(profile)
    progress = ProgressFile(cell_folder(used.name) / "bringup.json")
    if restart:
        progress.clear()
    steps = bring_up_steps(used, _examiner(used, script, wires), _connector(used, script, wires))
    play = BringUp(steps, progress.load(datetime.now(UTC)))
    is_asked = not yes and not as_json and sys.stdin.isatty()
    while play.current is not None:
        _take_step(play, believes=yes, is_asked=is_asked)
        progress.save(play.report(), datetime.now(UTC))
    report = play.report()
    if report.is_ready:
        progress.clear()
    if as_json:
        put_json(_report_as_json(report, used.name))
    else:
        _put_report(report, used.name, script)
    return Exit.DONE if report.is_ready else Exit.FAILED


def _take_step(play: BringUp, *, believes: bool, is_asked: bool) -> None:
    """Show the current step, look at it, and settle it with whoever sits there."""
    step = play.current
    if step is None:
        return
    number, count = play.position
    guide = f" (guide, step {step.guide})" if step.guide else ""
    say(f"{number}/{count}  {step.title}{guide}", "bold")
    say(f"      {step.instruction}")
    while True:
        result = play.look()
        _tell(result)
        if result.outcome == "done":
            return
        if not is_asked:
            if result.outcome == "open" and believes:
                play.confirm()
            else:
                play.give_up()
            return
        if _settle_by_answer(play, result):
            return


def _settle_by_answer(play: BringUp, result: StepResult) -> bool:
    """Ask what to do about a step that is not done; return whether it is settled."""
    if result.outcome == "open":
        question = "Enter: it is done   r: look again   s REASON: leave out   n: not done > "
    else:
        question = "Enter: look again   s REASON: leave out   n: go on without > "
    print(question, end="", file=sys.stderr, flush=True)
    line = sys.stdin.readline()
    if not line:
        play.give_up()
        return True
    word, _, reason = line.strip().partition(" ")
    if word == "s" and reason.strip():
        play.skip(reason)
        return True
    if word == "s":
        say("say why after the s, as in `s no camera today`")
        return False
    if word == "n":
        play.give_up()
        return True
    if word == "" and result.outcome == "open":
        play.confirm()
        return True
    return False


def _tell(result: StepResult) -> None:
    if result.outcome == "done":
        say(f"      ok: {'; '.join(result.evidence[:3])}", "green")
        return
    say(f"      {result.problem}", "red" if result.outcome == "failed" else "yellow")
    for fact in result.evidence:
        say(f"      evidence: {fact}")
    say(f"      do: {result.fix}")
    if result.link:
        say(f"      more: {result.link}", "dim")


def _put_report(report: BringUpReport, name: str, script: str) -> None:
    for result in report.results:
        mark = _MARKS.get(result.outcome, "not known")
        detail = result.problem or result.reason
        put(f"{result.step:12}{mark}" + (f": {detail}" if detail else ""))
    if report.is_ready:
        put(f"the cell {name} is ready: `cell serve {script}`")
        return
    put(f"the cell {name} is not ready; missing: {', '.join(r.step for r in report.missing)}")
    for result in report.missing:
        if result.fix:
            more = f" ({result.link})" if result.link else ""
            put(f"  {result.step}: {result.fix}{more}")


def _report_as_json(report: BringUpReport, name: str) -> dict[str, object]:
    return {
        "profile": name,
        "is_ready": report.is_ready,
        "steps": [
            {
                "step": one.step,
                "outcome": one.outcome,
                "evidence": list(one.evidence),
                "problem": one.problem,
                "fix": one.fix,
                "link": one.link,
                "reason": one.reason,
            }
            for one in report.results
        ],
    }


def _examiner(profile: Profile, script: str, wires: Wires) -> Callable[[Component], Report]:
    def examine(component: Component) -> Report:
        return examine_quietly(profile, script, wires, component)

    return examine


def _connector(profile: Profile, script: str, wires: Wires) -> Callable[[], Sequence[Connected]]:
    """Return what opens every device of the cell and closes it again."""

    def connect() -> Sequence[Connected]:
        from cell.bringup import connect_devices

        cell = assemble(profile, script, wires, clock_for(wires))
        try:
            return connect_devices(cell, in_parallel=wires == "hardware")
        finally:
            cell.dispose()

    return connect
