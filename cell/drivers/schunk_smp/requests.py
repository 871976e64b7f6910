"""Questions to a module with answers of a known kind."""

from __future__ import annotations

from typing import TypeVar

from cell.clock import Clock
from cell.drivers.schunk_smp.commands import (
    CommandRecord,
    GetConfig,
    GetState,
    ToggleImpulses,
)
from cell.drivers.schunk_smp.conversation import Conversation
from cell.drivers.schunk_smp.replies import (
    Answer,
    Identity,
    ImpulsesSwitched,
    RegisterValue,
    StateReply,
)
from cell.drivers.schunk_smp.settings import SchunkSettings
from cell.drivers.schunk_smp.tables import (
    UNIT_MILLIMETRE,
    UNIT_SYSTEMS,
    Register,
    StateMode,
    Status,
    problem_of,
)
from cell.errors import DeviceError, DeviceTimeout

_TOGGLES = 4
_ASK_STATE = GetState(0.0, StateMode.ALL)
_AnswerT = TypeVar("_AnswerT", bound=Answer)


class ModuleRequests:
    """What a driver asks of a module; every answer is checked for its kind."""

    def __init__(self, conversation: Conversation, settings: SchunkSettings) -> None:
        self._conversation = conversation
        self._settings = settings

    def ask(self, command: CommandRecord, *, attempts: int | None = None) -> Answer:
        """Send a command and return its answer.

        Raises:
            DeviceError: The module refuses.
            DeviceTimeout: No answer came.
        """
        return self._conversation.ask(
            command, timeout_s=self._settings.reply_timeout_s, attempts=attempts
        )

    def state(self, *, attempts: int | None = None) -> StateReply:
        """Return position, velocity, current, status and error; ends a cyclic state."""
        return self._ask_for(_ASK_STATE, StateReply, attempts=attempts)

    def sound_state(self, what: str = "moving") -> StateReply:
        """Return the state of a module that has no error.

        Raises:
            DeviceError: It has one; `what` failed because of it.
        """
        state = self.state()
        if state.error or state.status & Status.ERROR:
            raise self.error(f"{what} failed: {problem_of(state.error).text}", state.error)
        return state

    def await_boot(self, clock: Clock) -> StateReply:
        """Return the first state; a module that was just switched on may need a while.

        Raises:
            DeviceTimeout: It stays silent longer than the settings allow.
        """
        settings = self._settings
        deadline_s = clock.now_s() + settings.boot_timeout_s
        for _ in range(int(settings.boot_timeout_s / settings.reply_timeout_s)):
            try:
                return self.state(attempts=1)
            except DeviceTimeout:
                if clock.now_s() >= deadline_s:
                    break
        return self.state(attempts=1)

    def identity(self) -> str:
        """Return who the module is, in a line."""
        who = self._ask_for(GetConfig(), Identity)
        return (
            f"SCHUNK {who.kind} id {self._settings.module_id}, order {who.order}, "
            f"firmware {who.firmware / 100:.2f}, protocol {who.protocol}"
        )

    def register(self, register: Register) -> float:
        """Return the value of a register of the configuration."""
        return self._ask_for(GetConfig(register), RegisterValue).value

    def require_millimetres(self) -> None:
        """Return if lengths are millimetres.

        Raises:
            DeviceError: They are something else; the driver would move wrongly.
        """
        unit = int(self.register(Register.UNIT_SYSTEM))
        if unit != UNIT_MILLIMETRE:
            raise DeviceError(
                self._settings.device,
                f"its unit system is {UNIT_SYSTEMS.get(unit, str(unit))}, not millimetre",
                hint=f"write {UNIT_MILLIMETRE} to register {Register.UNIT_SYSTEM:#04x} "
                "with the maker's software",
            )

    def switch_impulses_on(self) -> None:
        """Toggle until the module says ON: the command cannot set, only turn over.

        Raises:
            DeviceError: They stay off.
        """
        told_off = 0
        for _ in range(_TOGGLES):
            # A lost answer tells nothing, but the next one tells how it is then.
            try:
                if self._ask_for(ToggleImpulses(), ImpulsesSwitched).are_on:
                    return
                told_off += 1
            except DeviceTimeout as error:
                self._conversation.tell_repeated(error)
            if told_off == 2:
                break
        raise self.error("its spontaneous messages cannot be switched on", None)

    def error(self, problem: str, code: int | None) -> DeviceError:
        """Return an error of this module with the table's advice for a code."""
        advice = "" if code is None else problem_of(code).advice
        return DeviceError(self._settings.device, problem, code=code, hint=advice)

    def _ask_for(
        self, command: CommandRecord, kind: type[_AnswerT], *, attempts: int | None = None
    ) -> _AnswerT:
        answer = self.ask(command, attempts=attempts)
        if not isinstance(answer, kind):
            raise self.error(f"answered {type(answer).__name__} to {type(command).__name__}", None)
        return answer
