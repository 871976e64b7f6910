"""Who the controller is: the data of OPEN."""

from __future__ import annotations

from typing import NamedTuple

from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.drivers.melfa_r3.fields import flags_field


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
            flags_field(flags),
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


def _texts(fields: list[str]) -> tuple[str, str, str, str, str, str, str, str, str]:
    a, b, c, d, e, f, g, h, i = fields
    return a, b, c, d, e, f, g, h, i
