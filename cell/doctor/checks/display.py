"""The television and the page that shows its pictures. Nothing is switched."""

from __future__ import annotations

from cell.doctor.checks.lines import hear_device, judge_line, opened_line
from cell.doctor.checks.listening import Greeting, ask_raw
from cell.doctor.environment import Environment
from cell.doctor.notes import Notes
from cell.doctor.patient import Patient
from cell.drivers.sharp_aquos.codec import (
    END,
    MalformedLine,
    Query,
    Value,
    decode_reply,
    encode_command,
)
from cell.drivers.sharp_aquos.tables import SLEEP_MINUTES, Permission, Word
from cell.links.base import Link
from cell.profile import Profile

_ATTEMPTS = 2
_TIMEOUT_S = 1.0


def check_display(patient: Patient, environment: Environment, notes: Notes) -> None:
    """Examine the television over its line."""
    with opened_line(patient, environment, notes, "display") as link:
        if link is not None and judge_line(
            environment, notes, "display", hear_device(patient, link, "display")
        ):
            _examine(patient, link, notes)


def check_page(profile: Profile, environment: Environment, notes: Notes) -> None:
    """Ask the picture page what it covers; whoever serves it is not disturbed by that."""
    page = environment.page()
    if page is None:
        notes.skip("screen", "picture page", "the pictures are not shown by a page here")
        return
    if not page.is_served:
        port = profile.display.page_port
        why = f"nobody serves it on port {port} now; `cell serve` and `cell tv-page` do"
        notes.skip("screen", "picture page", why)
        return
    if not page.is_connected:
        notes.find("page-not-connected", "screen", "no picture page is open", "0 pages connected")
        return
    display = profile.display
    if (page.width_px, page.height_px) != (display.width_px, display.height_px):
        notes.find(
            "page-wrong-size",
            "screen",
            f"the picture page covers {page.width_px} x {page.height_px} pixels, the panel has "
            f"{display.width_px} x {display.height_px}",
            f"page {page.width_px} x {page.height_px}",
        )
    else:
        notes.fine("screen", f"the picture page covers {page.width_px} x {page.height_px} pixels")
        if page.trouble:
            notes.skip("screen", "picture on the page", f"the page {page.trouble}")


def _examine(patient: Patient, link: Link, notes: Notes) -> None:
    power = ask_number(patient, link, Word.POWER)
    if power is None:
        notes.skip("display", "power and input", "it does not tell whether it is on")
        return
    _check_permission(patient, link, notes)
    if power == 0:
        if patient.is_in_service:
            problem = "the television is in standby in the middle of work"
            notes.find("tv-standby", "display", problem, "POWR reads 0")
        else:
            notes.fine("display", "it is in standby and can be woken")
            notes.skip("display", "input and sleep timer", "it tells them only when it is on")
        return
    _check_input(patient, link, notes)
    timer = ask_number(patient, link, Word.SLEEP_TIMER)
    if timer is not None and 0 < timer < len(SLEEP_MINUTES):
        problem = f"the television will switch itself off: its timer stands at {timer}"
        notes.find("tv-sleep-timer", "display", problem, f"OFTM reads {timer}")


def _check_permission(patient: Patient, link: Link, notes: Notes) -> None:
    permission = ask_number(patient, link, Word.POWER_PERMISSION)
    if permission is None:
        notes.skip("display", "permission to wake it", "this model does not tell")
    elif permission != Permission.SERIAL:
        problem = "the television may not be woken over its line once it sleeps"
        notes.find("tv-no-permission", "display", problem, f"RSPW reads {permission}")


def _check_input(patient: Patient, link: Link, notes: Notes) -> None:
    shown = ask_number(patient, link, Word.INPUT)
    wanted = patient.profile.display.input
    if shown is None and ask_number(patient, link, Word.MUTE) is None:
        notes.skip("display", "input", "it is still starting")
    elif shown != wanted:
        words = "the tuner" if shown is None else f"input {shown}"
        problem = f"the television shows {words} instead of input {wanted}"
        fact = "IAVD is refused" if shown is None else f"IAVD reads {shown}"
        notes.find("tv-wrong-input", "display", problem, fact)
    else:
        notes.fine("display", f"it is on and shows input {wanted}")


def ask_number(patient: Patient, link: Link, word: Word) -> int | None:
    """Ask the set for a number; None if it refuses or tells none.

    Raises:
        LinkError: The line breaks.
    """
    question = Greeting(
        speaker="a television",
        request=encode_command(Query(word)),
        is_answer=lambda data: data.endswith(END),
        timeout_s=_TIMEOUT_S,
    )
    for _ in range(_ATTEMPTS):
        data = ask_raw(link, patient.clock, question)
        try:
            answer = decode_reply(data.removesuffix(END))
        except MalformedLine:
            continue
        if isinstance(answer, Value) and answer.text.lstrip("-").isdecimal():
            return int(answer.text)
        return None
    return None
