"""What each command of the wire does; the controller hands every request to this."""

from __future__ import annotations

from cell.drivers.melfa_r3 import records, tables
from cell.drivers.melfa_r3.codec import GarbledMessage, Request
from cell.drivers.melfa_r3.statements import (
    AssignJoints,
    AssignNumber,
    AssignPosition,
    parse_statement,
)
from cell.twin.bodies import ArmBody
from cell.twin.emulators.melfa_r3.arguments import number_of
from cell.twin.emulators.melfa_r3.editing import Editing
from cell.twin.emulators.melfa_r3.interpreter import Interpreter
from cell.twin.emulators.melfa_r3.library import ProgramLibrary
from cell.twin.emulators.melfa_r3.mechanism import Mechanism
from cell.twin.emulators.melfa_r3.parameters import parameter_values
from cell.twin.emulators.melfa_r3.planner import Planner
from cell.twin.emulators.melfa_r3.program import ProgramRunner
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.reports import Reports
from cell.twin.emulators.melfa_r3.settings import ControllerSettings
from cell.twin.emulators.melfa_r3.signals import Signals
from cell.twin.emulators.melfa_r3.state import ControllerState

_OPEN_IN_ANY_STATE = frozenset({"OPEN", "STOP", "RSTALRM", "SRVOFF"})


