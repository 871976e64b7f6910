"""The emulated module on its line: power, boot, requests, answers, repetitions."""

from __future__ import annotations

from typing import Literal

from cell.drivers.schunk_smp.command_codec import decode_command
from cell.drivers.schunk_smp.commands import (
    Acknowledge,
    ChangeUser,
    CheckTestValues,
    CommandRecord,
    EmergencyStop,
    GetConfig,
    GetDetailedError,
    GetState,
    MoveCurrent,
    MoveGrip,
    MovePosition,
    MovePositionTimed,
    MoveVelocity,
    Reboot,
    Reference,
    SendTestValues,
    SetConfig,
    SetTarget,
    Stop,
    ToggleImpulses,
)
from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.framing import FROM_MASTER, DamagedFrame, Frame, FrameReader
from cell.drivers.schunk_smp.replies import (
    Accepted,
    Answer,
    DetailedError,
    ErrorReport,
    Identity,
    Impulse,
    ImpulsesSwitched,
    Info,
    KnownValues,
    KnownValuesChecked,
    MoveAccepted,
    Refused,
    RegisterValue,
    RegisterWritten,
    Reply,
    StateReply,
    UserChanged,
    WarningReport,
)
from cell.drivers.schunk_smp.reply_codec import TEST_VALUES, encode_reply
from cell.drivers.schunk_smp.tables import Code, Command, Register, StateMode, UserLevel
from cell.twin.bodies import FingerBody
from cell.twin.emulators.schunk_smp.mechanics import Mechanics
from cell.twin.emulators.schunk_smp.registers import Registers
from cell.twin.emulators.schunk_smp.settings import SchunkModuleSettings
from cell.twin.emulators.uart import Transmitter

_Power = Literal["off", "booting", "on"]
_Due = Literal["boot", "motion", "cycle", "error", "warning"]


