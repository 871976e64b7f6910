"""Direct statements: the MELFA-BASIC text behind EXEC, as records and as text.

Only statements that a host sends one at a time are here: assignments, moves,
speeds, tool, hands and outputs. Words are case-insensitive and a blank after
EXEC is tolerated.
"""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import Literal, NamedTuple, TypeAlias

from cell.drivers.melfa_r3.codec import GarbledMessage, UnsendableRequest
from cell.geometry import JointPositions, Pose

Values: TypeAlias = tuple[float, ...]


class Position(NamedTuple):
    """A position constant: `(x,y,z,a,b,c)` and, if given, `(FL1,FL2)`."""

    pose: Pose
    flags: tuple[int, int] | None


class Combined(NamedTuple):
    """Two positions joined: `+` adds the components, `*` chains them (in the tool's frame)."""

    first: str
    operator: Literal["+", "*"]
    second: str


Operand: TypeAlias = str | Combined
"""Name of a variable, or two of them joined."""


class AssignPosition(NamedTuple):
    """`P1=(…)(…)` or `P1=P_CURR`."""

    name: str
    value: Position | Operand


class AssignJoints(NamedTuple):
    """`J1=(…)` or `J1=J_CURR`."""

    name: str
    value: Values | str


class AssignNumber(NamedTuple):
    """`M1=3.5`."""

    name: str
    value: float


class Move(NamedTuple):
    """`MOV` (joint interpolation) or `MVS` (straight) to an operand."""

    is_straight: bool
    target: Operand


class MoveRound(NamedTuple):
    """A circular move: `MVR start,via,end`, `MVR3 start,end,centre` or `MVC start,via,via`.

    An arm that does not stand at `start` goes there first, straight. `MVC` goes round the
    whole circle, back to `start`.
    """

    word: Literal["MVR", "MVR3", "MVC"]
    first: Operand
    second: Operand
    third: Operand


class SetFigure(NamedTuple):
    """`SPD`, `JOVRD`, `OVRD` or `ACCEL` with its figures."""

    word: Literal["SPD", "JOVRD", "OVRD", "ACCEL"]
    values: Values


class SetTool(NamedTuple):
    """`TOOL (x,y,z,a,b,c)`: the tool point in the flange's frame."""

    tool: Pose


class SetBase(NamedTuple):
    """`BASE (x,y,z,a,b,c)`: the robot's base in the frame in which poses are given."""

    base: Pose


class SelectTool(NamedTuple):
    """`M_TOOL=n`."""

    number: int


class SwitchHand(NamedTuple):
    """`HOPEN n` or `HCLOSE n`."""

    hand: int
    is_open: bool


class SwitchOutput(NamedTuple):
    """`M_OUT(n)=0` or `=1`."""

    bit: int
    is_on: bool


Statement: TypeAlias = (
    AssignPosition
    | AssignJoints
    | AssignNumber
    | Move
    | MoveRound
    | SetFigure
    | SetTool
    | SetBase
    | SelectTool
    | SwitchHand
    | SwitchOutput
)

_COMBINED = re.compile(r"(P\w*)\s*([+*])\s*(P\w*)", re.ASCII)
_OUTPUT = re.compile(r"M_OUT\s*\(\s*(\d+)\s*\)\s*=\s*([01])", re.ASCII)
_NUMBER_NAME = re.compile(r"M\w*", re.ASCII)
_TYPE = re.compile(r"\s+TYPE\s+\d+\s*,\s*\d+", re.ASCII)
_ROUND: dict[str, Literal["MVR", "MVR3", "MVC"]] = {"MVR": "MVR", "MVR3": "MVR3", "MVC": "MVC"}
_FIGURES: dict[str, tuple[Literal["SPD", "JOVRD", "OVRD", "ACCEL"], int]] = {
    "SPD": ("SPD", 1),
    "JOVRD": ("JOVRD", 1),
    "OVRD": ("OVRD", 1),
    "ACCEL": ("ACCEL", 2),
}


def print_position(pose: Pose, flags: tuple[int, int] | None) -> str:
    """Return a position constant with three decimals.

    Raises:
        UnsendableRequest: A number is not finite.
    """
    x, y, z, a, b, c = pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg
    if not math.isfinite(x + y + z + a + b + c):
        raise UnsendableRequest(f"{pose} is no position")
    text = f"({x:.3f},{y:.3f},{z:.3f},{a:.3f},{b:.3f},{c:.3f})".replace("-0.000", "0.000")
    return text if flags is None else f"{text}({flags[0]},{flags[1]})"


def print_joints(joints: JointPositions) -> str:
    """Return a joint constant with four decimals.

    Raises:
        UnsendableRequest: An angle is not finite.
    """
    if not math.isfinite(sum(joints.values)):
        raise UnsendableRequest(f"{joints} are no joint angles")
    return "(" + ",".join([f"{angle:.4f}" for angle in joints.values]) + ")"


