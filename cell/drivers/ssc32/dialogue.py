"""Talking to the controller over a link: questions with answers, orders without.

Most orders are not answered, so an order that must not get lost is followed by a question:
commands are carried out one after the other, and an answer says that the order was heard.
Answers are bare bytes without frame or checksum; whatever lies in the line before a question
is thrown away, and a strange or missing answer is asked for again.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TypeVar

from cell.clock import Clock
from cell.drivers.ssc32 import codec, tables
from cell.drivers.ssc32.codec import BadCommand
from cell.drivers.ssc32.commands import Command, QueryMoving
from cell.drivers.ssc32.settings import LineSettings
from cell.errors import DeviceError, DeviceTimeout
from cell.links.base import Link

T = TypeVar("T")

_log = logging.getLogger(__name__)

_SILENT_HINT = "check the controller's logic supply, its cable, the port and the baud rate"
_MAX_STALE_READS = 64
_MAX_TEXT_BYTES = 80


def log_repeat(device: str, problem: str) -> None:
    """Log that a question is asked again."""
    _log.info("%s: %s; asking again", device, problem)


class Dialogue:
    """One talk with one controller; used by one thread at a time.

    Args:
        link: The line to the controller.
        clock: What deadlines are measured with.
        device: Name of the device in messages.
        settings: Patience.
        on_repeat: Told device and problem when a question is asked again.
    """

    def __init__(
        self,
        link: Link,
        clock: Clock,
        device: str,
        settings: LineSettings,
        *,
        on_repeat: Callable[[str, str], None] = log_repeat,
    ) -> None:
        self._on_repeat = on_repeat
        self._link = link
        self._clock = clock
        self._settings = settings
        self._missed_reply = False
        self.device = device

    def cancel_line(self) -> None:
        """Take back half a line that somebody may have left in the controller.

        Firmware that does not know ESC spoils the next line by it, which should therefore be
        a question: that is asked again.
        """
        self._link.write(bytes((tables.ESCAPE,)))

    def tell(self, command: Command) -> None:
        """Send an order that is not answered; nothing says that it was heard.

        Raises:
            DeviceError: The command has a figure out of range.
        """
        self._link.write(self._encoded(command))

    def tell_surely(self, command: Command) -> None:
        """Send an order and a question after it, so that a deaf controller is noticed.

        Raises:
            DeviceError: The command has a figure out of range, or the answer is strange.
            DeviceTimeout: The controller does not answer.
        """
        self.tell(command)
        self.ask(QueryMoving(), codec.decode_moving)

    def ask(self, command: Command, decode: Callable[[bytes], T]) -> T:
        """Send a question and return its answer.

        Args:
            command: The question.
            decode: Makes a value of the answer's bytes, or raises `BadCommand`.

        Raises:
            DeviceError: The answer is strange, again and again.
            DeviceTimeout: There is no answer.
        """
        request = self._encoded(command)
        failure: DeviceError | None = None
        for _ in range(self._settings.attempts):
            if failure is not None:
                self._on_repeat(self.device, failure.problem)
            self._drop_stale()
            self._link.write(request)
            try:
                return decode(self._read(command))
            except BadCommand as error:
                self._missed_reply = True
                failure = BadCommand(error.problem, device=self.device)
            except DeviceTimeout as error:
                self._missed_reply = True
                failure = error
        if failure is None:
            raise ValueError("a question needs one attempt at least")
        raise failure

    def _encoded(self, command: Command) -> bytes:
        try:
            return codec.encode(command)
        except BadCommand as error:
            raise BadCommand(error.problem, device=self.device) from error

    def _drop_stale(self) -> None:
        """Empty the line; after a missed answer wait until it is silent."""
        wait_s = self._settings.quiet_s if self._missed_reply else 0.0
        for _ in range(_MAX_STALE_READS):
            if not self._link.read(wait_s):
                self._missed_reply = False
                return
        raise DeviceError(
            self.device, "the line does not fall silent between questions", hint=_SILENT_HINT
        )

    def _read(self, command: Command) -> bytes:
        """Gather an answer: so many bytes, or a line without its carriage return."""
        wanted = codec.reply_length(command)
        timeout_s = self._settings.reply_timeout_s
        deadline_s = self._clock.now_s() + timeout_s
        wait_s, got = timeout_s, b""
        while wait_s > 0 and len(got) <= _MAX_TEXT_BYTES:
            data = self._link.read(wait_s)
            got += data
            if wanted is None:
                line, end, rest = got.partition(bytes((tables.CARRIAGE_RETURN,)))
                if end and not rest.strip():
                    return line
            elif len(got) == wanted:
                return got
            elif len(got) > wanted:
                raise BadCommand(f"answered {got!r}, more than was asked for")
            # A replayed line answers at once with nothing; its clock may stand still.
            wait_s = deadline_s - self._clock.now_s() if data else 0.0
        request = codec.encode(command).decode("ascii").strip()
        what = f"answered only {got[:40]!r}" if got else "gave no answer"
        raise DeviceTimeout(
            self.device,
            f"the servo controller {what} to {request} within {timeout_s:g} s",
            hint=_SILENT_HINT,
        )
