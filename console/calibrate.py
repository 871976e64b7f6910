"""`cell calibrate`: play a procedure that measures something of the cell, and keep the result."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from console.calibrating import archive_of, now, with_calibrations
from console.exits import ConsoleError, Exit
from console.options import AsJson, ProfileName, Wires, WiresOption
from console.output import say, styled
from console.places import calibration_runs_folder

if TYPE_CHECKING:
    from calibration.answers import Given, GivenAnswers
    from calibration.applying import Calibrated
    from calibration.archive import Archive
    from calibration.catalogue import Site
    from calibration.hands import CellHands, FileHands
    from calibration.journal import RunJournal
    from calibration.procedure import Procedure
    from calibration.record import CalibrationRecord
    from calibration.requests import Tell
    from cell.profile import CellProfile
    from cell.stop import StopToken


def calibrate(
    procedure: str = "",
    /,
    *,
    answers: Annotated[
        Path | None, Parameter(help="A TOML or JSON file that answers the questions by key.")
    ] = None,
    set_: Annotated[
        list[str] | None,
        Parameter(name="--set", negative="", help="An answer, KEY=VALUE; may be given again."),
    ] = None,
    profile: ProfileName = "mash",
    script: str = "mash",
    wires: WiresOption = "memory",
    resume: Annotated[
        bool, Parameter(negative="", help="Go on with the run that was interrupted.")
    ] = False,
    anew: Annotated[
        bool, Parameter(negative="", help="Throw the run that was interrupted away.")
    ] = False,
    out: Annotated[
        Path | None, Parameter(help="Also write the record and its pictures into this folder.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Measure something of the cell and keep it; without a name, list what can be measured.

    What is not answered by --set or a file is asked at the terminal; without one, defaults
    are taken, and what has none is an error. Ctrl-C stops safely, and --resume goes on there;
    after an interrupted run, a terminal asks whether to, and without one --resume or --anew
    says so.
    Exit code 1 if the result is BAD: it is kept to be looked at, and not put in force.

    Args:
        procedure: What to calibrate.
        answers: File of answers.
        set_: Single answers, which go before the file's.
        profile: Profile of the cell.
        script: The script whose store it is; path, or the name of a shipped one.
        wires: How devices are reached.
        resume: Whether to go on with the run that was interrupted.
        anew: Whether to throw that run away and begin again.
        out: Folder for a copy.
        as_json: Write JSON for programs.
    """
    from calibration.answers import GivenAnswers, parse_settings, read_answers
    from calibration.catalogue import entry_of, start
    from calibration.errors import CalibrationError, FitFailed

    if not procedure:
        return _list_procedures(as_json=as_json)
    if resume and anew:
        raise ConsoleError("--resume goes on with the interrupted run, --anew drops it; give one")
    try:
        entry_of(procedure)
        given: dict[str, Given] = {} if answers is None else read_answers(answers)
        given |= parse_settings(set_ or [])
    except CalibrationError as error:
        raise ConsoleError(str(error)) from error
    asked = GivenAnswers(given)
    session = open_session(profile, script, wires)
    journal = session.journal(procedure)
    if not sys.stdin.isatty():
        _refuse_gaps(start(procedure, session.site), asked)
    if out is not None:
        _make_folder(out)
    with session.run_alone(procedure):
        resume = _take_up(journal, procedure, resume=resume, anew=anew)
        try:
            fresh = start(procedure, session.site)
            record = session.play(fresh, asked, journal=journal, resume=resume)
        except FitFailed:
            # The same answers would only come to the same end.
            journal.remove()
            raise
        for sentence in asked.unused():
            say(f"warning: {sentence}", "yellow")
        pictures = _pictures(record, journal)
        code = _keep(record, pictures, session.archive, as_json=as_json)
        journal.remove()
        if code == Exit.DONE:
            # Tells what does not hold any more beside it.
            with_calibrations(session.file_profile)
        if out is not None:
            _write_copy(record, pictures, out)
        return code


def _list_procedures(*, as_json: bool) -> int:
    from calibration.catalogue import CATALOGUE
    from console.output import put_json, put_table

    if as_json:
        put_json([{"name": e.name, "kind": e.kind, "summary": e.summary} for e in CATALOGUE])
    else:
        put_table(("procedure", "makes", ""), [(e.name, e.kind, e.summary) for e in CATALOGUE])
    return Exit.DONE


