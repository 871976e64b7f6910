"""Where the arm is: the data of PPOSF, JPOSF and their one-axis forms."""

from __future__ import annotations

import math
from typing import NamedTuple

from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.drivers.melfa_r3.fields import finite_field, flags_field
from cell.geometry import JointPositions, Pose

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
            names, values, flags_field(flags), int(override), finite_field(speed), int(mask, 16)
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


def joints_of(report: AxisReport) -> JointPositions:
    """Return the joint angles that a JPOSF reply gives.

    Raises:
        GarbledMessage: A joint is missing or has no value.
    """
    angles = tuple([value for value in report.values if value is not None])
    if report.names == JOINTS and len(angles) == len(JOINTS):
        return JointPositions(angles)
    raise GarbledMessage(f"the joints are {report.names} with values {report.values}")
