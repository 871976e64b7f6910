"""Asks a device the simplest question of its protocol and judges what comes back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from cell.clock import Clock
from cell.drivers.melfa_r3 import codec as melfa
from cell.drivers.schunk_smp.command_codec import encode_command as encode_smp
from cell.drivers.schunk_smp.commands import GetState
from cell.drivers.schunk_smp.framing import FROM_MODULE, DamagedFrame, FrameReader
from cell.drivers.schunk_smp.tables import StateMode
from cell.drivers.sharp_aquos import codec as sharp
from cell.errors import DeviceTimeout, LinkError
from cell.links.base import Link
from cell.profile import Profile

QUESTIONS = 3
"""How often a device is asked before it is judged."""

_MAX_STALE_READS = 64
_QUIET_S = 0.05

Verdict = Literal["answers", "unreliable", "silent", "garbage", "stranger", "broken"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Greeting:
    """The simplest question to a device, which changes nothing there.

    Attributes:
        speaker: Who answers it, in words.
        request: Its bytes.
        is_answer: Whether bytes hold an answer of this protocol.
        timeout_s: How long an answer may take.
    """

    speaker: str
    request: bytes
    is_answer: Callable[[bytes], bool]
    timeout_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """What a line gave back.

    Attributes:
        verdict: The judgement.
        facts: What was measured.
        stranger: Who answers instead, empty unless the verdict is `stranger`.
        error: How the line broke, None unless the verdict is `broken`.
    """

    verdict: Verdict
    facts: tuple[str, ...]
    stranger: str = ""
    error: LinkError | None = None


def greetings(profile: Profile) -> dict[str, Greeting]:
    """Return the question for each serial device of a profile."""
    arm = profile.arm
    return {
        "arm": Greeting(
            speaker="the arm controller",
            request=melfa.encode_text(f"{arm.robot};{arm.slot};STATE"),
            is_answer=_is_melfa,
            timeout_s=0.6,
        ),
        "gripper": Greeting(
            speaker="a gripper module",
            request=encode_smp(profile.gripper.module_id, GetState(0.0, StateMode.ALL)),
            is_answer=_is_smp,
            timeout_s=0.4,
        ),
        "display": Greeting(
            speaker="a television",
            request=sharp.encode_command(sharp.LinkCheck()),
            is_answer=_is_sharp,
            timeout_s=1.0,
        ),
    }


def listen(link: Link, clock: Clock, device: str, known: dict[str, Greeting]) -> Heard:
    """Ask a device three times and say how its line is.

    Where nothing of its own protocol comes back, the questions of the other devices are
    asked on the line, too: cables change places.
    """
    own = known[device]
    answered, heard = 0, b""
    try:
        for _ in range(QUESTIONS):
            data = ask_raw(link, clock, own)
            answered += own.is_answer(data)
            heard = heard or (b"" if own.is_answer(data) else data)
        asked = f"{answered} of {QUESTIONS} questions answered"
        if answered == QUESTIONS:
            return Heard(verdict="answers", facts=(asked,))
        stranger = _stranger(heard, device, known)
        if answered == 0 and not stranger:
            stranger = _answers_others(link, clock, device, known)
    except LinkError as error:
        return Heard(verdict="broken", facts=(str(error),), error=error)
    except DeviceTimeout as error:
        # A link with frames of its own asks for them first, and nothing came back to that.
        return Heard(verdict="silent", facts=(str(error),))
    except melfa.GarbledMessage as error:
        return Heard(verdict="garbage", facts=(str(error),))
    sample = (asked, f"{len(heard)} bytes came that are no answer: {heard[:16].hex(' ')}")
    if answered:
        return Heard(verdict="unreliable", facts=sample if heard else (asked,))
    if stranger:
        return Heard(verdict="stranger", facts=(asked,), stranger=stranger)
    if heard:
        return Heard(verdict="garbage", facts=sample)
    return Heard(verdict="silent", facts=(f"nothing came back to {QUESTIONS} questions",))


def ask_raw(link: Link, clock: Clock, greeting: Greeting) -> bytes:
    """Send a greeting and return what comes back until it is an answer or the time is up.

    Raises:
        LinkError: The line breaks.
    """
    for _ in range(_MAX_STALE_READS):
        if not link.read(0.0):
            break
    link.write(greeting.request)
    deadline_s = clock.now_s() + greeting.timeout_s
    left_s = greeting.timeout_s
    heard = b""
    while left_s > 0:
        wait_s = min(left_s, _QUIET_S if heard else left_s)
        data = link.read(wait_s)
        heard += data
        if greeting.is_answer(heard) or (heard and not data):
            break
        left_s = min(deadline_s - clock.now_s(), left_s - (0.0 if data else wait_s))
    return heard


def _stranger(heard: bytes, device: str, known: dict[str, Greeting]) -> str:
    """Return who else speaks like this, empty for nobody."""
    for name, greeting in known.items():
        if name != device and heard and greeting.is_answer(heard):
            return greeting.speaker
    return ""


def _answers_others(link: Link, clock: Clock, device: str, known: dict[str, Greeting]) -> str:
    """Return who answers a question of another device on this line, empty for nobody."""
    for name, greeting in known.items():
        if name != device and greeting.is_answer(ask_raw(link, clock, greeting)):
            return greeting.speaker
    return ""


def _is_melfa(data: bytes) -> bool:
    lines = data.split(melfa.END)[:-1]
    return any(_decodes_melfa(line) for line in lines)


def _decodes_melfa(line: bytes) -> bool:
    try:
        melfa.decode_reply(line)
    except melfa.GarbledMessage:
        return False
    return True


def _is_smp(data: bytes) -> bool:
    frames = FrameReader(FROM_MODULE).feed(data)
    return any(not isinstance(frame, DamagedFrame) for frame in frames)


def _is_sharp(data: bytes) -> bool:
    # The link check is answered by ERR and by nothing else; a value could be anything.
    return any(line.strip() in (b"ERR", b"OK") for line in data.split(sharp.END)[:-1])