def _refuse_gaps(procedure: Procedure, asked: GivenAnswers) -> None:
    from calibration.answers import missing_answers

    problems = missing_answers(procedure, asked)
    if problems:
        listed = "\n".join(f"  {problem}" for problem in problems)
        raise ConsoleError(
            f"the answers do not do, and there is no terminal to ask at:\n{listed}\n"
            "give them with --set KEY=VALUE or --answers FILE"
        )


def _take_up(journal: RunJournal, procedure: str, *, resume: bool, anew: bool) -> bool:
    """Begin a run or go on with the interrupted one; return whether it goes on.

    Raises:
        ConsoleError: There is an interrupted run, and nobody said what is to become of it.
    """
    if journal.interrupted_at is not None and not (resume or anew):
        when = f"{journal.interrupted_at.astimezone():%Y-%m-%d %H:%M}"
        what = f"a run of {procedure} was interrupted at {when}, {journal.noted} answers are kept"
        if not sys.stdin.isatty():
            raise ConsoleError(f"{what}; --resume goes on with it, --anew throws it away")
        from console.asking import ask_yes

        resume = ask_yes(f"{what}. Go on with it? `no` throws it away.")
    if resume:
        _go_on(journal)
    else:
        journal.begin()
    return resume


def _go_on(journal: RunJournal) -> None:
    from calibration.errors import JournalError

    try:
        journal.go_on()
    except JournalError as error:
        raise ConsoleError(f"{error} (`--anew`)" if journal.noted else str(error)) from error
    say(f"going on after {journal.known} answers of the interrupted run")


def _pictures(record: CalibrationRecord, journal: RunJournal) -> dict[str, bytes]:
    return {
        sample.picture: journal.png(sample.picture)
        for sample in record.samples
        if sample.picture and journal.has_png(sample.picture)
    }


def _keep(
    record: CalibrationRecord, pictures: dict[str, bytes], archive: Archive, *, as_json: bool
) -> int:
    """Keep a record, tell what came out, and return the exit code."""
    from calibration.verdict import Grade
    from console.calibration_views import put_record

    identity = archive.keep(record, pictures)
    put_record(record, is_in_force=record.grade is not Grade.BAD, as_json=as_json)
    if record.grade is Grade.BAD:
        say(
            f"BAD: kept to be looked at (`cell calibration show {identity[:8]}`), not put in "
            "force; what was in force stays",
            "red",
        )
        return Exit.FAILED
    say(f"kept and in force; `cell calibration undo {record.kind} {record.subject}` takes it back")
    return Exit.DONE


def _make_folder(folder: Path) -> None:
    """Make a folder for a copy before anything is measured.

    Raises:
        ConsoleError: It cannot be made or written.
    """
    problem = ""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = error.strerror or str(error)
    if not problem and not os.access(folder, os.W_OK | os.X_OK):
        problem = "it may not be written to"
    if problem:
        raise ConsoleError(
            f"--out {folder}: {problem}; nothing was measured, name a folder that can be written",
            Exit.ENVIRONMENT,
        )


