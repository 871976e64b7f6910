"""What the data of replies mean: parsers and printers, one pair a record.

Parsers raise `GarbledMessage` and nothing else; printers give the controller's
own layout, so that a driver and an emulator share every field.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.geometry import JointAngles, Pose

CARTESIAN = ("X", "Y", "Z", "A", "B", "C")
JOINTS = ("J1", "J2", "J3", "J4", "J5", "J6")
_LAYOUTS: dict[tuple[str, ...], str] = {
    names: ";".join([f"{name};%.2f" for name in names]) for names in (CARTESIAN, JOINTS)
}


class AxisReport(NamedTuple):
    """Reply to PPOSF, JPOSF and their one-axis forms.

    Attributes:
        names: Names of the axes, such as `X` or `J1`.
        values: Their values in mm or deg; None where the controller prints stars.
        flags: FL1 and FL2; None where the controller prints stars or nothing.
        override_percent: The override in force.
        speed_mm_s: The present speed.
        limit_mask: A bit for each axis that stands at a limit.
    """

    names: tuple[str, ...]
    values: tuple[float | None, ...]
    flags: tuple[int, int] | None
    override_percent: int
    speed_mm_s: float
    limit_mask: int


def parse_axes(data: str) -> AxisReport:
    """Read the data of a PPOSF or JPOSF reply, by name.

    Raises:
        GarbledMessage: The data have another layout or a number is none.
    """
    fields = data.split(";")
    try:
        end = fields.index("")
        flags, override, speed, mask = fields[end + 1 : end + 5]
        values = tuple([None if field == "****" else float(field) for field in fields[1:end:2]])
        names = tuple(fields[0:end:2])
        if len(names) != len(values) or not math.isfinite(sum(filter(None, values))):
            raise ValueError(data)
        return AxisReport(
            names, values, _flags(flags), int(override), _finite(speed), int(mask, 16)
        )
    except ValueError as error:
        raise GarbledMessage(f"the position reads {data[:120]!r}") from error


def print_axes(report: AxisReport) -> str:
    """Return the data of a PPOSF or JPOSF reply."""
    names, values, flags, override, speed, mask = report
    layout = _LAYOUTS.get(names)
    if layout is not None and None not in values:
        pairs = layout % values
    else:
        pairs = ";".join(
            [
                f"{name};****" if value is None else f"{name};{value:.2f}"
                for name, value in zip(names, values, strict=True)
            ]
        )
    flag_text = "****,****" if flags is None else f"{flags[0]},{flags[1]}"
    # A zero has no sign: rounding noise must not show.
    return f"{pairs};;{flag_text};{override};{speed:.2f};{mask:08X}".replace("-0.00;", "0.00;")


def pose_of(report: AxisReport) -> Pose:
    """Return the pose that a PPOSF reply gives.

    Raises:
        GarbledMessage: An axis is missing or has no value.
    """
    if report.names == CARTESIAN:
        x, y, z, a, b, c = report.values
        if not (x is None or y is None or z is None or a is None or b is None or c is None):
            return Pose(x, y, z, a, b, c)
    raise GarbledMessage(f"the pose has axes {report.names} with values {report.values}")


def joints_of(report: AxisReport) -> JointAngles:
    """Return the joint angles that a JPOSF reply gives.

    Raises:
        GarbledMessage: A joint is missing or has no value.
    """
    angles = tuple([value for value in report.values if value is not None])
    if report.names == JOINTS and len(angles) == len(JOINTS):
        return JointAngles(angles)
    raise GarbledMessage(f"the joints are {report.names} with values {report.values}")


class ShortState(NamedTuple):
    """Reply to DSTATE; the bits are `tables.Run` and `tables.Stop`."""

    run: int
    stop: int
    error: int
    step: str = "1"
    mechanism: str = "0"


def parse_short_state(data: str) -> ShortState:
    """Read the data of a DSTATE reply.

    Raises:
        GarbledMessage: The data have another layout.
    """
    try:
        status, step, mechanism = data.split(";", 2)
        run, stop, error = _status(status)
    except ValueError as problem:
        raise GarbledMessage(f"the short state reads {data[:80]!r}") from problem
    return ShortState(run, stop, error, step, mechanism)


def print_short_state(state: ShortState) -> str:
    """Return the data of a DSTATE reply."""
    run, stop, error, step, mechanism = state
    return f"{run:02X}{stop:02X}{error};{step};{mechanism}"


class FullState(NamedTuple):
    """Reply to STATE; the bits are `tables.Run` and `tables.Stop`.

    Attributes:
        program: Program loaded in the slot, empty for none.
        line: Line it stands at.
        override_percent: The override in force.
        edit: Edit status: bit 0 editing, bit 1 running, bit 2 changed.
        run: Run status.
        stop: Stop status.
        error: Number of the active alarm, 0 for none.
        step: Step it stands at.
        mechanism_mask: Mechanisms of the slot.
        slot_program: Program of the slot table.
        is_cyclic: Whether the slot runs one cycle instead of repeating.
        start: `START`, `ALWAYS` or `ERROR`.
        priority: 1 to 31.
        mechanism: Number of the mechanism the slot moves now, 0 for none.
    """

    program: str
    line: str
    override_percent: int
    edit: int
    run: int
    stop: int
    error: int
    step: str
    mechanism_mask: int
    slot_program: str
    is_cyclic: bool
    start: str
    priority: str
    mechanism: str


def parse_full_state(data: str) -> FullState:
    """Read the data of a STATE reply.

    Raises:
        GarbledMessage: The data have another layout.
    """
    fields = data.split(";")
    try:
        program, line, override, edit, status, step, mask = fields[:7]
        slot_program, mode, start, priority, mechanism = fields[14:19]
        run, stop, error = _status(status)
        if mode not in {"REP", "CYC"}:
            raise ValueError
        return FullState(
            program,
            line,
            int(override),
            int(edit, 16),
            run,
            stop,
            error,
            step,
            int(mask, 16),
            slot_program,
            mode == "CYC",
            start,
            priority,
            mechanism,
        )
    except ValueError as problem:
        raise GarbledMessage(f"the state reads {data[:120]!r}") from problem


def print_full_state(state: FullState) -> str:
    """Return the data of a STATE reply."""
    return ";".join(
        [
            state.program,
            state.line,
            str(state.override_percent),
            f"{state.edit:02X}",
            f"{state.run:02X}{state.stop:02X}{state.error}",
            state.step,
            f"{state.mechanism_mask:02X}",
            *[""] * 7,
            state.slot_program,
            "CYC" if state.is_cyclic else "REP",
            state.start,
            state.priority,
            state.mechanism,
        ]
    )


class Identity(NamedTuple):
    """Reply to OPEN: who the controller is.

    Attributes:
        axis_mask: Cartesian axes, a bit each.
        joint_mask: Joints, a bit each.
        flags: FL1 and FL2.
        jog_speeds: The seven jog speeds in percent.
        program_extension: Extension of program files.
        parameter_extension: Extension of parameter files.
        robot: Type of the arm.
        controller: Type of the controller.
        maker: `MELFA`.
        date: Date of the software, yy-mm-dd.
        version: Version of the software.
        language: Language of its texts.
        copyright: Its copyright line.
        tail: Robot information, serial field and number of tasks.
    """

    axis_mask: int
    joint_mask: int
    flags: tuple[int, int] | None
    jog_speeds: tuple[int, ...]
    program_extension: str
    parameter_extension: str
    robot: str
    controller: str
    maker: str
    date: str
    version: str
    language: str
    copyright: str
    tail: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.maker} {self.robot} on {self.controller} {self.version} ({self.date})"


def parse_identity(data: str) -> Identity:
    """Read the data of an OPEN reply.

    Raises:
        GarbledMessage: The data have another layout.
    """
    fields = data.removesuffix(";").split(";")
    try:
        axes, joints, flags, jogs = fields[:4]
        return Identity(
            int(axes, 16),
            int(joints, 16),
            _flags(flags),
            tuple([int(jog, 16) for jog in jogs.split(",")]),
            *_texts(fields[4:13]),
            tuple(fields[13:]),
        )
    except ValueError as error:
        raise GarbledMessage(f"the identity reads {data[:120]!r}") from error


def print_identity(identity: Identity) -> str:
    """Return the data of an OPEN reply."""
    flags = identity.flags or (0, 0)
    return (
        ";".join(
            [
                f"{identity.axis_mask:02X}",
                f"{identity.joint_mask:02X}",
                f"{flags[0]},{flags[1]}",
                ",".join([f"{jog:X}" for jog in identity.jog_speeds]),
                *identity[4:13],
                *identity.tail,
            ]
        )
        + ";"
    )


def parse_alarm(data: str) -> tuple[int, str] | None:
    """Read the data of an ERROR reply: number and level, None when no alarm is active.

    Raises:
        GarbledMessage: The data hold no number.
    """
    if not data.strip(";"):
        return None
    number, _, level = data.partition(";")
    try:
        return _whole(number), level.rstrip(";")
    except ValueError as error:
        raise GarbledMessage(f"the alarm reads {data[:80]!r}") from error


def print_alarm(alarm: tuple[int, str] | None) -> str:
    """Return the data of an ERROR reply."""
    return "" if alarm is None else f"{alarm[0]:04d};{alarm[1]}"


def parse_percent(data: str) -> int:
    """Read the data of an OVRD reply.

    Raises:
        GarbledMessage: The data are no whole number.
    """
    try:
        return _whole(data)
    except ValueError as error:
        raise GarbledMessage(f"the override reads {data[:80]!r}") from error


def parse_word(data: str) -> int:
    """Read the data of an OUT or IN reply: 16 signals, the first one in bit 0.

    Raises:
        GarbledMessage: The data are not four hexadecimal digits.
    """
    return _hex_words(data, 1)[0]


def parse_word_pair(data: str) -> tuple[int, int]:
    """Read the data of an IOSIGNAL reply: 16 inputs and 16 outputs.

    Raises:
        GarbledMessage: The data are not eight hexadecimal digits.
    """
    inputs, outputs = _hex_words(data, 2)
    return inputs, outputs


def print_words(*words: int) -> str:
    """Return the data of an OUT, IN or IOSIGNAL reply."""
    return "".join([f"{word:04X}" for word in words])


def parse_variable(data: str) -> tuple[str, str]:
    """Read the data of a VAL reply: name and value as printed.

    Raises:
        GarbledMessage: The data hold no `=`.
    """
    name, equals, value = data.partition("=")
    if not equals or not name:
        raise GarbledMessage(f"the variable reads {data[:80]!r}")
    return name, value


def parse_parameter(data: str) -> tuple[str, tuple[str, ...]]:
    """Read the data of a PNR reply: name and values.

    Raises:
        GarbledMessage: The data hold no `;`.
    """
    name, semicolon, values = data.partition(";")
    if not semicolon or not name:
        raise GarbledMessage(f"the parameter reads {data[:80]!r}")
    return name, tuple([value.strip() for value in values.split(",")])


def print_parameter(name: str, values: Sequence[str]) -> str:
    """Return the data of a PNR reply."""
    return f"{name};{', '.join(values)}"


class HandState(NamedTuple):
    """One hand in the reply to HNDSTS.

    Attributes:
        output: Number of its output, -1 for unused.
        status: 1 open, 2 closed.
        solenoids: 0 single, 1 double solenoid.
    """

    output: int
    status: int
    solenoids: int


def parse_hands(data: str) -> tuple[HandState, ...]:
    """Read the data of a HNDSTS reply.

    Raises:
        GarbledMessage: The data are not whole triples of numbers.
    """
    fields = data.removesuffix(";").split(";")
    try:
        numbers = [int(field) for field in fields]
    except ValueError as error:
        raise GarbledMessage(f"the hands read {data[:120]!r}") from error
    if len(numbers) % 3:
        raise GarbledMessage(f"the hands read {data[:120]!r}")
    return tuple([HandState(*numbers[i : i + 3]) for i in range(0, len(numbers), 3)])


def print_hands(hands: Sequence[HandState]) -> str:
    """Return the data of a HNDSTS reply."""
    return ";".join([f"{hand.output};{hand.status};{hand.solenoids}" for hand in hands])


class StopSources(NamedTuple):
    """Reply to STPSIG: who holds the arm (one source only).

    Attributes:
        stops: Stop signals: bits pendant, computer, input, panel from bit 0 up.
        emergencies: Emergency stops: bits input, panel, pendant from bit 0 up.
    """

    stops: int
    emergencies: int


def parse_stop_sources(data: str) -> StopSources:
    """Read the data of a STPSIG reply: two hexadecimal digits one character apart.

    Raises:
        GarbledMessage: The data have another layout.
    """
    try:
        return StopSources(int(data[0:1], 16), int(data[2:3], 16))
    except ValueError as error:
        raise GarbledMessage(f"the stop sources read {data[:80]!r}") from error


def print_stop_sources(sources: StopSources) -> str:
    """Return the data of a STPSIG reply."""
    return f"{sources.stops:X};{sources.emergencies:X}"


def _finite(field: str) -> float:
    number = float(field)
    if not math.isfinite(number):
        raise ValueError(field)
    return number


def _whole(field: str) -> int:
    if not (field.isascii() and field.isdigit() and len(field) <= 9):
        raise ValueError(field)
    return int(field)


def _flags(field: str) -> tuple[int, int] | None:
    if field in {"****,****", ""}:
        return None
    first, second = field.split(",")
    return int(first), int(second)


def _status(field: str) -> tuple[int, int, int]:
    """Return run status, stop status and error of the joined field `A1060`."""
    return int(field[0:2], 16), int(field[2:4], 16), _whole(field[4:])


def _hex_words(data: str, count: int) -> list[int]:
    try:
        if len(data) != 4 * count:
            raise ValueError(data)
        return [int(data[i : i + 4], 16) for i in range(0, len(data), 4)]
    except ValueError as error:
        raise GarbledMessage(f"the signals read {data[:80]!r}") from error


def _texts(fields: list[str]) -> tuple[str, str, str, str, str, str, str, str, str]:
    a, b, c, d, e, f, g, h, i = fields
    return a, b, c, d, e, f, g, h, i
