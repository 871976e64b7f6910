"""The registers as the master reaches them, over a bridge on any link.

A card in the computer's own bus would be another `RegisterBus`; nothing above this
module knows which one it has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from cell.clock import Clock
from cell.drivers.ibm7545.framing import (
    REPLY,
    Flags,
    FrameReader,
    MalformedFrame,
    Reply,
    Status,
    Step,
    decode_reply,
    encode_request,
)
from cell.drivers.ibm7545.framing import Read as ReadStep
from cell.drivers.ibm7545.framing import Write as WriteStep
from cell.errors import DeviceError, DeviceTimeout, LinkError
from cell.links.base import Link

_UNANSWERED_HINT = "check that the bridge and the robot are switched on and the cable is in place"


@dataclass(frozen=True, slots=True)
class Answer:
    """What steps on the registers gave.

    Attributes:
        words: All words read, in the steps' order.
        is_power_off: Whether the motors have no power.
        was_power_off: Whether they had none since that was last acknowledged.
        is_wait_over: Whether every wait among the steps ended as it should.
    """

    words: tuple[int, ...]
    is_power_off: bool
    was_power_off: bool
    is_wait_over: bool


class RegisterBus(Protocol):
    """Reads and writes of 16-bit registers at byte offsets from the base.

    Every method raises `DeviceTimeout` when nothing answers and `DeviceError` when the
    answer makes no sense.
    """

    @property
    def device(self) -> str:
        """Name of the device behind the bus."""

    def read(self, offset: int, count: int = 1) -> tuple[int, ...]:
        """Return words from an offset on."""

    def write(self, offset: int, words: Sequence[int]) -> None:
        """Write words from an offset on."""

    def perform(self, steps: Sequence[Step], *, timeout_s: float) -> Answer:
        """Take steps one after the other; waits among them take at most `timeout_s`."""


class BridgedBus:
    """The registers behind a bridge that is reached over a link.

    Args:
        link: The link to the bridge.
        clock: Time of the deadlines.
        reply_timeout_s: Longest wait for a reply, beside the waits that were asked for.
    """

    def __init__(self, link: Link, clock: Clock, *, reply_timeout_s: float = 1.0) -> None:
        self._link = link
        self._clock = clock
        self._timeout_s = reply_timeout_s
        self._reader = FrameReader(REPLY)
        self._number = 0

    @property
    def device(self) -> str:
        """Name of the device behind the link."""
        return self._link.name

    def read(self, offset: int, count: int = 1) -> tuple[int, ...]:
        """Return words from an offset on.

        Raises:
            DeviceTimeout: The bridge does not answer.
            DeviceError: It does not understand.
        """
        return self.perform((ReadStep(offset, count),), timeout_s=0.0).words

    def write(self, offset: int, words: Sequence[int]) -> None:
        """Write words from an offset on.

        Raises:
            DeviceTimeout: The bridge does not answer.
            DeviceError: It does not understand.
        """
        self.perform((WriteStep(offset, tuple(words)),), timeout_s=0.0)

    def perform(self, steps: Sequence[Step], *, timeout_s: float) -> Answer:
        """Take steps one after the other and return what was read.

        Raises:
            DeviceTimeout: The bridge does not answer.
            DeviceError: It does not understand.
        """
        self._number = self._number + 1 & 0xFF
        self._reader.clear()
        try:
            self._link.write(encode_request(self._number, steps))
            reply = self._await_reply(self._timeout_s + timeout_s)
        except LinkError as error:
            raise DeviceTimeout(
                self.device, f"the bridge cannot be reached: {error}", hint=_UNANSWERED_HINT
            ) from error
        if reply.status in (Status.NOT_UNDERSTOOD, Status.NO_SUCH_REGISTER):
            raise DeviceError(
                self.device,
                "the bridge did not understand a request"
                if reply.status == Status.NOT_UNDERSTOOD
                else "the bridge has no such register",
                code=reply.status,
                hint="check that the bridge's program fits this driver",
            )
        return Answer(
            reply.words,
            bool(reply.flags & Flags.POWER_OFF),
            bool(reply.flags & Flags.POWER_WAS_OFF),
            reply.status == Status.DONE,
        )

    def _await_reply(self, timeout_s: float) -> Reply:
        """Return the reply to the last request; replies to earlier ones are dropped."""
        clock = self._clock
        deadline_s = clock.now_s() + timeout_s
        left_s = timeout_s
        discarded = self._reader.discarded
        # An empty read has waited as long as it was told to, whatever the clock says.
        while left_s > 0.0 and (data := self._link.read(left_s)):
            for number, body in self._reader.feed(data):
                if number == self._number:
                    return self._decoded(number, body)
            left_s = deadline_s - clock.now_s()
        raise DeviceTimeout(
            self.device,
            f"the bridge did not answer within {timeout_s:g} s"
            + (" and sent garbage" if self._reader.discarded > discarded else ""),
            hint=_UNANSWERED_HINT,
        )

    def _decoded(self, number: int, body: bytes) -> Reply:
        try:
            return decode_reply(number, body)
        except MalformedFrame as error:
            raise DeviceError(
                self.device,
                f"the bridge answered nonsense: {error}",
                hint="check that the bridge's program fits this driver",
            ) from error
