"""`cell sessions`: look at recorded sessions, take their pictures, prove that they repeat."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from console.calibrating import stated_accuracy
from console.exits import ConsoleError, Exit
from console.options import AsJson
from console.output import put, put_json, put_table, say, styled
from console.places import pictures_folder, recordings_folder

if TYPE_CHECKING:
    from sessions.recording import RecordedStep, SessionRecording
    from sessions.verify_report import VerifyReport

app = App(name="sessions")

SessionName = Annotated[
    str,
    Parameter(
        help="A session's name or a unique beginning of it, `latest`, or a path ending in .mcap."
    ),
]


@app.command(name="list")
def list_sessions(*, as_json: AsJson = False) -> None:
    """List the recorded sessions, oldest first."""
    from sessions.recording import list_recordings

    folder = recordings_folder()
    summaries = list_recordings(folder)
    if as_json:
        put_json([asdict(summary) for summary in summaries])
        return
    if not summaries:
        say(f"there are no recordings in {folder}; `cell demo` makes one")
        return
    rows = [
        (
            summary.session_id,
            summary.state,
            summary.script_name,
            summary.dialect,
            str(summary.lines),
            str(summary.views),
            f"{summary.duration_s:.1f}",
            f"{summary.size_bytes / 1e6:.1f}",
            summary.note,
        )
        for summary in summaries
    ]
    put_table(("session", "state", "script", "dialect", "lines", "views", "s", "MB", "note"), rows)


@app.command
def show(
    session: SessionName = "latest",
    /,
    *,
    events: Annotated[bool, Parameter(negative="", help="Show the cell's events, too.")] = False,
    wire: Annotated[
        str | None, Parameter(help="Show the traffic of a device, such as arm, too.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show what was said in a session."""
    recording = _open(session)
    if as_json:
        put_json(_as_json(recording, with_events=events, wire=wire))
        return
    start = recording.start
    put(
        styled(f"session {start.session_id}", "bold")
        + f"  {start.script_name}, dialect {start.dialect}, seed {start.seed}, from {start.peer},"
        f" {recording.started_utc:%Y-%m-%d %H:%M:%S} UTC"
    )
    for line in _calibrations(recording):
        put(styled(line, "dim"))
    _say_state(recording)
    told = {} if not events and wire is None else _beside(recording, with_events=events, wire=wire)
    for step in recording.steps():
        _put_step(step, told.get(step.number, []))


@app.command
def views(
    session: SessionName = "latest",
    /,
    *,
    out: Annotated[Path | None, Parameter(help="Folder for the pictures.")] = None,
    as_json: AsJson = False,
) -> None:
    """Write the pictures of a session as PNG files."""
    recording = _open(session)
    folder = pictures_folder(recording.start.session_id) if out is None else out
    paths = write_pictures(recording, folder)
    if as_json:
        put_json([str(path) for path in paths])
    elif paths:
        put("\n".join(str(path) for path in paths))
    else:
        say("the session has no pictures")