def print_statement(statement: Statement) -> str:
    """Return the text of a statement as a host sends it after EXEC.

    Raises:
        UnsendableRequest: A number is not finite.
    """
    match statement:
        case AssignPosition(name, Position(pose, flags)):
            return f"{name}={print_position(pose, flags)}"
        case AssignJoints(name, tuple() as values):
            return f"{name}={print_joints(JointPositions(values))}"
        case AssignPosition(name, str() | Combined() as operand):
            return f"{name}={_print_operand(operand)}"
        case AssignJoints(name, str() as source):
            return f"{name}={source}"
        case AssignNumber(name, value):
            return f"{name}={_print_number(value)}"
        case Move(is_straight, target):
            return f"{'MVS' if is_straight else 'MOV'} {_print_operand(target)}"
        case MoveRound(round_word, first, second, third):
            places = ",".join([_print_operand(place) for place in (first, second, third)])
            return f"{round_word} {places}"
        case SetFigure(word, values):
            return f"{word} {','.join([_print_number(value) for value in values])}"
        case SetTool(tool):
            return f"TOOL {print_position(tool, None)}"
        case SetBase(base):
            return f"BASE {print_position(base, None)}"
        case SelectTool(number):
            return f"M_TOOL={number}"
        case SwitchHand(hand, is_open):
            return f"{'HOPEN' if is_open else 'HCLOSE'} {hand}"
        case SwitchOutput(bit, is_on):
            return f"M_OUT({bit})={int(is_on)}"
    raise UnsendableRequest(f"{statement!r} is no statement")


@lru_cache(maxsize=64)
def parse_statement(text: str) -> Statement:
    """Read a direct statement.

    Raises:
        GarbledMessage: The text is no statement of this subset.
    """
    text = text.strip().upper()
    try:
        head, equals, value = text.partition("=")
        if equals:
            return _parse_assignment(text, head.rstrip(), value.lstrip())
        word, _, rest = text.partition(" ")
        return _parse_command(word, rest.strip())
    except ValueError as error:
        raise GarbledMessage(f"the statement {text[:120]!r} cannot be read") from error


def parse_operand(text: str) -> Operand:
    """Read the name of a variable or two names joined by `+` or `*`.

    Raises:
        ValueError: The text is neither.
    """
    if text.isidentifier() and text[0] in "PJ":
        return text
    combined = _COMBINED.fullmatch(text)
    if combined is None:
        raise ValueError(text)
    first, operator, second = combined.groups()
    return Combined(first, "+" if operator == "+" else "*", second)


def parse_position(text: str) -> Position:
    """Read a position constant; missing flags stay undefined.

    Raises:
        ValueError: The text is no position.
    """
    groups = text.split("(")
    if groups[0] or not 2 <= len(groups) <= 3:
        raise ValueError(text)
    x, y, z, a, b, c = _group(groups[1])
    flags = None
    if len(groups) == 3:
        body = groups[2].rstrip()
        first, second = body[:-1].split(",")
        if body[-1] != ")":
            raise ValueError(text)
        flags = (int(first), int(second))
    return Position(Pose(x, y, z, a, b, c), flags)


def _parse_assignment(text: str, name: str, value: str) -> Statement:
    if name.startswith("M"):
        output = _OUTPUT.fullmatch(text)
        if output is not None:
            return SwitchOutput(int(output[1]), output[2] == "1")
        if name == "M_TOOL":
            return SelectTool(int(value))
        if _NUMBER_NAME.fullmatch(name):
            return AssignNumber(name, _finite(value))
        raise ValueError(text)
    if not (name.isidentifier() and name[0] in "PJ"):
        raise ValueError(text)
    if name[0] == "P":
        if value[:1] == "(":
            return AssignPosition(name, parse_position(value))
        return AssignPosition(name, parse_operand(value))
    if value[:1] == "(":
        return AssignJoints(name, tuple(_group(value[1:])))
    source = parse_operand(value)
    if not isinstance(source, str):
        raise ValueError(text)
    return AssignJoints(name, source)


def _parse_command(word: str, rest: str) -> Statement:
    if word == "MVS" or word == "MOV":
        return Move(word == "MVS", parse_operand(_TYPE.sub("", rest) if " " in rest else rest))
    figure = _FIGURES.get(word)
    if figure is not None:
        name, count = figure
        values = tuple([_finite(field) for field in rest.split(",")])
        if len(values) != count:
            raise ValueError(rest)
        return SetFigure(name, values)
    round_word = _ROUND.get(word)
    if round_word is not None:
        first, second, third = [parse_operand(p.strip()) for p in _TYPE.sub("", rest).split(",")]
        return MoveRound(round_word, first, second, third)
    if word == "HOPEN" or word == "HCLOSE":
        return SwitchHand(int(rest), word == "HOPEN")
    if word == "TOOL":
        return SetTool(parse_position(rest).pose)
    if word == "BASE":
        return SetBase(parse_position(rest).pose)
    raise ValueError(word)


def _group(text: str) -> list[float]:
    """Return the numbers of `x,y,…)`."""
    body = text.rstrip()
    if body[-1:] != ")":
        raise ValueError(text)
    values = [float(field) for field in body[:-1].split(",")]
    if not math.isfinite(sum(values)):
        raise ValueError(text)
    return values


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def _print_number(value: float) -> str:
    if not math.isfinite(value):
        raise UnsendableRequest(f"{value} is no number")
    return str(int(value)) if value == int(value) else f"{value:.3f}"


def _print_operand(operand: Operand) -> str:
    if isinstance(operand, str):
        return operand
    return f"{operand.first}{operand.operator}{operand.second}"
