"""The emulated television: standby, starting, on; commands and their answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

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
    decode_command,
    encode_reply,
)
from cell.drivers.sharp_aquos.tables import (
    RANGES,
    SLEEP_MINUTES,
    STANDBY_WORDS,
    TELLS_TEXT,
    AvMode,
    Key,
    Mute,
    Permission,
    Word,
)
from cell.twin.bodies import DisplayBody
from cell.twin.emulators.sharp_aquos.settings import SharpTelevisionSettings
from cell.twin.emulators.uart import Transmitter

_Power = Literal["standby", "starting", "on"]
_Due = Literal["lit", "ready", "sleep"]
_TUNER = 0
_FACTORY: dict[Word, int] = {
    Word.AV_MODE: AvMode.STANDARD,
    Word.VOLUME: 20,
    Word.MUTE: Mute.OFF,
    Word.VIEW_MODE: 1,
    Word.SLEEP_TIMER: 0,
    Word.SURROUND: 0,
    Word.HORIZONTAL_POSITION: 90,
    Word.VERTICAL_POSITION: 90,
    Word.CLOCK: 90,
    Word.PHASE: 20,
    Word.ANALOGUE_CHANNEL: 1,
}
_WRAPS: dict[Word, tuple[int, ...]] = {
    Word.AV_MODE: tuple(m for m in AvMode if m not in (AvMode.TOGGLE, AvMode.AUTOMATIC)),
    Word.MUTE: (Mute.ON, Mute.OFF),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptTelevision:
    """A set that stays plugged in.

    Attributes:
        is_on: Whether it is on; what is still starting is on by then.
        input: The input it shows, 0 for the tuner.
        permission: Whence it may be switched on.
        values: What was set, by command word.
    """

    is_on: bool
    input: int
    permission: Permission
    values: dict[Word, int]


class SharpTelevision:
    """An AQUOS set as a `cell.links.base.Emulator` on the twin's panel.

    Args:
        body: The panel.
        settings: Figures of the set.
        is_on: Whether it was switched on long before.
    """

    def __init__(
        self, body: DisplayBody, settings: SharpTelevisionSettings, *, is_on: bool = False
    ) -> None:
        self._body = body
        self._settings = settings
        self._reader = LineReader()
        self._transmitter = Transmitter(settings.byte_s)
        self._power: _Power = "on" if is_on else "standby"
        self._permission = settings.permission
        self._input = settings.first_input
        self._values = dict(_FACTORY)
        self._due: dict[_Due, float] = {}
        self._is_silent = False
        self._corrupted = 0
        self._unpowered_until_s = 0.0

    @property
    def is_on(self) -> bool:
        """Whether the set is on, ready or not."""
        return self._power != "standby"

    # From one process to the next

    def kept(self, now_s: float) -> KeptTelevision:
        """Return what the set goes on with; its sleep timer is forgotten."""
        self._catch_up(now_s)
        return KeptTelevision(
            is_on=self.is_on,
            input=self._input,
            permission=self._permission,
            values={**self._values, Word.SLEEP_TIMER: 0},
        )

    def restore(self, kept: KeptTelevision) -> None:
        """Go on from what was kept, at time 0; what it does not know stays as it is."""
        self._power = "on" if kept.is_on else "standby"
        self._input, self._permission = kept.input, kept.permission
        self._values |= {w: v for w, v in kept.values.items() if w in self._values}
        self._body.set_lit(is_lit=kept.is_on, input_number=kept.input, now_s=0.0)

    # The wire

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at `now_s`; without mains they are lost."""
        self._catch_up(now_s)
        if now_s < self._unpowered_until_s:
            return
        heard_s = now_s + len(data) * self._settings.byte_s
        for line in self._reader.feed(data):
            self._handle(line, now_s, heard_s)

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`."""
        self._catch_up(now_s)
        data = self._transmitter.take(now_s)
        return b"" if self._is_silent else data

    def next_output_s(self) -> float | None:
        """Return when the next answer will be out, or None; the set never speaks unasked."""
        return self._transmitter.next_s()

    # Faults to order

    def corrupt_next_reply(self, count: int = 1) -> None:
        """Turn over a bit in each of the next `count` answers."""
        self._corrupted += count

    def go_silent(self) -> None:
        """Cut the wire from the set; what it says is lost."""
        self._is_silent = True

    def speak_again(self) -> None:
        """Mend the wire from the set."""
        self._is_silent = False

    def unplug(self, now_s: float) -> None:
        """Take the mains away and give it back: standby, switching on not permitted."""
        self._catch_up(now_s)
        self._switch_off(now_s)
        self._permission = Permission.NONE
        self._transmitter.clear()
        self._reader.clear()

    def lose_power(self, now_s: float, *, for_s: float) -> None:
        """Take the mains away for a time, or say anew for how long; what is heard is lost."""
        if now_s >= self._unpowered_until_s:
            self.unplug(now_s)
        self._unpowered_until_s = now_s + for_s

    def press_power(self, now_s: float) -> None:
        """Press the power key on the set."""
        self._catch_up(now_s)
        if self.is_on:
            self._switch_off(now_s)
        else:
            self._switch_on(now_s)

    def press_input(self, now_s: float, number: int) -> None:
        """Choose an input with the remote control; 0 is the tuner."""
        self._catch_up(now_s)
        if self.is_on:
            self._show(number, now_s)

    # Time

    def _catch_up(self, now_s: float) -> None:
        while self._due:
            what = min(self._due, key=self._due.__getitem__)
            due_s = self._due[what]
            if due_s > now_s:
                return
            del self._due[what]
            match what:
                case "lit":
                    self._body.set_lit(is_lit=True, input_number=self._input, now_s=due_s)
                case "ready":
                    self._power = "on"
                case "sleep":
                    self._switch_off(due_s)

    def _switch_on(self, now_s: float) -> None:
        if not self.is_on:
            self._power = "starting"
            self._due["lit"] = now_s + self._settings.lit_after_s
            self._due["ready"] = now_s + self._settings.ready_after_s

    def _switch_off(self, now_s: float) -> None:
        if self.is_on:
            self._power = "standby"
            self._due.clear()
            self._values[Word.SLEEP_TIMER] = 0
            self._body.set_lit(is_lit=False, input_number=self._input, now_s=now_s)

    # Talking

    def _handle(self, line: bytes, now_s: float, heard_s: float) -> None:
        if not self.is_on and self._permission != Permission.SERIAL:
            # The serial port has no power in such a standby.
            return
        settings = self._settings
        delay_s = settings.answer_s
        answer: ReplyRecord | None
        try:
            command = decode_command(line)
        except MalformedLine:
            answer = Refused()
        else:
            if isinstance(command, Set) and command.word is Word.POWER:
                delay_s = settings.power_answer_s
            answer = self._answer(command, now_s)
        if answer is not None:
            self._say(encode_reply(answer), heard_s + delay_s)

    def _say(self, data: bytes, at_s: float) -> None:
        if self._corrupted:
            self._corrupted -= 1
            data = bytes((data[0] ^ 0x80,)) + data[1:]
        self._transmitter.send(data, at_s)

    def _answer(self, command: CommandRecord, now_s: float) -> ReplyRecord | None:
        if isinstance(command, LinkCheck):
            return Refused()
        if self._power != "on" and command.word not in STANDBY_WORDS:
            return Refused()
        if isinstance(command, Query):
            return self._tell(command.word)
        if not RANGES[command.word].allows(command.value):
            return Refused()
        return self._obey(command.word, command.value, now_s)

    def _tell(self, word: Word) -> ReplyRecord:
        if not RANGES[word].can_be_asked:
            return Refused()
        match word:
            case Word.POWER:
                return Value(str(int(self.is_on)))
            case Word.POWER_PERMISSION:
                return Value(str(int(self._permission)))
            case Word.INPUT:
                return Refused() if self._input == _TUNER else Value(str(self._input))
            case _:
                return Value(str(self._values[word]))

    def _obey(self, word: Word, value: int, now_s: float) -> ReplyRecord | None:
        match word:
            case Word.POWER:
                if value:
                    self._switch_on(now_s)
                else:
                    self._switch_off(now_s)
            case Word.POWER_PERMISSION:
                self._permission = Permission(value)
            case Word.INPUT:
                if value not in self._settings.inputs:
                    return Refused()
                self._show(value, now_s)
            case Word.NEXT_INPUT:
                self._show_next(now_s)
            case Word.TUNER:
                self._show(_TUNER, now_s)
            case Word.CHANNEL_UP | Word.CHANNEL_DOWN:
                return self._change_channel(1 if word is Word.CHANNEL_UP else -1)
            case Word.REMOTE_KEY:
                return self._press(value, now_s)
            case Word.SLEEP_TIMER:
                self._set_sleep(value, now_s)
            case Word.ANALOGUE_CHANNEL if self._input != _TUNER:
                return Refused()
            case _:
                return self._keep(word, value)
        return Done()

    def _keep(self, word: Word, value: int) -> ReplyRecord:
        if word in TELLS_TEXT:
            identity = self._settings.identity
            index = (Word.NAME, Word.MODEL, Word.SOFTWARE).index(word)
            return Refused() if identity is None else Value(identity[index])
        if word in _WRAPS and value == 0:
            choices = _WRAPS[word]
            now = self._values[word]
            value = choices[(choices.index(now) + 1) % len(choices)] if now in choices else 1
        if word in self._values:
            self._values[word] = value
        return Done()

    def _show(self, number: int, now_s: float) -> None:
        self._input = number
        self._body.set_lit(is_lit=True, input_number=number, now_s=now_s)

    def _show_next(self, now_s: float) -> None:
        numbers = sorted(self._settings.inputs)
        higher = [n for n in numbers if n > self._input]
        self._show(higher[0] if higher else numbers[0], now_s)

    def _change_channel(self, step: int) -> ReplyRecord | None:
        if self._input != _TUNER:
            return Refused()
        allowed = RANGES[Word.ANALOGUE_CHANNEL]
        channel = self._values[Word.ANALOGUE_CHANNEL] + step
        self._values[Word.ANALOGUE_CHANNEL] = min(max(channel, allowed.least), allowed.most)
        return None if self._settings.is_channel_silent else Done()

    def _press(self, key: int, now_s: float) -> ReplyRecord:
        if key > 9 and key not in tuple(Key):
            return Refused()
        if key == Key.POWER:
            self._switch_off(now_s)
        elif key == Key.INPUT:
            self._show_next(now_s)
        return Done()

    def _set_sleep(self, value: int, now_s: float) -> None:
        self._values[Word.SLEEP_TIMER] = value
        if value:
            self._due["sleep"] = now_s + 60.0 * SLEEP_MINUTES[value]
        else:
            self._due.pop("sleep", None)
