"""The Sharp television: one command at a time, each answered by one line."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable

from cell.clock import Clock
from cell.drivers.sharp_aquos.codec import (
    CommandRecord,
    Done,
    LineReader,
    LinkCheck,
    MalformedLine,
    Query,
    Refused,
    ReplyRecord,
    Set,
    Value,
    asks_for_text,
    decode_reply,
    encode_command,
)
from cell.drivers.sharp_aquos.settings import SharpSettings
from cell.drivers.sharp_aquos.tables import (
    MAY_STAY_SILENT,
    NOT_REPEATABLE,
    RANGES,
    SLEEP_MINUTES,
    AvMode,
    Mute,
    Permission,
    Word,
)
from cell.errors import DeviceError, DeviceTimeout, LinkError, OutOfRange
from cell.links.base import Link
from cell.links.errors import is_lasting

_LOGGER = logging.getLogger(__name__)
_SLICE_S = 0.1
_LINK_PAUSE_S = 0.25
_MAX_STALE_READS = 64
_UNPROVEN = "this driver was never tried on this model; watch what the set does"


OnRepeat = Callable[[str, str], None]
"""Told the device and what was wrong, whenever a command is sent again."""


def _log_warning(text: str) -> None:
    _LOGGER.warning("%s", text)


def _log_repeat(device: str, problem: str) -> None:
    _LOGGER.warning("%s: asked again: %s", device, problem)


class SharpDisplay:
    """A `Display` that speaks the AQUOS protocol.

    Args:
        link: The line to the set.
        clock: What deadlines are measured with.
        settings: The model's figures.
        on_warning: Told what a technician should know although nothing failed.
        on_repeat: Told the device and what was wrong, whenever a command is sent again.
    """

    def __init__(
        self,
        link: Link,
        clock: Clock,
        settings: SharpSettings,
        *,
        on_warning: Callable[[str], None] = _log_warning,
        on_repeat: OnRepeat = _log_repeat,
    ) -> None:
        self._link = link
        self._clock = clock
        self._settings = settings
        self._reader = LineReader()
        self._heard: deque[ReplyRecord] = deque()
        self._on_warning = on_warning
        self._on_repeat = on_repeat
        self._missed_answer = False
        self._identity = ""

    def open(self) -> str:
        """Check the link and return the identity; opening again is harmless.

        Raises:
            DeviceError: What answers is no AQUOS set.
            DeviceTimeout: Nothing answers.
        """
        if not self._identity:
            if not self._settings.was_tried_on_hardware:
                self._on_warning(f"{self._settings.device}: {_UNPROVEN}")
            self._check_link()
            self._identity = self._read_identity()
        return self._identity

    def close(self) -> None:
        """End the use of the set and leave it as it is; closing twice is harmless.

        The link stays with whoever made it, so the display can be opened again.
        """
        self._identity = ""

    def switch_on(self) -> None:
        """Switch the set on and return when it takes commands.

        Raises:
            DeviceError: The set may not be switched on over the line.
            DeviceTimeout: It does not answer, or does not become ready.
        """
        if not self.is_on():
            try:
                self._do(Set(Word.POWER, 1))
            except DeviceError as error:
                raise DeviceError(
                    self._settings.device,
                    "does not let itself be switched on",
                    hint="switch it on by hand once; the driver then gives the permission",
                ) from error
        self._await_ready()
        self.permit_power_on()

    def switch_off(self) -> None:
        """Put the set into standby, from which it can be switched on again."""
        if self.is_on():
            self.permit_power_on()
            self._do(Set(Word.POWER, 0))

    def is_on(self) -> bool:
        """Return whether the set is on."""
        return self._ask_number(Word.POWER) == 1

    def permit_power_on(self, permission: Permission = Permission.SERIAL) -> None:
        """Say whence the set may be switched on; it forgets this when unplugged."""
        self._do(Set(Word.POWER_PERMISSION, permission))

    def select_input(self, number: int) -> None:
        """Select an input by its number in the table of inputs.

        Raises:
            DeviceError: There is no such input, or the set refuses it.
        """
        self.require_input(number)
        self._do(Set(Word.INPUT, number))

    def require_input(self, number: int) -> None:
        """Return if the table has an input; nothing is sent.

        Raises:
            OutOfRange: It has none of that number.
        """
        if number not in self._settings.inputs:
            known = ", ".join(f"{n} ({name})" for n, name in self._settings.inputs.items())
            raise OutOfRange(
                self._settings.device, f"has no input {number}", hint=f"there are {known}"
            )

    def selected_input(self) -> int:
        """Return the number of the input that is shown.

        Raises:
            DeviceError: The set shows its tuner, which has no number, or does not answer.
        """
        return self._ask_number(Word.INPUT)

    def next_input(self) -> None:
        """Go on to the next input."""
        self._do(Set(Word.NEXT_INPUT))

    def select_tuner(self) -> None:
        """Show the tuner."""
        self._do(Set(Word.TUNER))

    def set_volume(self, volume: int) -> None:
        """Set the volume, 0 to 60."""
        self._do(self._in_range(Word.VOLUME, volume))

    def require_volume(self, volume: int) -> None:
        """Return if there is such a volume; nothing is sent.

        Raises:
            OutOfRange: It is none of 0 to 60.
        """
        self._in_range(Word.VOLUME, volume)

    def volume(self) -> int:
        """Return the volume."""
        return self._ask_number(Word.VOLUME)

    def set_muted(self, *, is_muted: bool) -> None:
        """Switch the sound off or on."""
        self._do(Set(Word.MUTE, Mute.ON if is_muted else Mute.OFF))

    def is_muted(self) -> bool:
        """Return whether the sound is off."""
        return self._ask_number(Word.MUTE) == Mute.ON

    def set_av_mode(self, mode: AvMode) -> None:
        """Choose a picture preset."""
        self._do(Set(Word.AV_MODE, mode))

    def set_view_mode(self, mode: int) -> None:
        """Choose how the picture fills the screen, 0 to 11; the meanings are the model's."""
        self._do(self._in_range(Word.VIEW_MODE, mode))

    def set_sleep_timer(self, minutes: int) -> None:
        """Have the set switch itself off after 30, 60, 90 or 120 minutes; 0 is never.

        Raises:
            DeviceError: The set does not know so many minutes.
        """
        if minutes not in SLEEP_MINUTES:
            raise DeviceError(
                self._settings.device,
                f"cannot sleep in {minutes} minutes",
                hint=f"use one of {', '.join(map(str, SLEEP_MINUTES))}",
            )
        self._do(Set(Word.SLEEP_TIMER, SLEEP_MINUTES.index(minutes)))

    def set_number(self, word: Word, value: int) -> None:
        """Send any command word that takes a number, such as a position or a remote key.

        Raises:
            DeviceError: The number is out of the word's range, or the set refuses.
        """
        command = self._in_range(word, value)
        try:
            self._do(command)
        except DeviceTimeout:
            if word not in MAY_STAY_SILENT:
                raise

    def _check_link(self) -> None:
        answer = self._exchange(LinkCheck())
        if not isinstance(answer, Refused):
            raise DeviceError(
                self._settings.device,
                f"answered {answer} to the link check instead of ERR",
                hint="is another device on this port?",
            )

    def _read_identity(self) -> str:
        told = []
        for word in (Word.NAME, Word.MODEL, Word.SOFTWARE):
            answer = self._exchange(Set(word, 1))
            if isinstance(answer, Value):
                told.append(answer.text)
        return f"Sharp AQUOS {' '.join(told)}" if told else "Sharp AQUOS, model not told"

    def _await_ready(self) -> None:
        """Ask whether the sound is off until the set answers that.

        Of all questions this one has an answer on every input.
        """
        settings = self._settings
        polls = max(1, int(settings.ready_timeout_s / settings.poll_s))
        deadline_s = self._clock.now_s() + settings.ready_timeout_s
        for _ in range(polls):
            if isinstance(self._exchange(Query(Word.MUTE)), Value):
                return
            if self._clock.now_s() >= deadline_s:
                break
            self._clock.sleep(settings.poll_s)
        raise DeviceTimeout(
            settings.device,
            f"does not take commands {settings.ready_timeout_s:g} s after power on",
            hint="look at the screen; switch it off and on by hand",
        )

    def _in_range(self, word: Word, value: int) -> Set:
        allowed = RANGES[word]
        if not allowed.allows(value):
            raise OutOfRange(
                self._settings.device,
                f"{word.name.lower().replace('_', ' ')} cannot be {value}",
                hint=f"allowed is {allowed.least} to {allowed.most}",
            )
        return Set(word, value)

    def _ask_number(self, word: Word) -> int:
        answer = self._exchange(Query(word))
        if isinstance(answer, Value) and answer.text.lstrip("-").isdecimal():
            return int(answer.text)
        raise self._refusal(Query(word), answer)

    def _do(self, command: Set) -> None:
        answer = self._exchange(command)
        if not isinstance(answer, Done):
            raise self._refusal(command, answer)

    def _refusal(self, command: CommandRecord, answer: ReplyRecord) -> DeviceError:
        device = self._settings.device
        sent = encode_command(command).decode("ascii").strip()
        if isinstance(answer, Refused):
            hint = "it is in standby, still starting, or has nothing of the kind"
            return DeviceError(device, f"refused {sent!r}", hint=hint)
        return DeviceError(device, f"answered {answer} to {sent!r}")

    def _exchange(self, command: CommandRecord) -> ReplyRecord:
        """Send one command and return its answer.

        Raises:
            DeviceTimeout: No answer came, however often it was asked.
        """
        settings = self._settings
        is_power = isinstance(command, Set) and command.word in (Word.POWER, Word.POWER_PERMISSION)
        timeout_s = settings.power_timeout_s if is_power else settings.reply_timeout_s
        data = encode_command(command, settings.padding)
        is_repeatable = not (isinstance(command, Set) and _does_more_twice(command))
        tries = settings.attempts if is_repeatable else 1
        for tried in range(1, tries):
            try:
                return self._exchange_once(command, data, timeout_s)
            except DeviceTimeout as error:
                self._on_repeat(settings.device, error.problem)
            except LinkError as error:
                if is_lasting(error):
                    raise
                self._on_repeat(settings.device, str(error))
                self._clock.sleep(_LINK_PAUSE_S * tried)
        return self._exchange_once(command, data, timeout_s)

    def _exchange_once(self, command: CommandRecord, data: bytes, timeout_s: float) -> ReplyRecord:
        self._drop_late_answers()
        self._link.write(data)
        answer = self._await_answer(command, timeout_s)
        if answer is not None:
            return answer
        self._missed_answer = True
        raise DeviceTimeout(
            self._settings.device,
            f"no answer to {data.decode('ascii').strip()!r} within {timeout_s:g} s",
            hint="is the set plugged in, and was it switched on by hand once?",
        )

    def _await_answer(self, command: CommandRecord, timeout_s: float) -> ReplyRecord | None:
        deadline_s = self._clock.now_s() + timeout_s
        remaining_s = timeout_s
        while True:
            while self._heard:
                reply = self._heard.popleft()
                if _fits(reply, command):
                    return reply
                _LOGGER.debug("%s: unexpected %s", self._settings.device, reply)
            if remaining_s <= 0:
                return None
            slice_s = min(remaining_s, _SLICE_S)
            data = self._link.read(slice_s)
            if data:
                self._hear(data)
                remaining_s = deadline_s - self._clock.now_s()
            else:
                # A replayed line answers at once with nothing; its clock may stand still.
                remaining_s = min(remaining_s - slice_s, deadline_s - self._clock.now_s())

    def _drop_late_answers(self) -> None:
        """Empty the line; after a missed answer wait until it is silent.

        Answers do not say what they answer: a late one would be taken for the next one's.
        """
        wait_s = self._settings.quiet_s if self._missed_answer else 0.0
        for _ in range(_MAX_STALE_READS):
            if not self._link.read(wait_s) or not wait_s:
                break
        self._missed_answer = False
        self._reader.clear()
        self._heard.clear()

    def _hear(self, data: bytes) -> None:
        for line in self._reader.feed(data):
            try:
                self._heard.append(decode_reply(line))
            except MalformedLine as error:
                _LOGGER.debug("%s: %s", self._settings.device, error)


def _does_more_twice(command: Set) -> bool:
    is_toggle = command.word in (Word.MUTE, Word.AV_MODE) and command.value == 0
    return is_toggle or command.word in NOT_REPEATABLE


def _fits(reply: ReplyRecord, command: CommandRecord) -> bool:
    """Return whether a reply can be the answer to a command; ERR always can."""
    return isinstance(reply, Refused) or isinstance(reply, Value) == asks_for_text(command)