@app.command
def verify(
    session: SessionName = "latest",
    /,
    *,
    script: Annotated[
        Path | None, Parameter(help="Replay with this script instead of the recorded one.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Replay a session on a fresh twin and compare every reply, byte for byte."""
    from sessions.verify import verify as replay

    recording = _open(session)
    text = None if script is None else _read(script)
    report = replay(recording, script_text=text, progress=_progress)
    if as_json:
        put_json(report.as_json())
    else:
        put_report(report)
    return Exit.DONE if report.is_identical else Exit.FAILED


def put_report(report: VerifyReport) -> None:
    """Write the result of a replay for people."""
    lines = report.describe().splitlines()
    verdict = styled(lines[0], "green" if report.is_identical else "red")
    put("\n".join([verdict, *lines[1:]]))


def write_pictures(recording: SessionRecording, folder: Path) -> list[Path]:
    """Write every kept picture of a recording as a PNG file and return the paths."""
    from sessions.recording.pictures import as_png

    paths: list[Path] = []
    for view in recording.views():
        if not view.picture:
            continue
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{view.view:04d}-step{view.step:04d}-{view.camera}.png"
        path.write_bytes(as_png(view.picture))
        paths.append(path)
    return paths


def _open(session: str) -> SessionRecording:
    from sessions.recording import RecordingNotFound, SessionRecording, find_recording

    try:
        return SessionRecording.open(find_recording(recordings_folder(), session))
    except RecordingNotFound as error:
        raise ConsoleError(str(error), Exit.USAGE) from error


def _read(path: Path) -> str:
    try:
        return path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ConsoleError(f"{path} cannot be read: {error}") from error


def _progress(step: int, steps: int) -> None:
    if step % 100 == 0 or step == steps:
        say(f"{step} of {steps} lines replayed", "dim")


def _calibrations(recording: SessionRecording) -> list[str]:
    """Return a line for each calibration that was in force."""
    return [
        f"calibration {record.kind} of {record.subject}: {record.grade}, "
        f"{stated_accuracy(record)}, measured {record.measured_at:%Y-%m-%d}, "
        f"{record.identity[:8]}"
        for record in recording.start.calibrations
    ]


def _say_state(recording: SessionRecording) -> None:
    if not recording.is_finished:
        cut = f", {recording.missing_bytes} bytes of a broken record at its end"
        say("the recording was not finished" + (cut if recording.missing_bytes else ""), "yellow")
    elif recording.end_reason:
        say(f"ended: {recording.end_reason}", "dim")


def _put_step(step: RecordedStep, beside: list[str]) -> None:
    moment = f"{step.number:5d} {step.time_ns / 1e9:10.3f} s"
    put(f"{styled(moment, 'dim')}  > {_printable(step.line)}")
    for told in beside:
        put(styled(f"{'':18}    {told}", "dim"))
    if step.reply is None:
        put(f"{'':18}  < (the recording ends here)")
        return
    for line in step.reply.splitlines():
        put(f"{'':18}  < {_printable(line)}")
    if step.view is not None:
        put(styled(f"{'':18}  < ... {step.data_size} bytes, view {step.view.view} ...", "dim"))


def _beside(
    recording: SessionRecording, *, with_events: bool, wire: str | None
) -> dict[int, list[str]]:
    """Return what else there is to tell of each step."""
    told: dict[int, list[str]] = {}
    if with_events:
        for event in recording.events():
            fields = ", ".join(f"{name}={value}" for name, value in event.fields.items())
            told.setdefault(event.step, []).append(f"{event.type} {fields}")
    for sent in recording.wire(wire) if wire is not None else ():
        arrow = "->" if sent.direction == "to_device" else "<-"
        told.setdefault(sent.step, []).append(f"{arrow} {sent.device} {sent.data!r}")
    return told


def _as_json(
    recording: SessionRecording, *, with_events: bool, wire: str | None
) -> dict[str, object]:
    result: dict[str, object] = {
        "session_id": recording.start.session_id,
        "script_name": recording.start.script_name,
        "dialect": recording.start.dialect,
        "seed": recording.start.seed,
        "peer": recording.start.peer,
        "versions": recording.start.versions,
        "calibrations": [
            {
                "identity": record.identity,
                "kind": record.kind,
                "subject": record.subject,
                "grade": record.grade.value,
                "accuracy": record.accuracy.stated,
                "unit": record.accuracy.unit,
                "measured_at": record.measured_at.isoformat(),
            }
            for record in recording.start.calibrations
        ],
        "started_utc": recording.started_utc.isoformat(),
        "is_finished": recording.is_finished,
        "end_reason": recording.end_reason,
        "steps": [
            {
                "number": step.number,
                "time_ns": step.time_ns,
                "line": _printable(step.line),
                "reply": None if step.reply is None else _printable(step.reply),
                "view": None if step.view is None else step.view.view,
                "data_bytes": step.data_size,
            }
            for step in recording.steps()
        ],
    }
    if with_events:
        result["events"] = [
            {"step": e.step, "time_s": e.time_s, "type": e.type, **e.fields}
            for e in recording.events()
        ]
    if wire is not None:
        result["wire"] = [
            {
                "step": sent.step,
                "time_ns": sent.time_ns,
                "direction": sent.direction,
                "hex": sent.data.hex(),
            }
            for sent in recording.wire(wire)
        ]
    return result


def _printable(data: bytes) -> str:
    """Return bytes as text; what is not UTF-8 or would steer the terminal is escaped."""
    text = data.decode("utf-8", "backslashreplace")
    return "".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in text)