class Commands:
    """The commands of the R3 protocol on one controller.

    Attributes:
        state: What is on and off.
        mechanism: The arm.
        runner: The program in the slot.
        library: The programs in memory.
        identity: What it answers to OPEN.
        restarts: Whether a restart was asked for that has not happened yet.
    """

    def __init__(self, body: ArmBody, planner: Planner, settings: ControllerSettings) -> None:
        self._settings = settings
        self._planner = planner
        self.state = ControllerState(settings.override_percent)
        self.mechanism = Mechanism(body, planner, self.state.is_barred)
        self._interpreter = Interpreter(self.state, self.mechanism, planner, settings)
        self.restarts = False
        self.library = ProgramLibrary(settings.programs)
        self.identity = settings.identity
        self.runner = ProgramRunner(self.library, self._interpreter, self.mechanism.is_moving)
        self._editing = Editing(self.library, self.state, self.is_running)
        reports = Reports(
            self.state,
            self.mechanism,
            planner,
            interpreter=self._interpreter,
            runner=self.runner,
            editing=self._editing,
        )
        self._handlers = {
            "OPEN": self._open, "CLOSE": self._close,
            "CNTLON": self._take_right, "CNTLOFF": self._give_right_back,
            "SRVON": self._servos_on, "SRVOFF": self._servos_off,
            "OVRD": self._override, "EXEC": self._execute,
            "STOP": self._stop, "RUN": self._run, "RSTPRG": self._reset_program,
            "SLOTINIT": self._reset_program, "PRGLOAD": self._load_program,
            "RSTALRM": self._reset_alarm, "ERROR": self._error,
            "ERRORMES": self._error_text, "ERRORRD": self._last_error,
            "VAL": self._variable, "PNR": self._parameter, "PAR": self._parameter,
            "MOVSP": self._move_to_safe, "PDIR": self._programs, "RSTPWR": self._restart,
            **self._editing.handlers,
            **Signals(self.state, self._interpreter).handlers,
            **reports.handlers,
        }  # fmt: skip

    def answer(self, request: Request, now_s: float, at_s: float) -> str:
        """Carry out a request that came at `now_s` and return the data of its reply.

        Motions start at `at_s`, when the controller has worked the request through.

        Raises:
            Refusal: It is turned down.
        """
        robot, slot, command, args = request
        if robot not in (0, 1, self._settings.robot) or slot > 32:
            raise Refusal(tables.ARGUMENT_RANGE)
        state = self.state
        if not (state.is_open or command in _OPEN_IN_ANY_STATE):
            raise Refusal(tables.NOT_OPEN)
        if state.holder != "host" and (
            tables.COMMANDS[command].needs_right
            or (command in tables.WRITE_NEEDS_RIGHT and args.startswith("="))
        ):
            raise Refusal(tables.NO_RIGHT)
        if command == "EXEC":
            if not state.program and slot != self._settings.edit_slot:
                self._require_ready()
                raise Refusal(tables.NO_PROGRAM)
            return self._execute(args, now_s, at_s)
        return self._handlers[command](args, now_s, at_s)

    def is_running(self, now_s: float) -> bool:
        """Return whether a motion or a program is under way."""
        return self.runner.is_running or self.mechanism.is_moving(now_s)

    def lose_power(self, now_s: float) -> None:
        """Stand still where the arm is, outputs off, and forget session, right and program."""
        self.restarts = False
        self.library.close()
        self._interpreter.forget()
        self.mechanism.halt(now_s)
        for bit in sorted(self.state.outputs):
            self.mechanism.switch_output(bit, now_s, is_on=False)
        self.runner.reset()
        self._planner.reset_speeds()
        self.state.forget()

    # Session, right, servos

    def _open(self, args: str, now_s: float, at_s: float) -> str:
        self.state.is_open = True
        return records.print_identity(self.identity)

    def _close(self, args: str, now_s: float, at_s: float) -> str:
        self.state.is_open = False
        self.library.close()
        return self._give_right_back(args, now_s, at_s)

    def _restart(self, args: str, now_s: float, at_s: float) -> str:
        if self.is_running(now_s):
            raise Refusal(tables.BUSY)
        self.restarts = True
        return ""

    def _take_right(self, args: str, now_s: float, at_s: float) -> str:
        if not self.state.is_automatic or self.state.is_pendant_enabled:
            raise Refusal(tables.NOT_AUTOMATIC)
        if self.state.holder == "panel":
            raise Refusal(tables.RIGHT_HELD_ELSEWHERE)
        self.state.holder = "host"
        return ""

    def _give_right_back(self, args: str, now_s: float, at_s: float) -> str:
        if self.state.holder == "host":
            self.state.holder = "nobody"
        return ""

    def _servos_on(self, args: str, now_s: float, at_s: float) -> str:
        state = self.state
        is_manual = not state.is_automatic or state.is_pendant_enabled
        if state.is_blocked_by_alarm or state.is_emergency_pressed or is_manual:
            raise Refusal(tables.SERVO_ON_IMPOSSIBLE)
        if state.servo_ready_s is None:
            state.servo_ready_s = at_s + self._settings.servo_on_s
        return ""

    def _servos_off(self, args: str, now_s: float, at_s: float) -> str:
        self.runner.is_running = False
        self.mechanism.halt(now_s)
        self.state.servo_ready_s = None
        return ""

    # Motion

    def _require_ready(self) -> None:
        if self.state.is_blocked_by_alarm:
            raise Refusal(tables.ALARM_ACTIVE)

    def _require_idle(self, now_s: float) -> None:
        self._require_ready()
        if self.runner.is_running or self.mechanism.is_moving(now_s):
            raise Refusal(tables.BUSY)

    def _execute(self, args: str, now_s: float, at_s: float) -> str:
        self._require_idle(now_s)
        try:
            statement = parse_statement(args)
        except GarbledMessage as error:
            raise Refusal(tables.SYNTAX) from error
        self._interpreter.execute(statement, now_s, at_s)
        return ""

    def _move_to_safe(self, args: str, now_s: float, at_s: float) -> str:
        self._require_idle(now_s)
        self._interpreter.move_to_joints(self._settings.safe_deg, now_s, at_s)
        return ""

    def _stop(self, args: str, now_s: float, at_s: float) -> str:
        self.runner.is_running = False
        self.mechanism.brake(now_s)
        return ""

    def _override(self, args: str, now_s: float, at_s: float) -> str:
        if args:
            percent = number_of(args.removeprefix("="))
            if not 1 <= percent <= 100:
                raise Refusal(tables.ARGUMENT_RANGE)
            self.state.override_percent = percent
        return str(self.state.override_percent)

    # Programs

    def _load_program(self, args: str, now_s: float, at_s: float) -> str:
        if self.is_running(now_s):
            raise Refusal(tables.BUSY)
        name = args.removeprefix("=")
        self.runner.load(name)
        self.state.program = name
        self._planner.reset_speeds()
        return ""

    def _reset_program(self, args: str, now_s: float, at_s: float) -> str:
        if self.is_running(now_s):
            raise Refusal(tables.BUSY)
        self.runner.reset()
        return ""

    def _run(self, args: str, now_s: float, at_s: float) -> str:
        self._require_idle(now_s)
        if not self.state.is_servo_on(now_s):
            raise Refusal(tables.SERVO_OFF)
        name, _, mode = args.partition(";")
        if name:
            self._load_program(name, now_s, at_s)
            self.state.is_cyclic = mode == "1"
        elif not self.state.program:
            raise Refusal(tables.NO_PROGRAM)
        self.runner.start(is_cyclic=self.state.is_cyclic)
        return ""

    def _programs(self, args: str, now_s: float, at_s: float) -> str:
        names = self.library.names()
        index = 0 if args == "<" else number_of(args)
        if index >= len(names):
            return ""
        return f"{names[index]}.{self.identity.program_extension}"

    # Alarms

    def _reset_alarm(self, args: str, now_s: float, at_s: float) -> str:
        self.state.clear_alarm()
        return ""

    def _error(self, args: str, now_s: float, at_s: float) -> str:
        state = self.state
        return records.print_alarm((state.alarm, state.severity) if state.alarm else None)

    def _error_text(self, args: str, now_s: float, at_s: float) -> str:
        entry = tables.describe(number_of(args))
        return "unknown error" if entry is None else entry.text

    def _last_error(self, args: str, now_s: float, at_s: float) -> str:
        if not self.state.history:
            return ""
        number = self.state.history[0]
        return f"{number:04d};;{self._error_text(str(number), now_s, at_s)}"

    # Values and parameters

    def _variable(self, args: str, now_s: float, at_s: float) -> str:
        if not args.startswith("="):
            name = args.split(";", 1)[0].upper()
            return f"{name}={self._interpreter.printed(name, now_s)}"
        try:
            statement = parse_statement(args[1:])
        except GarbledMessage as error:
            raise Refusal(tables.SYNTAX) from error
        if not isinstance(statement, AssignPosition | AssignJoints | AssignNumber):
            raise Refusal(tables.SYNTAX)
        self._interpreter.execute(statement, now_s, at_s)
        return ""

    def _parameter(self, args: str, now_s: float, at_s: float) -> str:
        values = parameter_values(self._settings, args)
        if values is None:
            raise Refusal(tables.NO_SUCH_PARAMETER)
        return records.print_parameter(args, values)
