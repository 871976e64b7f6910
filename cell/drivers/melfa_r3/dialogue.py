"""One request, one reply: the conversation with the controller over a link.

Knows deadlines, stale bytes and refusals; knows nothing of what a command does.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from cell.clock import Clock
from cell.drivers.melfa_r3 import records, tables
from cell.drivers.melfa_r3.codec import (
    MAX_REPLY_BYTES,
    GarbledMessage,
    LineReader,
    Reply,
    UnsendableRequest,
    decode_reply,
    encode_text,
)
from cell.drivers.melfa_r3.repeating import may_be_repeated
from cell.drivers.melfa_r3.settings import ArmSettings
from cell.errors import CellError, DeviceError, DeviceRestarted, DeviceTimeout, LinkError
from cell.links.base import Link
from cell.links.errors import is_lasting

LOST = (DeviceTimeout, GarbledMessage, LinkError)
"""What a request ends in whose reply did not arrive whole: nobody knows whether it was done."""

OnRepeat = Callable[[str, str], None]
"""Told the device and what was wrong, whenever a request is sent again."""

_T = TypeVar("_T")

_SILENT_HINT = "check that the controller is on, its cable, and the port's settings"
_MAX_STALE_READS = 64


def told(error: CellError) -> str:
    """Return what an error says, without the name of the device."""
    return error.problem if isinstance(error, DeviceError) else str(error)


class Dialogue:
    """Asks the controller and turns refusals into errors that say what to do.

    There is never more than one request under way. Whatever lies in the line
    before a request is thrown away; after a missed reply the line must first
    fall silent, so that a late reply is not taken for the next one. A request that may be
    repeated is sent again, on a quiet line, when its reply is lost or broken.
    """

    def __init__(
        self, link: Link, clock: Clock, settings: ArmSettings, on_repeat: OnRepeat
    ) -> None:
        self.on_repeat = on_repeat
        self._link = link
        self._clock = clock
        self._settings = settings
        self._reader = LineReader(MAX_REPLY_BYTES)
        self._prefix = f"{settings.robot};{settings.slot};"
        self._missed_reply = False

    @property
    def device(self) -> str:
        """Name of the device, for messages."""
        return self._link.name

    def ask(self, command: str, args: str = "", *, slot: int | None = None) -> str:
        """Send a command and return the data of its reply.

        Args:
            command: A command word.
            args: What follows it.
            slot: Task slot that it is for; the settings' one unless given.

        Raises:
            DeviceError: The controller refused, or its reply is no reply.
            DeviceTimeout: It did not answer in time.
        """
        reply = self.request(command, args, slot=slot)
        if not reply.is_accepted:
            raise self.refusal(command + args, reply)
        return reply.data

    def read(self, parse: Callable[[str], _T], command: str, args: str = "") -> _T:
        """Send a question and return its parsed answer; one that makes no sense is asked again.

        Raises:
            DeviceError: The controller refused, or its answers make no sense.
            DeviceTimeout: It did not answer in time.
        """
        try:
            return parse(self.ask(command, args))
        except GarbledMessage as error:
            return self._again(self.garbled(error), lambda: parse(self._asked_once(command, args)))

    def request(self, command: str, args: str = "", *, slot: int | None = None) -> Reply:
        """Send a command and return its reply, refused or not; repeated where that is safe.

        Raises:
            DeviceError: What came back is no reply, or the command cannot be sent.
            DeviceTimeout: Nothing came back in time.
            LinkError: The link is broken.
        """
        try:
            return self.exchange(command, args, slot=slot)
        except LOST as error:
            if is_lasting(error) or not may_be_repeated(command, args):
                raise
            return self._again(error, lambda: self.exchange(command, args, slot=slot))

    def _again(self, error: CellError, work: Callable[[], _T]) -> _T:
        """Do again what has failed once, until it works, was tried often enough, or is in vain."""
        pause_s = self._settings.link_pause_s
        for _ in range(self._settings.attempts - 1):
            self.on_repeat(self.device, told(error))
            if isinstance(error, LinkError):
                self._clock.sleep(pause_s)
                pause_s *= 2.0
            try:
                return work()
            except LOST as again:
                if is_lasting(again):
                    raise
                error = self.garbled(again) if isinstance(again, GarbledMessage) else again
        raise error

    def _asked_once(self, command: str, args: str) -> str:
        reply = self.exchange(command, args)
        if not reply.is_accepted:
            raise self.refusal(command + args, reply)
        return reply.data

    def ask_when_free(self, command: str, args: str = "") -> None:
        """Send a command, again and again while a move under way keeps it from running.

        Raises:
            DeviceError: The controller refused for another reason.
            DeviceTimeout: It was still busy after `busy_timeout_s`, or did not answer.
        """
        deadline_s = self._clock.now_s() + self._settings.busy_timeout_s
        reply = self.request(command, args)
        while reply.error == tables.BUSY:
            if self._clock.now_s() >= deadline_s:
                raise DeviceTimeout(
                    self.device,
                    f"{command}{args} found an earlier move still under way "
                    f"after {self._settings.busy_timeout_s:g} s",
                    code=tables.BUSY,
                    hint="stop the arm",
                )
            self._clock.sleep(self._settings.poll_s)
            reply = self.request(command, args)
        if not reply.is_accepted:
            raise self.refusal(command + args, reply)

    def exchange(
        self, command: str, args: str = "", *, is_urgent: bool = False, slot: int | None = None
    ) -> Reply:
        """Send a command and return its reply, refused or not.

        Args:
            command: A command word.
            args: What follows it.
            is_urgent: Send at once even if a late reply may still be on its way; the
                reply that comes first is then taken for this one.
            slot: Task slot that it is for; the settings' one unless given.

        Raises:
            DeviceError: What came back is no reply, or the command cannot be sent.
            DeviceTimeout: Nothing came back in time.
        """
        try:
            prefix = self._prefix if slot is None else f"{self._settings.robot};{slot};"
            request = encode_text(f"{prefix}{command}{args}")
            if not is_urgent:
                self._drop_stale()
            self._reader.clear()
            self._link.write(request)
            return decode_reply(self._read_line(command))
        except GarbledMessage as error:
            self._missed_reply = True
            raise self.garbled(error) from error
        except UnsendableRequest as error:
            raise UnsendableRequest(error.problem, device=self.device) from error

    def insist(self, command: str) -> Reply:
        """Send a command at once, and again until a reply comes or it was tried often enough.

        Raises:
            DeviceError: What came back is no reply.
            DeviceTimeout: Nothing came back in time.
            LinkError: The link is broken.
        """
        try:
            return self.exchange(command, is_urgent=True)
        except LOST as error:
            if is_lasting(error):
                raise
            return self._again(error, lambda: self.exchange(command, is_urgent=True))

    def garbled(self, error: GarbledMessage) -> GarbledMessage:
        """Return an error of the codec with the name of this device."""
        return GarbledMessage(error.problem, device=self.device)

    def refusal(self, request: str, reply: Reply) -> DeviceError:
        """Return the error that tells of a refused request and of the alarm behind it."""
        text, hint = self.explain(reply.error)
        problem = f"the controller refused {request}: {text}"
        if reply.error == tables.NOT_OPEN:
            return DeviceRestarted(self.device, problem, code=reply.error, hint=hint)
        if not reply.has_alarm:
            return DeviceError(self.device, problem, code=reply.error, hint=hint)
        alarm = self.active_alarm()
        if alarm and alarm != reply.error:
            alarm_text, hint = self.explain(alarm)
            problem = f"{problem}, while alarm {alarm} is active: {alarm_text}"
        return DeviceError(self.device, problem, code=reply.error, hint=hint)

    def active_alarm(self) -> int:
        """Return the number of the active alarm, 0 for none.

        Raises:
            DeviceError: The controller does not tell.
        """
        reply = self.request("ERROR")
        try:
            alarm = records.parse_alarm(reply.data) if reply.is_accepted else None
        except GarbledMessage as error:
            alarm = self._again(self.garbled(error), self._alarm_once)
        return alarm[0] if alarm else 0

    def explain(self, number: int) -> tuple[str, str]:
        """Return text and advice for an error number.

        What the table does not know is asked of the controller.

        Raises:
            DeviceError: The controller was asked and did not answer.
        """
        entry = tables.describe(number)
        if entry is not None:
            return entry.text, entry.hint
        reply = self.request("ERRORMES", str(number))
        text = reply.data.strip() if reply.is_accepted else ""
        return text or "an error unknown to us", "look the number up in the controller's manual"

    def _alarm_once(self) -> tuple[int, str] | None:
        reply = self.exchange("ERROR")
        return records.parse_alarm(reply.data) if reply.is_accepted else None

    def _drop_stale(self) -> None:
        """Empty the line; after a missed reply wait until it is silent."""
        wait_s = self._settings.quiet_s if self._missed_reply else 0.0
        for _ in range(_MAX_STALE_READS):
            if not self._link.read(wait_s):
                self._missed_reply = False
                return
        raise DeviceError(
            self.device, "the line does not fall silent between requests", hint=_SILENT_HINT
        )

    def _read_line(self, command: str) -> bytes:
        """Gather pieces until a line is whole."""
        deadline_s = self._clock.now_s() + self._settings.reply_timeout_s
        wait_s = self._settings.reply_timeout_s
        while wait_s > 0:
            data = self._link.read(wait_s)
            lines = self._reader.feed(data)
            if lines:
                return lines[0]
            wait_s = deadline_s - self._clock.now_s() if data else 0.0
        self._missed_reply = True
        got = self._reader.pending
        what = f"answered only {got[:40]!r}" if got else "gave no answer"
        raise DeviceTimeout(
            self.device,
            f"the controller {what} to {command} within {self._settings.reply_timeout_s:g} s",
            hint=_SILENT_HINT,
        )
