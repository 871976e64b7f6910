"""Executes direct statements: variables, moves, speeds, tools, hands and outputs."""

from __future__ import annotations

from cell.drivers.melfa_r3 import tables
from cell.drivers.melfa_r3.statements import (
    AssignJoints,
    AssignNumber,
    AssignPosition,
    Combined,
    Move,
    MoveRound,
    Operand,
    Position,
    SelectTool,
    SetBase,
    SetFigure,
    SetTool,
    Statement,
    SwitchHand,
    SwitchOutput,
    print_joints,
    print_position,
)
from cell.geometry import JointPositions, Pose, Transform
from cell.twin.bodies import JointTuple
from cell.twin.emulators.melfa_r3.arc import Circle, point
from cell.twin.emulators.melfa_r3.mechanism import Mechanism
from cell.twin.emulators.melfa_r3.planner import Planner
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.settings import ControllerSettings
from cell.twin.emulators.melfa_r3.stand import Stand, six
from cell.twin.emulators.melfa_r3.state import ControllerState
from cell.twin.emulators.melfa_r3.tool import ToolFrame, from_offset

JOINTS = 6
HANDS = 8
OUTPUTS = 32768


class Interpreter:
    """The controller's BASIC, one statement at a time."""

    def __init__(
        self,
        state: ControllerState,
        mechanism: Mechanism,
        planner: Planner,
        settings: ControllerSettings,
    ) -> None:
        self._state = state
        self._mechanism = mechanism
        self._planner = planner
        self._settings = settings
        self.tool = ToolFrame(settings.tool_mm)
        self._tool_number = 1
        self._positions: dict[str, Position] = {}
        self._joints: dict[str, JointTuple] = {}
        self._numbers: dict[str, float] = {}

    def forget(self) -> None:
        """Be as after power on: variables, tool and base are gone."""
        self.tool = ToolFrame(self._settings.tool_mm)
        self._tool_number = 1
        self._positions.clear()
        self._joints.clear()
        self._numbers.clear()

    def execute(self, statement: Statement, now_s: float, at_s: float) -> None:
        """Execute a statement that came at `now_s`; a motion starts at `at_s`.

        Raises:
            Refusal: It cannot be executed.
        """
        match statement:
            case AssignPosition(name, value):
                self._assign_position(name, value, now_s)
            case Move(is_straight, target):
                self._move(target, now_s, at_s, is_straight=is_straight)
            case MoveRound():
                self._move_round(statement, now_s, at_s)
            case AssignJoints(name, value):
                self._assign_joints(name, value, now_s)
            case AssignNumber(name, number):
                self._numbers[name] = number
            case SetFigure(word, values):
                self._set_figure(word, values)
            case SetTool(tool):
                self.tool.select(tool)
            case SetBase(base):
                self.tool.set_base(base)
            case SelectTool(number):
                self._select_tool(number)
            case SwitchHand(hand, is_open):
                self.switch_hand(hand, is_open=is_open)
            case SwitchOutput(bit, is_on):
                self.switch_output(bit, now_s, is_on=is_on)

    def move_to_joints(self, target_deg: JointTuple, now_s: float, at_s: float) -> None:
        """Start a move with even joints.

        Raises:
            Refusal: The servos are off or a joint would leave its limits.
        """
        self._require_servos(now_s)
        self._start_joint_move(self._planner.target_stand(target_deg), now_s, at_s)

    def switch_hand(self, hand: int, *, is_open: bool) -> None:
        """Open or close a hand.

        Raises:
            Refusal: There is no such hand.
        """
        if not 1 <= hand <= HANDS:
            raise Refusal(tables.ARGUMENT_RANGE)
        if is_open:
            self._state.open_hands.add(hand)
        else:
            self._state.open_hands.discard(hand)

    def switch_output(self, bit: int, now_s: float, *, is_on: bool) -> None:
        """Switch one output.

        Raises:
            Refusal: There is no such output.
        """
        if not 0 <= bit < OUTPUTS:
            raise Refusal(tables.ARGUMENT_RANGE)
        is_on = is_on and bit not in self._state.dead_outputs
        if is_on:
            self._state.outputs.add(bit)
        else:
            self._state.outputs.discard(bit)
        self._mechanism.switch_output(bit, now_s, is_on=is_on)

    def printed(self, name: str, now_s: float) -> str:
        """Return the value of a variable as the controller prints it.

        Raises:
            Refusal: There is no such variable.
        """
        if name.startswith("P"):
            if name == "P_TOOL":
                return f"{print_position(self.tool.tool, None)}(0,0)"
            position = self._position(name, now_s)
            return print_position(position.pose, position.flags or (0, 0))
        if name.startswith("J"):
            return print_joints(JointPositions(self._joints_of(name, now_s)))
        number = self._number(name, now_s)
        return f"{number:+g}"

    def _assign_position(self, name: str, value: Position | Operand, now_s: float) -> None:
        if isinstance(value, Position):
            self._positions[name] = value
        else:
            self._positions[name] = self._evaluate(value, now_s)

    def _assign_joints(self, name: str, value: tuple[float, ...] | str, now_s: float) -> None:
        if isinstance(value, str):
            self._joints[name] = self._joints_of(value, now_s)
        elif len(value) == JOINTS:
            self._joints[name] = six(value)
        else:
            raise Refusal(tables.ARGUMENT_COUNT)

    def _move(self, target: Operand, now_s: float, at_s: float, *, is_straight: bool) -> None:
        self._require_servos(now_s)
        planner = self._planner
        if isinstance(target, str) and target[0] == "J":
            end = planner.target_stand(self._joints_of(target, now_s))
            if is_straight:
                self._start_line(end.reported_pose, (end.posture, end.turns), now_s, at_s)
            else:
                self._start_joint_move(end, now_s, at_s)
            return
        position = self._evaluate(target, now_s)
        pose, flags = self.tool.to_fitted(position.pose), position.flags
        if is_straight:
            self._start_line(pose, flags, now_s, at_s)
        else:
            end = planner.solve(self._mechanism.stand(now_s), pose, flags)
            self._start_joint_move(end, now_s, at_s)

    def _move_round(self, move: MoveRound, now_s: float, at_s: float) -> None:
        self._require_servos(now_s)
        first, second, third = (
            self.tool.to_fitted(self._evaluate(operand, now_s).pose)
            for operand in (move.first, move.second, move.third)
        )
        if move.word == "MVR3":
            circle = Circle.about(point(first), point(second), point(third))
            target = second
        else:
            is_full = move.word == "MVC"
            circle = Circle.through(point(first), point(second), point(third), is_full=is_full)
            target = first if is_full else third
        stand = self._mechanism.stand(now_s)
        percent = self._state.override_percent
        path, end = self._planner.arc(stand, first, target, circle, percent, at_s)
        self._mechanism.follow(path, end)

    def _start_line(
        self, pose: Pose, flags: tuple[int, int] | None, now_s: float, at_s: float
    ) -> None:
        percent = self._state.override_percent
        path, end = self._planner.line(self._mechanism.stand(now_s), pose, flags, percent, at_s)
        self._mechanism.follow(path, end)

    def _start_joint_move(self, end: Stand, now_s: float, at_s: float) -> None:
        percent = self._state.override_percent
        path = self._planner.joint_move(self._mechanism.stand(now_s), end, percent, at_s)
        self._mechanism.follow(path, end)

    def _require_servos(self, now_s: float) -> None:
        if not self._state.is_servo_on(now_s):
            raise Refusal(tables.SERVO_OFF)

    def _set_figure(self, word: str, values: tuple[float, ...]) -> None:
        planner = self._planner
        highest = self._settings.max_linear_speed_mm_s if word == "SPD" else 100.0
        for value in values:
            if not 0 < value <= highest:
                raise Refusal(tables.ARGUMENT_RANGE)
        if word == "SPD":
            planner.speed_mm_s = values[0]
        elif word == "JOVRD":
            planner.joint_percent = values[0]
        elif word == "OVRD":
            planner.program_percent = values[0]
        else:
            planner.acceleration_percent, planner.braking_percent = values

    def _select_tool(self, number: int) -> None:
        offset_mm = self._settings.tools.get(number)
        if offset_mm is None:
            raise Refusal(tables.ARGUMENT_RANGE)
        self._tool_number = number
        self.tool.select(from_offset(offset_mm))

    def _evaluate(self, operand: Operand, now_s: float) -> Position:
        if isinstance(operand, str):
            return self._position(operand, now_s)
        return self._combine(operand, now_s)

    def _combine(self, operand: Combined, now_s: float) -> Position:
        first = self._position(operand.first, now_s)
        second = self._position(operand.second, now_s)
        if operand.operator == "*":
            chained = Transform.from_pose(first.pose) @ Transform.from_pose(second.pose)
            return Position(chained.to_pose(), first.flags)
        a, b = first.pose, second.pose
        pose = Pose(
            a.x_mm + b.x_mm,
            a.y_mm + b.y_mm,
            a.z_mm + b.z_mm,
            a.a_deg + b.a_deg,
            a.b_deg + b.b_deg,
            a.c_deg + b.c_deg,
        )
        return Position(pose, first.flags)

    def _position(self, name: str, now_s: float) -> Position:
        position = self._positions.get(name)
        if position is not None:
            return position
        if name == "P_CURR":
            stand = self._mechanism.stand(now_s)
            pose = self.tool.from_fitted(stand.reported_pose)
            return Position(pose, (stand.posture, stand.turns))
        raise Refusal(tables.ARGUMENT_TYPE if name[:1] != "P" else tables.UNKNOWN_VARIABLE)

    def _joints_of(self, name: str, now_s: float) -> JointTuple:
        joints = self._joints.get(name)
        if joints is not None:
            return joints
        if name == "J_CURR":
            return self._mechanism.joints_deg(now_s)
        raise Refusal(tables.ARGUMENT_TYPE if name[:1] != "J" else tables.UNKNOWN_VARIABLE)

    def _number(self, name: str, now_s: float) -> float:
        planner = self._planner
        system = {
            "M_SVO": float(self._state.is_servo_on(now_s)),
            "M_JOVRD": planner.joint_percent,
            "M_SPD": planner.speed_mm_s,
            "M_OVRD": float(self._state.override_percent),
            "M_ERR": float(self._state.alarm != 0),
            "M_TOOL": float(self._tool_number),
        }
        number = system.get(name, self._numbers.get(name))
        if number is None:
            raise Refusal(tables.UNKNOWN_VARIABLE)
        return number
