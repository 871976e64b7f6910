"""Asking a module over a link and hearing it out.

A module speaks unasked at any time: a late "position reached", a repeated
error, a cyclic state may stand between a request and its answer. So an answer
is known by its command byte, and everything else is handed to whoever listens.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable

from cell.clock import Clock
from cell.drivers.schunk_smp.command_codec import command_byte, encode_command
from cell.drivers.schunk_smp.commands import (
    CommandRecord,
    MoveCurrent,
    MoveGrip,
    MovePosition,
    MovePositionTimed,
    MoveVelocity,
    Reboot,
    Reference,
    ToggleImpulses,
)
from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.framing import FROM_MODULE, DamagedFrame, FrameReader, Received
from cell.drivers.schunk_smp.replies import (
    IMPULSES,
    Answer,
    Impulse,
    Refused,
    Reply,
)
from cell.drivers.schunk_smp.reply_codec import answered_command, decode_reply
from cell.drivers.schunk_smp.tables import Code, Command, problem_of
from cell.errors import DeviceError, DeviceTimeout, LinkError
from cell.links.base import Link
from cell.links.errors import is_lasting
from cell.stop import StopToken

_LOGGER = logging.getLogger(__name__)
_SLICE_S = 0.1
_FRAME_GAP_S = 0.05
_QUIET_S = 0.2
_MAX_STALE_READS = 64
LINK_PAUSE_S = 0.25
"""Pause before a request is sent again over a link that broke."""

_ONCE = (
    MovePosition,
    MovePositionTimed,
    MoveCurrent,
    MoveVelocity,
    MoveGrip,
    Reference,
    ToggleImpulses,
    Reboot,
)
"""What starts a motion or turns something over: never sent again blindly."""

OnRepeat = Callable[[str, str], None]
"""Told the device and what was wrong, whenever a request is sent again."""

_TRANSMISSION_FAULTS = frozenset({int(Code.CHECKSUM), int(Code.COMMUNICATION)})


class Conversation:
    """One module's side of a line.

    Args:
        link: The line.
        clock: What deadlines are measured with.
        device: Name of the device in messages.
        module: Id of the module.
        attempts: How often a request that may be repeated is sent before its silence counts.
        token: Asked, if given, whether to go on waiting for impulses.
        on_repeat: Told whenever a request is sent again; a line in the log unless given.
    """

    def __init__(
        self,
        link: Link,
        clock: Clock,
        *,
        device: str,
        module: int,
        attempts: int = 3,
        token: StopToken | None = None,
        on_repeat: OnRepeat | None = None,
    ) -> None:
        self._link = link
        self._clock = clock
        self._device = device
        self._module = module
        self._attempts = attempts
        self._on_repeat = on_repeat or _log_repeat
        self._token = token
        self._reader = FrameReader(FROM_MODULE, module=module)
        self._silence_s = 0.0
        self._missed_answer = False
        self._heard: deque[Reply] = deque()
        self._impulses: deque[Impulse] = deque(maxlen=64)

    def ask(
        self, command: CommandRecord, *, timeout_s: float, attempts: int | None = None
    ) -> Answer:
        """Send a command and return its answer; impulses on the way are kept for later.

        Args:
            command: What to ask.
            timeout_s: How long one answer may take.
            attempts: How often to ask; by default once what starts a motion or turns
                something over, and as often as the conversation was told what does not. A
                request that the module calls damaged was not carried out and may always
                be repeated.

        Raises:
            DeviceError: The module refuses; the text and the advice are the table's.
            DeviceTimeout: No answer came.
        """
        data = encode_command(self._module, command)
        code = command_byte(command)
        tries = attempts or self._attempts
        is_once = attempts is None and isinstance(command, _ONCE)
        for tried in range(1, tries):
            try:
                return self._ask_once(data, code, timeout_s)
            except (DeviceError, LinkError) as error:
                if not _may_repeat(error, is_once=is_once):
                    raise
                self.tell_repeated(error)
                if isinstance(error, LinkError):
                    self._clock.sleep(LINK_PAUSE_S * tried)
        return self._ask_once(data, code, timeout_s)

    def tell_repeated(self, error: DeviceError | LinkError) -> None:
        """Tell that something is asked again, for a caller who repeats it in a way of its own."""
        self._on_repeat(self._device, told(error))

    def _ask_once(self, data: bytes, code: int, timeout_s: float) -> Answer:
        self._drain()
        self._link.write(data)
        answer = self._await_answer(code, timeout_s)
        self._missed_answer = answer is None
        if answer is None or isinstance(answer, Refused):
            raise self._trouble(code, answer, timeout_s)
        return answer

    def _trouble(self, code: int, refusal: Refused | None, timeout_s: float) -> DeviceError:
        """Return the error of a refusal, or of no answer."""
        if refusal is None:
            return DeviceTimeout(
                self._device,
                f"no answer to {_name(code)} within {timeout_s:g} s",
                hint="is the gripper's power output on?",
            )
        problem = problem_of(refusal.code)
        return DeviceError(
            self._device,
            f"refused {_name(code)}: {problem.text}",
            code=refusal.code,
            hint=problem.advice,
        )

    def next_impulse(self, timeout_s: float) -> Impulse | None:
        """Return the next thing said unasked, or None when `timeout_s` passed without.

        Raises:
            Stopped: A stop was asked for.
        """
        if not self._impulses:
            self._listen(timeout_s, self._keep_impulse, self._token)
        return self._impulses.popleft() if self._impulses else None

    def forget_impulses(self) -> None:
        """Drop what was said unasked so far; it belongs to an earlier motion."""
        self._drain()
        self._impulses.clear()

    def _drain(self) -> None:
        """Take what lies on the line: keep impulses, drop answers that came too late.

        After a missed answer the line must first fall silent: a late one would be taken for
        that of the next request.
        """
        wait_s = _QUIET_S if self._missed_answer else 0.0
        for _ in range(_MAX_STALE_READS):
            data = self._link.read(wait_s)
            if data:
                self._hear(data)
            if not data or not wait_s:
                break
        self._missed_answer = False
        while self._heard:
            self._keep_impulse(self._heard.popleft())

    def _await_answer(self, code: int, timeout_s: float) -> Answer | None:
        answers: list[Answer] = []

        def take(reply: Reply) -> bool:
            if isinstance(reply, IMPULSES):
                self._impulses.append(reply)
            elif answered_command(reply) == code:
                answers.append(reply)
            else:
                _LOGGER.debug("%s: unexpected %s", self._device, reply)
            return bool(answers)

        self._listen(timeout_s, take)
        return answers[0] if answers else None

    def _keep_impulse(self, reply: Reply) -> bool:
        if not isinstance(reply, IMPULSES):
            return False
        self._impulses.append(reply)
        return True

    def _listen(
        self, timeout_s: float, take: Callable[[Reply], bool], token: StopToken | None = None
    ) -> None:
        """Hand replies to `take` until it returns True or the time is up."""
        deadline_s = self._clock.now_s() + timeout_s
        remaining_s = timeout_s
        while True:
            while self._heard:
                if take(self._heard.popleft()):
                    return
            if remaining_s <= 0:
                return
            if token is not None:
                token.check()
            slice_s = min(remaining_s, _SLICE_S)
            data = self._link.read(slice_s)
            if data:
                self._hear(data)
                remaining_s = deadline_s - self._clock.now_s()
            else:
                self._hear_silence(slice_s)
                # A replayed line answers at once with nothing; its clock may stand still.
                remaining_s = min(remaining_s - slice_s, deadline_s - self._clock.now_s())

    def _hear(self, data: bytes) -> None:
        self._silence_s = 0.0
        self._decode(self._reader.feed(data))

    def _hear_silence(self, duration_s: float) -> None:
        """Give up a frame whose rest does not come: a stray byte looked like its start."""
        self._silence_s += duration_s
        if self._reader.is_waiting and self._silence_s >= _FRAME_GAP_S:
            self._decode(self._reader.skip_false_start())

    def _decode(self, received: list[Received]) -> None:
        for frame in received:
            if isinstance(frame, DamagedFrame):
                _LOGGER.debug("%s: damaged frame %s", self._device, frame)
                continue
            try:
                self._heard.append(decode_reply(frame))
            except MalformedMessage as error:
                _LOGGER.debug("%s: %s", self._device, error)


def told(error: DeviceError | LinkError) -> str:
    """Return what an error says, without the name of the device."""
    return error.problem if isinstance(error, DeviceError) else str(error)


def _may_repeat(error: DeviceError | LinkError, *, is_once: bool) -> bool:
    if isinstance(error, DeviceTimeout | LinkError):
        return not (is_once or is_lasting(error))
    return error.code in _TRANSMISSION_FAULTS


def _log_repeat(device: str, problem: str) -> None:
    _LOGGER.warning("%s: asked again: %s", device, problem)


def _name(code: int) -> str:
    return Command(code).name.replace("_", " ")
