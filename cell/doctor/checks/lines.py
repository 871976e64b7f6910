"""The line of each serial device: port, cable, speed, and who is at its other end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from cell.doctor.checks.listening import Heard, greetings, listen
from cell.doctor.environment import Environment
from cell.doctor.notes import Notes
from cell.doctor.patient import Patient
from cell.errors import LinkError
from cell.links.base import Link
from cell.links.errors import NotReached, PortForbidden, PortMissing, PortTaken
from cell.links.settings_text import settings_text
from cell.profile import Profile, SerialProfile

_SILENT = {"arm": "arm-silent", "gripper": "gripper-silent", "display": "tv-silent"}
_WORDS = {"arm": "the arm controller", "gripper": "the gripper", "display": "the television"}


@contextmanager
def opened_line(
    patient: Patient, environment: Environment, notes: Notes, device: str
) -> Iterator[Link | None]:
    """Open a device's line for a while; None, and a finding, if that fails."""
    try:
        link = patient.lines[device]()
    except LinkError as error:
        judge_link_error(environment, notes, device, error)
        yield None
        return
    try:
        yield link
    finally:
        link.close()


def judge_link_error(environment: Environment, notes: Notes, device: str, error: LinkError) -> None:
    """Write down why a line cannot be opened or used."""
    words = _WORDS[device]
    match error:
        case PortMissing():
            problem = f"the port {error.port} of {words} does not exist"
            notes.find("port-missing", device, problem, str(error))
        case PortForbidden():
            problem = f"the port {error.port} of {words} may not be opened by this user"
            notes.find("port-forbidden", device, problem, str(error))
        case PortTaken():
            problem = f"another program has the port {error.port} of {words}"
            holder = environment.holder_of(error.port)
            held = (f"held by {holder}",) if holder else ()
            notes.find("port-taken", device, problem, str(error), *held)
        case NotReached():
            problem = f"nobody takes a connection at {error.address}, where {words} should be"
            notes.find("tcp-refused", device, problem, str(error))
        case _:
            notes.find("cable-out", device, f"the line to {words} is broken", str(error))


def hear_device(patient: Patient, link: Link, device: str) -> Heard:
    """Ask a device the simplest question of its protocol and judge what comes back."""
    heard = listen(link, patient.clock, device, greetings(patient.profile))
    line = _line_of(patient.profile, device)
    if heard.verdict not in ("silent", "garbage") or not isinstance(line, SerialProfile):
        return heard
    settings = f"the port {line.port} is set to {settings_text(line)}; is the device, too?"
    return replace(heard, facts=(*heard.facts, settings))


def _line_of(profile: Profile, device: str) -> object:
    """Return the parameters of a device's line, None where the profile has none."""
    lines = {
        "arm": profile.arm.serial,
        "gripper": profile.gripper.serial,
        "display": profile.display.serial,
    }
    return lines.get(device)


def judge_line(environment: Environment, notes: Notes, device: str, heard: Heard) -> bool:
    """Write down how the line is; return whether the device can be asked further."""
    words = _WORDS[device]
    match heard.verdict:
        case "answers":
            notes.fine(device, f"its line: {heard.facts[0]}")
            return True
        case "unreliable":
            problem = f"the line to {words} loses or spoils answers"
            notes.find("line-unreliable", device, problem, *heard.facts)
            return True
        case "broken" if heard.error is not None:
            judge_link_error(environment, notes, device, heard.error)
        case "stranger":
            problem = f"{heard.stranger} answers where {words} should"
            notes.find("wrong-device-answers", device, problem, *heard.facts)
        case "garbage":
            problem = f"what {words} sends is no message: its line has other settings or is damaged"
            notes.find("line-garbage", device, problem, *heard.facts)
        case _:
            notes.find(_SILENT[device], device, f"{words} does not answer", *heard.facts)
    return False