class SchunkModule:
    """A PG-70 as a `cell.links.base.Emulator` on the twin's fingers.

    Whether it has power is asked of the body whenever somebody talks to it or
    listens. Without power it is silent and forgets everything but its registers.

    Args:
        body: The fingers.
        settings: Figures of the module.
        is_referenced: Whether it was powered and referenced long before, as a gripper
            is that outlives the program talking to it.
    """

    def __init__(
        self, body: FingerBody, settings: SchunkModuleSettings, *, is_referenced: bool = False
    ) -> None:
        self._body = body
        self._settings = settings
        self._registers = Registers(settings)
        self._mechanics = Mechanics(
            body, self._registers, settings, self._impulse, is_referenced=is_referenced
        )
        self._reader = FrameReader(FROM_MASTER)
        self._transmitter = Transmitter(settings.byte_s)
        self._power: _Power = "on" if is_referenced else "off"
        self._due: dict[_Due, float] = {}
        self._heard_s = 0.0
        self._are_impulses_on = True
        self._cycle = GetState()
        self._lasting: set[int] = set()
        self._raised: list[int] = []
        self._warned: list[int] = []
        self._is_silent = False
        self._corrupted = 0
        self._unpowered_until_s = 0.0

    @property
    def is_referenced(self) -> bool:
        """Whether the module knows its zero position."""
        return self._mechanics.is_referenced

    # The wire

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at `now_s`; without power they are lost."""
        self._catch_up(now_s)
        if self._power != "on":
            return
        if self._reader.is_waiting and now_s - self._heard_s > self._settings.frame_gap_s:
            self._reader.clear()
        self._heard_s = now_s
        answer_s = now_s + len(data) * self._settings.byte_s + self._settings.latency_s
        for received in self._reader.feed(data):
            if received.module == int(self._registers[Register.MODULE_ID]):
                self._handle(received, now_s, answer_s)

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`."""
        self._catch_up(now_s)
        data = self._transmitter.take(now_s)
        return b"" if self._is_silent else data

    def next_output_s(self) -> float | None:
        """Return when something will happen that makes bytes, or None.

        It may be a little early (a motion's end instead of its report's last byte),
        never late.
        """
        times = list(self._due.values())
        sent_s = self._transmitter.next_s()
        if sent_s is not None:
            times.append(sent_s)
        return min(times, default=None)

    # Faults to order

    def raise_error(self, code: int, *, is_lasting: bool = False) -> None:
        """Have an error happen; a lasting one cannot be acknowledged until `cure`."""
        self._raised.append(code)
        if is_lasting:
            self._lasting.add(code)

    def raise_warning(self, code: int) -> None:
        """Have a warning appear; it stays until `cure`."""
        self._warned.append(code)

    def cure(self) -> None:
        """Take away the causes of errors and warnings."""
        self._lasting.clear()
        self._mechanics.warning = 0
        self._due.pop("warning", None)

    def lose_power(self, now_s: float, *, for_s: float) -> None:
        """Take the module's own supply away for a time; then it starts, and knows no zero."""
        self._catch_up(now_s)
        self._unpowered_until_s = now_s + for_s
        self._catch_up(now_s)

    def lose_reference(self) -> None:
        """Let the module forget its zero, as after a fault of its encoder."""
        self._mechanics.is_referenced = False

    def set_register(self, register: Register, value: float) -> None:
        """Store a parameter, as somebody does with the maker's program."""
        self._registers.put(register, value)

    def corrupt_next_reply(self, count: int = 1) -> None:
        """Turn over a bit in each of the next `count` messages."""
        self._corrupted += count

    def go_silent(self) -> None:
        """Cut the wire from the module; what it says is lost."""
        self._is_silent = True

    def speak_again(self) -> None:
        """Mend the wire from the module."""
        self._is_silent = False

    # Time

    def _catch_up(self, now_s: float) -> None:
        """Let everything happen that was due by `now_s`, in order."""
        self._watch_power(now_s)
        if self._power == "on":
            while self._raised:
                self._mechanics.fail(self._raised.pop(0), now_s)
            while self._warned:
                self._mechanics.warning = self._warned.pop(0)
                self._impulse(WarningReport(self._mechanics.warning), now_s)
        self._plan_motion()
        while self._due:
            what = min(self._due, key=self._due.__getitem__)
            due_s = self._due[what]
            if due_s > now_s:
                break
            del self._due[what]
            self._happen(what, due_s)
            self._plan_motion()

    def _watch_power(self, now_s: float) -> None:
        is_powered = self._body.is_powered() and now_s >= self._unpowered_until_s
        if not is_powered and self._power != "off":
            if self._mechanics.motion is not None:
                self._body.halt(now_s)
            self._forget("off")
            self._transmitter.clear()
        elif is_powered and self._power == "off":
            self._forget("booting")
            self._due["boot"] = now_s + self._settings.boot_s

    def _forget(self, power: _Power) -> None:
        self._power = power
        self._mechanics.reset()
        self._reader.clear()
        self._due.clear()
        self._are_impulses_on = True
        self._registers.level = UserLevel.USER

    def _plan_motion(self) -> None:
        end_s = self._mechanics.end_s()
        if end_s is None:
            self._due.pop("motion", None)
        else:
            self._due["motion"] = end_s

    def _happen(self, what: _Due, at_s: float) -> None:
        match what:
            case "boot":
                self._power = "on"
                self._impulse(Info(Code.BOOT), at_s)
                for code in sorted(self._lasting):
                    self._mechanics.fail(code, at_s)
            case "motion":
                self._mechanics.finish()
            case "cycle":
                self._say(self._state(self._cycle, at_s), at_s)
                self._due["cycle"] = at_s + (self._cycle.period_s or 1.0)
            case "error":
                if self._mechanics.error:
                    self._impulse(ErrorReport(self._mechanics.error), at_s)
            case "warning":
                self._impulse(WarningReport(self._mechanics.warning), at_s)

    # Talking

    def _impulse(self, impulse: Impulse, at_s: float) -> None:
        if isinstance(impulse, ErrorReport):
            self._due["error"] = at_s + self._settings.error_period_s
        elif isinstance(impulse, WarningReport):
            self._due["warning"] = at_s + self._settings.warning_period_s
        if self._are_impulses_on:
            self._say(impulse, at_s)

    def _say(self, reply: Reply, at_s: float) -> None:
        module = int(self._registers[Register.MODULE_ID])
        data = encode_reply(module, reply, refusal_group=self._settings.refusal_group)
        if self._corrupted:
            self._corrupted -= 1
            data = data[:-1] + bytes((data[-1] ^ 0x01,))
        self._transmitter.send(data, at_s)

    def _handle(self, received: Frame | DamagedFrame, now_s: float, answer_s: float) -> None:
        if isinstance(received, DamagedFrame):
            self._say(Refused(received.command, Code.CHECKSUM), answer_s)
            return
        try:
            command = decode_command(received)
            answer = self._answer(command, now_s)
        except MalformedMessage as error:
            self._say(Refused(received.command, error.code), answer_s)
            return
        self._say(answer, answer_s)
        match command:
            case Acknowledge():
                self._after_acknowledge(answer_s)
            case EmergencyStop():
                self._mechanics.fail(Code.EMERGENCY_STOP, now_s)
            case Reboot():
                self._reboot(now_s)
            case _:
                pass
        self._plan_motion()

    def _answer(self, command: CommandRecord, now_s: float) -> Answer:
        mechanics = self._mechanics
        match command:
            case GetState():
                return self._answer_state(command, now_s)
            case MovePosition(is_relative=is_relative):
                duration_s = mechanics.move(command, now_s)
                code = Command.MOVE_POSITION_RELATIVE if is_relative else Command.MOVE_POSITION
                return MoveAccepted(code, duration_s)
            case MovePositionTimed(is_relative=is_relative):
                duration_s = mechanics.move(command, now_s)
                timed = Command.MOVE_POSITION_TIME
                relative = Command.MOVE_POSITION_TIME_RELATIVE
                return MoveAccepted(relative if is_relative else timed, duration_s)
            case MoveGrip():
                mechanics.push(command, now_s)
                return Accepted(Command.MOVE_GRIP)
            case MoveCurrent():
                mechanics.push(command, now_s)
                return Accepted(Command.MOVE_CURRENT)
            case MoveVelocity():
                mechanics.push(command, now_s)
                return Accepted(Command.MOVE_VELOCITY)
            case Reference():
                mechanics.reference(now_s)
                return Accepted(Command.REFERENCE)
            case Stop():
                mechanics.stop(now_s)
                return Accepted(Command.STOP)
            case EmergencyStop():
                return Accepted(Command.EMERGENCY_STOP)
            case Acknowledge():
                return Accepted(Command.ACKNOWLEDGE)
            case _:
                return self._answer_rare(command)

    def _answer_rare(
        self,
        command: GetConfig
        | SetConfig
        | SetTarget
        | ToggleImpulses
        | GetDetailedError
        | Reboot
        | ChangeUser
        | SendTestValues
        | CheckTestValues,
    ) -> Answer:
        match command:
            case GetConfig(None):
                return self._identity()
            case GetConfig(int(register)):
                return RegisterValue(register, self._registers.read(register))
            case SetConfig(register, value):
                self._registers.write(register, value)
                return RegisterWritten(register)
            case SetTarget(target, value):
                self._set_target(target, value)
                return Accepted(target)
            case ToggleImpulses():
                self._are_impulses_on = not self._are_impulses_on
                return ImpulsesSwitched(self._are_impulses_on)
            case GetDetailedError():
                return self._detailed_error()
            case ChangeUser(password):
                return UserChanged(self._registers.log_in(password))
            case SendTestValues():
                return KnownValues(TEST_VALUES)
            case CheckTestValues(block):
                if block != TEST_VALUES:
                    raise MalformedMessage("other values", code=Code.WRONG_PARAMETER)
                return KnownValuesChecked(0)
            case _:
                return Accepted(Command.REBOOT)

    def _answer_state(self, command: GetState, now_s: float) -> StateReply:
        if command.mode == StateMode(0) or (command.period_s or 0.0) < 0:
            raise MalformedMessage("a state of nothing", code=Code.WRONG_PARAMETER)
        self._due.pop("cycle", None)
        if command.period_s:
            self._cycle = command
            self._due["cycle"] = now_s + command.period_s
        return self._state(command, now_s)

    def _state(self, command: GetState, now_s: float) -> StateReply:
        mode = command.mode if command.mode is not None else StateMode.ALL
        mechanics = self._mechanics
        per_mm = 1.0 / self._registers.mm_per_unit
        return StateReply(
            mechanics.position_mm(now_s) * per_mm if mode & StateMode.POSITION else None,
            mechanics.velocity_mm_s(now_s) * per_mm if mode & StateMode.VELOCITY else None,
            mechanics.current_a() if mode & StateMode.CURRENT else None,
            mechanics.status(),
            mechanics.reported_code,
        )

    def _set_target(self, target: Command, value: float) -> None:
        limits = {
            Command.SET_TARGET_VELOCITY: Register.MAX_VELOCITY,
            Command.SET_TARGET_ACCELERATION: Register.MAX_ACCELERATION,
            Command.SET_TARGET_JERK: Register.MAX_JERK,
            Command.SET_TARGET_CURRENT: Register.MAX_CURRENT,
        }
        limit = limits.get(target)
        is_length = limit is not None and limit != Register.MAX_CURRENT
        scaled = value * self._registers.mm_per_unit if is_length else value
        if not scaled > 0 or (limit is not None and scaled > self._registers[limit]):
            raise MalformedMessage("a target is out of range", code=Code.WRONG_PARAMETER)
        self._mechanics.targets[target] = scaled

    def _identity(self) -> Identity:
        settings = self._settings
        return Identity(
            kind=settings.kind,
            order=settings.order_number,
            firmware=settings.firmware,
            protocol=3,
            hardware=1,
            date="2011-03-01 12:00",
        )

    def _detailed_error(self) -> DetailedError:
        code = self._mechanics.reported_code
        if not code:
            raise MalformedMessage("there is no error", code=Code.FAILED)
        kind = Command.ERROR if self._mechanics.error else Command.WARNING
        return DetailedError(kind, code, 0.0)

    def _after_acknowledge(self, at_s: float) -> None:
        mechanics = self._mechanics
        if mechanics.error in self._lasting:
            self._impulse(ErrorReport(mechanics.error), at_s)
            return
        mechanics.error = 0
        self._due.pop("error", None)
        self._impulse(Info(Code.NO_ERROR), at_s)

    def _reboot(self, now_s: float) -> None:
        if self._mechanics.motion is not None:
            self._body.halt(now_s)
        self._forget("booting")
        self._due["boot"] = now_s + self._settings.boot_s
