"""The bridge between a serial line and the slave's registers, as an `Emulator`.

A wait within a request is decided at once: nobody but the bridge writes to the registers,
so the slave's program is run ahead to the moment at which the wait ends, and the reply is
due then.
"""

from __future__ import annotations

from cell.drivers.ibm7545.framing import (
    OVERHEAD,
    REQUEST,
    Acknowledge,
    Await,
    Flags,
    FrameReader,
    MalformedFrame,
    Read,
    Reply,
    Status,
    Write,
    decode_steps,
    encode_reply,
)
from cell.twin.emulators.ibm7545.settings import SlaveSettings
from cell.twin.emulators.ibm7545.slave import Slave
from cell.twin.emulators.uart import Transmitter


class RegisterBridge:
    """The far end of the line: takes requests, answers each once.

    Args:
        slave: The slave whose registers it reaches.
        settings: Times of the line and of the bridge.
    """

    def __init__(self, slave: Slave, settings: SlaveSettings) -> None:
        self.slave = slave
        self._settings = settings
        self._reader = FrameReader(REQUEST)
        self._line = Transmitter(settings.byte_s)
        self._was_power_off = False
        self._is_silent = False

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at `now_s`."""
        if self._is_silent:
            return
        settings = self._settings
        for number, body in self._reader.feed(data):
            arrived_s = now_s + (len(body) + OVERHEAD) * settings.byte_s + settings.processing_s
            self.slave.advance(arrived_s)
            status, words = self._perform(body)
            flags = Flags(0)
            if not self.slave.mechanics.is_powered:
                flags |= Flags.POWER_OFF
            if self._was_power_off:
                flags |= Flags.POWER_WAS_OFF
            reply = encode_reply(Reply(number, status, flags, tuple(words)))
            self._line.send(reply, self.slave.now_s)

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`."""
        return self._line.take(now_s)

    def next_output_s(self) -> float | None:
        """Return when the next reply will be out, or None."""
        return self._line.next_s()

    def press_emergency_stop(self, now_s: float) -> None:
        """Cut the motors' power."""
        self.slave.cut_motor_power(now_s, is_on=False)
        self._was_power_off = True

    def release_emergency_stop(self, now_s: float) -> None:
        """Give the motors their power back."""
        self.slave.cut_motor_power(now_s, is_on=True)

    def fall_silent(self, *, is_silent: bool) -> None:
        """Answer nothing any more, or again."""
        self._is_silent = is_silent
        self._line.clear()

    def _perform(self, body: bytes) -> tuple[Status, list[int]]:
        words: list[int] = []
        try:
            steps = decode_steps(body)
        except MalformedFrame:
            return Status.NOT_UNDERSTOOD, words
        slave = self.slave
        for step in steps:
            if isinstance(step, Read):
                if not slave.has(step.offset, step.count):
                    return Status.NO_SUCH_REGISTER, words
                words += slave.read(step.offset, step.count)
            elif isinstance(step, Write):
                if not slave.has(step.offset, len(step.words)):
                    return Status.NO_SUCH_REGISTER, words
                slave.write(step.offset, step.words)
            elif isinstance(step, Acknowledge):
                self._was_power_off = not slave.mechanics.is_powered
            elif not (slave.has(step.offset, 1) and slave.has(step.unless, 1)):
                return Status.NO_SUCH_REGISTER, words
            elif not self._wait(step):
                # What follows a wait that failed is not done.
                return Status.WAIT_FAILED, words
        return Status.DONE, words

    def _wait(self, step: Await) -> bool:
        slave = self.slave
        deadline_s = slave.now_s + step.timeout_ms / 1000.0
        while slave.read(step.offset, 1)[0] & step.mask != step.value:
            if slave.read(step.unless, 1)[0]:
                return True
            next_s = slave.next_event_s()
            if next_s is None or next_s > deadline_s:
                slave.advance(deadline_s)
                return False
            slave.advance(next_s)
        return True
