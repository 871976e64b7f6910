"""Runs a procedure to a record: plays it, notes what it used, adds where it comes from."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from importlib.metadata import version
from typing import Final

from pydantic import JsonValue, ValidationError

from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.hands import CellHands, FileHands
from calibration.journal import RunJournal
from calibration.player import Asker, play
from calibration.procedure import Procedure
from calibration.record import CalibrationRecord, Measurement, make_record
from calibration.requests import (
    Answer,
    Ask,
    Capture,
    Point,
    PutBlock,
    ReadFeatures,
    Request,
    SetFeature,
    Tell,
)
from calibration.standing import Standing
from cell.stop import StopToken

_PACKAGES: Final = ("robocell", "numpy", "opencv-python-headless")


@dataclass(slots=True)
class Trace:
    """What a run used: questions answered, cameras looked through, blocks fetched.

    Attributes:
        answers: The answers by key.
        cameras: Names of the cameras.
        uses_store: Whether a block came from the store.
    """

    answers: dict[str, JsonValue] = field(default_factory=dict)
    cameras: set[str] = field(default_factory=set)
    uses_store: bool = False

    def follow(self, request: Request, answer: Answer) -> None:
        """Note a request and its answer."""
        match request:
            case Ask() | Point():
                self.answers[request.key] = _as_json(answer)
            case Capture() | SetFeature() | ReadFeatures():
                self.cameras.add(request.camera)
            case PutBlock():
                self.uses_store = True
            case _:
                pass

    def based_on(self, measured: Measurement, site: Site) -> tuple[str, ...]:
        """Return the identities of the calibrations in force that a measurement stands on.

        Those that it names itself, and those that set how the things it used are known: its
        cameras, and the store where a block came from there. The one that it replaces is none
        of them.
        """
        prefixes = [f"cameras.{camera}." for camera in sorted(self.cameras)]
        if self.uses_store:
            prefixes.append("store")
        named = (*measured.based_on, *(support.record for support in measured.stands_on))
        found = list(dict.fromkeys(identity for identity in named if identity))
        for record in site.current:
            is_own = (record.kind, record.subject) == (measured.kind, measured.subject)
            is_used = any(path.startswith(p) for path in record.values for p in prefixes)
            if is_used and not is_own and record.identity not in found:
                found.append(record.identity)
        return tuple(found)


def run(
    procedure: Procedure,
    site: Site,
    *,
    hands: CellHands | FileHands,
    asker: Asker,
    stop: StopToken,
    journal: RunJournal | None,
    now: Callable[[], datetime],
    on_tell: Callable[[Tell], None],
) -> CalibrationRecord:
    """Play a procedure and return its record, which is kept nowhere yet.

    Args:
        procedure: A fresh generator.
        site: What it knew of the cell.
        hands: Do what it asks of the cell.
        asker: Answers its questions.
        stop: Looked at before every request.
        journal: Notes every answer; None where nothing is to be gone on with.
        now: Tells the wall time, with its zone.
        on_tell: Told what the procedure says.

    Raises:
        Stopped: Somebody stopped it.
        CalibrationError: An answer is missing, or the procedure cannot come to an end.
        CellError: A device fails.
    """
    trace = Trace()

    def restore(standing: Standing) -> None:
        if isinstance(hands, CellHands):
            hands.restore(standing)

    measured = play(
        procedure,
        hands=hands,
        asker=asker,
        stop=stop,
        journal=journal,
        on_tell=on_tell,
        on_answer=trace.follow,
        restore=restore,
    )
    cameras = site.profile.cameras
    try:
        record = make_record(
            measured.model_copy(update={"based_on": trace.based_on(measured, site)}),
            cell=site.profile.name,
            measured_at=now(),
            versions=versions(),
            answers=trace.answers,
            cameras={name: cameras[name].guid for name in sorted(trace.cameras & set(cameras))},
        )
        record.canonical()
    except (ValidationError, ValueError) as error:
        raise CalibrationError(f"the procedure's result cannot be kept: {error}") from error
    return record


def versions() -> dict[str, str]:
    """Return the version of everything that a fit may depend on."""
    found = {name: version(name) for name in _PACKAGES}
    return {**found, "python": platform.python_version(), "machine": platform.machine()}


def origin(name: str, site: Site) -> dict[str, str]:
    """Return what a run depends on beside its answers, for its journal.

    Args:
        name: Name of the procedure.
        site: What it knows of the cell.
    """
    plan = "" if site.plan is None else repr(site.plan)
    return {
        "the procedure": name,
        "the profile": _digest(site.profile.model_dump_json()),
        "the store": _digest(plan),
        "the calibrations in force": _digest(*(record.identity for record in site.current)),
        "the program": " ".join(f"{k} {v}" for k, v in versions().items()),
    }


def _digest(*texts: str) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()


def _as_json(answer: Answer) -> JsonValue:
    if isinstance(answer, tuple):
        return [one for one in answer if isinstance(one, int | float)]
    return answer if isinstance(answer, bool | int | float | str) else None
