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
from cell.twin.emulators.melfa_r3.editing import Editing
from cell.twin.emulators.melfa_r3.interpreter import HANDS, OUTPUTS, Interpreter
from cell.twin.emulators.melfa_r3.library import ProgramLibrary
from cell.twin.emulators.melfa_r3.mechanism import Mechanism
from cell.twin.emulators.melfa_r3.parameters import parameter_values
from cell.twin.emulators.melfa_r3.planner import Planner
from cell.twin.emulators.melfa_r3.program import ProgramRunner
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.settings import ControllerSettings
from cell.twin.emulators.melfa_r3.state import ControllerState

_OPEN_IN_ANY_STATE = frozenset({"OPEN", "STOP", "RSTALRM", "SRVOFF"})
_FIRST_HAND_OUTPUT = 900


class Commands:
    """The commands of the R3 protocol on one controller.

    Attributes:
        state: What is on and off.
        mechanism: The arm.
        runner: The program in the slot.
        restarts: Whether a restart was asked for that has not happened yet.
    """

    def __init__(self, body: ArmBody, planner: Planner, settings: ControllerSettings) -> None:
        self._settings = settings
        self._planner = planner
        self.state = ControllerState(settings.override_percent)
        self.mechanism = Mechanism(body, planner)
        self._interpreter = Interpreter(self.state, self.mechanism, planner, settings)
        self.restarts = False
        self._library = ProgramLibrary(settings.programs)
        self.runner = ProgramRunner(self._library, self._interpreter, self.mechanism.is_moving)
        self._editing = Editing(self._library, self.state, self.is_running)
        self._handlers = {
            "OPEN": self._open, "CLOSE": self._close,
            "CNTLON": self._take_right, "CNTLOFF": self._give_right_back,
            "SRVON": self._servos_on, "SRVOFF": self._servos_off,
            "OVRD": self._override, "EXEC": self._execute,
            "HNDON": self._hand_on, "HNDOFF": self._hand_off, "HNDSTS": self._hands,
            "PPOSF": self._pose, "JPOSF": self._joints,
            "PPOS": self._one_coordinate, "JPOS": self._one_joint,
            "STATE": self._state, "DSTATE": self._short_state, "STPSIG": self._stop_sources,
            "STOP": self._stop, "RUN": self._run, "RSTPRG": self._reset_program,
            "SLOTINIT": self._reset_program, "PRGLOAD": self._load_program,
            "RSTALRM": self._reset_alarm, "ERROR": self._error,
            "ERRORMES": self._error_text, "ERRORRD": self._last_error,
            "IN": self._inputs, "OUT": self._outputs, "IOSIGNAL": self._signals,
            "VAL": self._variable, "PNR": self._parameter, "PAR": self._parameter,
            "MOVSP": self._move_to_safe, "PDIR": self._programs, "RSTPWR": self._restart,
            **self._editing.handlers,
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
        self._library.close()
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
        return records.print_identity(self._settings.identity)

    def _close(self, args: str, now_s: float, at_s: float) -> str:
        self.state.is_open = False
        self._library.close()
        return self._give_right_back(args, now_s, at_s)

    def _restart(self, args: str, now_s: float, at_s: float) -> str:
        if self.is_running(now_s):
            raise Refusal(tables.BUSY)
        self.restarts = True
        return ""

    def _take_right(self, args: str, now_s: float, at_s: float) -> str:
        if not self.state.is_automatic:
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
        if state.is_blocked_by_alarm or state.is_emergency_pressed or not state.is_automatic:
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
            percent = _number(args.removeprefix("="))
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
        names = self._library.names()
        index = 0 if args == "<" else _number(args)
        if index >= len(names):
            return ""
        return f"{names[index]}.{self._settings.identity.program_extension}"

    # Where it is and how it is

    def _pose(self, args: str, now_s: float, at_s: float) -> str:
        stand = self.mechanism.stand(now_s)
        pose = self._interpreter.tool.from_fitted(stand.reported_pose)
        values = (pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg)
        return self._axes(records.CARTESIAN, values, (stand.posture, stand.turns), now_s)

    def _joints(self, args: str, now_s: float, at_s: float) -> str:
        return self._axes(records.JOINTS, self.mechanism.joints_deg(now_s), None, now_s)

    def _one_coordinate(self, args: str, now_s: float, at_s: float) -> str:
        report = records.parse_axes(self._pose(args, now_s, at_s))
        return self._one(report, args)

    def _one_joint(self, args: str, now_s: float, at_s: float) -> str:
        report = records.parse_axes(self._joints(args, now_s, at_s))
        return self._one(report, f"J{args}")

    def _one(self, report: records.AxisReport, name: str) -> str:
        if name not in report.names:
            raise Refusal(tables.ARGUMENT_RANGE)
        value = report.values[report.names.index(name)]
        return records.print_axes(report._replace(names=(name,), values=(value,)))

    def _axes(
        self,
        names: tuple[str, ...],
        values: tuple[float, ...],
        flags: tuple[int, int] | None,
        now_s: float,
    ) -> str:
        mechanism = self.mechanism
        speed = mechanism.speed_mm_s(now_s)
        mask = self._planner.limit_mask(mechanism.joints_deg(now_s))
        return records.print_axes(
            records.AxisReport(names, values, flags, self.state.override_percent, speed, mask)
        )

    def _state(self, args: str, now_s: float, at_s: float) -> str:
        state = self.state
        is_running = self.is_running(now_s)
        return records.print_full_state(
            records.FullState(
                program=state.program,
                line=str(self.runner.line),
                override_percent=state.override_percent,
                edit=self._editing.status(is_running=is_running),
                run=state.run_status(now_s, is_running=is_running),
                stop=state.stop_status(is_running=is_running),
                error=state.alarm,
                step="1",
                mechanism_mask=1,
                slot_program=state.program,
                is_cyclic=state.is_cyclic,
                start="START",
                priority="1",
                mechanism="1" if is_running else "0",
            )
        )

    def _short_state(self, args: str, now_s: float, at_s: float) -> str:
        is_running = self.is_running(now_s)
        state = self.state
        run = state.run_status(now_s, is_running=is_running)
        stop = state.stop_status(is_running=is_running)
        return f"{run:02X}{stop:02X}{state.alarm};1;{int(is_running)}"

    def _stop_sources(self, args: str, now_s: float, at_s: float) -> str:
        return records.print_stop_sources(records.StopSources(0, self.state.emergency_sources()))

    # Alarms

    def _reset_alarm(self, args: str, now_s: float, at_s: float) -> str:
        self.state.clear_alarm()
        return ""

    def _error(self, args: str, now_s: float, at_s: float) -> str:
        state = self.state
        return records.print_alarm((state.alarm, state.severity) if state.alarm else None)

    def _error_text(self, args: str, now_s: float, at_s: float) -> str:
        entry = tables.describe(_number(args))
        return "unknown error" if entry is None else entry.text

    def _last_error(self, args: str, now_s: float, at_s: float) -> str:
        if not self.state.history:
            return ""
        number = self.state.history[0]
        return f"{number:04d};;{self._error_text(str(number), now_s, at_s)}"

    # Hands and signals

    def _hand_on(self, args: str, now_s: float, at_s: float) -> str:
        self._interpreter.switch_hand(_number(args), is_open=True)
        return ""

    def _hand_off(self, args: str, now_s: float, at_s: float) -> str:
        self._interpreter.switch_hand(_number(args), is_open=False)
        return ""

    def _hands(self, args: str, now_s: float, at_s: float) -> str:
        is_open = self.state.open_hands
        return records.print_hands(
            [
                records.HandState(_FIRST_HAND_OUTPUT + 2 * hand, 1 if hand + 1 in is_open else 2, 1)
                for hand in range(HANDS)
            ]
        )

    def _outputs(self, args: str, now_s: float, at_s: float) -> str:
        if args.startswith("="):
            first, word, width = _signal_write(args)
            for bit in range(width):
                self._interpreter.switch_output(first + bit, now_s, is_on=bool(word >> bit & 1))
            return ""
        return records.print_words(_word(self.state.outputs, _signal(args)))

    def _inputs(self, args: str, now_s: float, at_s: float) -> str:
        inputs = self.state.inputs
        if args.startswith("="):
            first, word, width = _signal_write(args)
            for bit in range(width):
                (inputs.add if word >> bit & 1 else inputs.discard)(first + bit)
            return ""
        return records.print_words(_word(inputs, _signal(args)))

    def _signals(self, args: str, now_s: float, at_s: float) -> str:
        first_input, semicolon, first_output = args.partition(";")
        if not semicolon:
            raise Refusal(tables.ARGUMENT_COUNT)
        return records.print_words(
            _word(self.state.inputs, _signal(first_input)),
            _word(self.state.outputs, _signal(first_output)),
        )

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


def _number(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 9):
        raise Refusal(tables.ARGUMENT_TYPE)
    return int(text)


def _signal(text: str) -> int:
    """Return the number of a first signal.

    Raises:
        Refusal: It is no number, or 16 signals from there on are too many.
    """
    first = _number(text)
    if first > OUTPUTS - 16:
        raise Refusal(tables.ARGUMENT_RANGE)
    return first


def _signal_write(args: str) -> tuple[int, int, int]:
    """Return first signal, word and width of `=<no>;<hhhh>` (16 wide) or `=<no>;<0 or 1>`."""
    first, semicolon, digits = args[1:].partition(";")
    if not semicolon:
        raise Refusal(tables.ARGUMENT_COUNT)
    if digits in ("0", "1"):
        return _signal(first), int(digits), 1
    try:
        if len(digits) != 4:
            raise Refusal(tables.ARGUMENT_TYPE)
        return _signal(first), int(digits, 16), 16
    except ValueError as error:
        raise Refusal(tables.ARGUMENT_TYPE) from error


def _word(signals: set[int], first: int) -> int:
    return sum([1 << bit for bit in range(16) if first + bit in signals])