def _write_copy(record: CalibrationRecord, pictures: dict[str, bytes], folder: Path) -> None:
    """Write a kept record and its pictures into a folder.

    Raises:
        ConsoleError: It cannot be written.
    """
    name = f"{record.kind}-{record.subject}-{record.identity[:8]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.json").write_bytes(record.canonical() + b"\n")
        for digest, png in pictures.items():
            (folder / f"{digest[:12]}.png").write_bytes(png)
    except OSError as error:
        raise ConsoleError(
            f"the copy cannot be written to {folder}: {error.strerror or error}; the calibration "
            f"{record.identity[:8]} itself is kept (`cell calibration show {record.identity[:8]}`)",
            Exit.ENVIRONMENT,
        ) from error
    say(f"written to {folder}", "dim")


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationSession:
    """A cell that procedures are played on.

    Attributes:
        file_profile: What the cell's file says.
        known: The same with the calibrations in force.
        site: What procedures may know of it.
        script: The script whose store it is.
        wires: How devices are reached.
    """

    file_profile: CellProfile
    known: Calibrated[CellProfile]
    site: Site
    script: str
    wires: Wires

    @property
    def archive(self) -> Archive:
        """Where its calibrations are kept."""
        return archive_of(self.file_profile)

    def journal(self, procedure: str) -> RunJournal:
        """Return the notes of a procedure's runs."""
        from calibration.journal import RunJournal
        from calibration.running import origin

        folder = calibration_runs_folder(self.file_profile.name) / procedure
        return RunJournal(folder, origin(procedure, self.site))

    @contextmanager
    def run_alone(self, procedure: str) -> Iterator[None]:
        """Be the only one who plays a procedure on this cell."""
        from calibration.files import sole_user

        folder = calibration_runs_folder(self.file_profile.name) / ".locks" / procedure
        with sole_user(folder, f"`cell calibrate {procedure}`"):
            yield

    def play(
        self,
        procedure: Procedure,
        asked: GivenAnswers,
        *,
        journal: RunJournal | None,
        resume: bool = False,
    ) -> CalibrationRecord:
        """Play a procedure to its record; the cell is given back afterwards.

        Raises:
            ConsoleError: It was stopped.
            CalibrationError: It cannot come to an end; blocks are home again.
            CellError: A device fails; the ledger knows where the blocks are.
        """
        from calibration.errors import RESULTS, CalibrationError
        from calibration.hands import CellHands, FileHands
        from calibration.running import run
        from cell.errors import Stopped
        from cell.stop import StopToken
        from console.asking import TerminalAsker

        stop = StopToken()
        # Whoever asks the run to stop asks the cell, too.
        reached = [stop]
        hands = self._hands(reached)
        if resume and isinstance(hands, CellHands):
            hands.resume()
        folder = calibration_runs_folder(self.file_profile.name) / "questions"
        asker = asked.before(TerminalAsker(folder)) if sys.stdin.isatty() else asked
        with _stopping(reached):
            try:
                record = run(
                    procedure, self.site, hands=hands, asker=asker, stop=stop, journal=journal,
                    now=now, on_tell=_say_progress,
                )  # fmt: skip
                if isinstance(hands, CellHands):
                    hands.bring_home()
            except Stopped as error:
                again = "; --resume goes on here" if journal is not None else ""
                still = (
                    "; the arm stands still, the ledger knows where the blocks are"
                    if isinstance(hands, CellHands) and hands.cell is not None
                    else ""
                )
                if sys.stderr.isatty():
                    # The terminal shows ^C on the line of a question or of progress.
                    say("")
                raise ConsoleError(
                    f"stopped: {error}{still}{again}",
                    Exit.INTERRUPTED,
                ) from error
            except (CalibrationError, ConsoleError) as error:
                if isinstance(hands, CellHands):
                    hands.bring_home()
                is_untouched = isinstance(hands, FileHands) or hands.cell is None
                if (
                    isinstance(error, CalibrationError)
                    and is_untouched
                    and not isinstance(error, RESULTS)
                ):
                    # Nothing of the cell was used: it is about what was asked for or given.
                    raise ConsoleError(str(error)) from error
                raise
            finally:
                if isinstance(hands, CellHands):
                    hands.close()
        return record

    def _hands(self, reached: list[StopToken]) -> CellHands | FileHands:
        from calibration.hands import CellHands, FileHands
        from cell.profile import Profile
        from cell.robot_cell import RobotCell
        from console.assembling import assemble, clock_for

        profile = self.file_profile
        if not isinstance(profile, Profile):
            return FileHands(profile.name)

        def make() -> RobotCell:
            say("bringing the cell up ...", "dim")
            cell = assemble(profile, self.script, self.wires, clock_for(self.wires))
            reached.append(cell.stop)
            return cell

        return CellHands(make)


def open_session(profile: str, script: str, wires: Wires) -> CalibrationSession:
    """Return a cell that procedures can be played on; nothing is brought up yet.

    Args:
        profile: Name or path of its profile.
        script: The script whose store it is.
        wires: How devices are reached.
    """
    from calibration.catalogue import Site
    from cell.profile import Profile, load_cell_profile
    from console.assembling import plan_of

    loaded = load_cell_profile(profile)
    known = with_calibrations(loaded)
    plan = plan_of(script) if isinstance(loaded, Profile) else None
    site = Site(profile=known.profile, plan=plan, current=known.records)
    return CalibrationSession(
        file_profile=loaded, known=known, site=site, script=script, wires=wires
    )


@contextmanager
def _stopping(reached: list[StopToken]) -> Iterator[None]:
    """Turn the first Ctrl-C or SIGTERM into a safe stop; further ones only wait for it."""
    from cell.errors import Stopped

    def handler(number: int, frame: FrameType | None) -> None:
        if reached[0].is_set:
            return
        reason = "Ctrl-C" if number == signal.SIGINT else "asked to end"
        for token in reached:
            token.stop(reason)
        raise Stopped(reason)

    before = {n: signal.signal(n, handler) for n in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)


def _say_progress(told: Tell) -> None:
    counted = f"{told.done}/{told.total} " if told.total else ""
    say(styled(f"{counted}{told.text}", "dim", sys.stderr))
