"""What can be wrong with any wire."""

from __future__ import annotations

from cell.doctor.findings import Cause

_GROUP = "Lines"

LINES: tuple[Cause, ...] = (
    Cause(
        id="port-missing",
        title="A serial port does not exist",
        group=_GROUP,
        rank=20,
        see="The device cannot be opened.",
        why="The USB adapter is not plugged in, or the system gave it another name.",
        fix="plug the adapter in, or enter the right port (better: its usb_serial) in the profile",
        found="The system has no port of that name or adapter number.",
    ),
    Cause(
        id="port-forbidden",
        title="A serial port may not be opened",
        group=_GROUP,
        rank=20,
        see="The device cannot be opened although its port is there.",
        why="The user is not in the group that owns serial ports.",
        fix="add the user to the port's group (on Linux mostly `dialout`), then log in again",
        found="Opening the port is refused for lack of rights.",
        undo="take the user out of the group",
    ),
    Cause(
        id="port-taken",
        title="Another program has a serial port",
        group=_GROUP,
        rank=20,
        see="The device cannot be opened although its port is there.",
        why="A terminal program, the maker's software or a second server holds it.",
        fix="close the other program",
        found="Opening the port exclusively fails; the program is named where the system tells.",
    ),
    Cause(
        id="tcp-refused",
        title="The arm controller is not reached over the network",
        group=_GROUP,
        rank=20,
        see="The arm cannot be opened.",
        why="The controller is off, its address is another, or its network option is off.",
        fix="check power, network cable and arm.tcp of the profile",
        found="A connection to the address is refused or not answered.",
    ),
    Cause(
        id="cable-out",
        title="A cable is out",
        group=_GROUP,
        rank=21,
        see="The device fails in the middle of work or cannot be opened.",
        why="A plug has come loose, at the adapter or at the device.",
        fix="plug the cable in at both ends and screw it down",
        found="The line itself breaks when it is used.",
    ),
    Cause(
        id="wrong-device-answers",
        title="Another device answers on a line",
        group=_GROUP,
        rank=22,
        see="The device seems to talk nonsense.",
        why="Two cables or two ports have changed places.",
        fix="exchange the two cables, or the two ports in the profile",
        found="What answers speaks the protocol of another device of the cell.",
        undo="exchange them again",
    ),
    Cause(
        id="line-garbage",
        title="A line carries garbage",
        group=_GROUP,
        rank=23,
        see="The device seems to talk nonsense.",
        why="Baud rate, parity or stop bits differ between device and profile, or the cable is "
        "damaged.",
        fix="set baud, parity and stop_bits of the profile to those of the device",
        found="Bytes come back to every question, and none of them is a message.",
        undo="put the old figures back",
    ),
    Cause(
        id="line-unreliable",
        title="A line loses or spoils answers",
        group=_GROUP,
        rank=75,
        see="Requests are repeated now and then; sometimes one fails.",
        why="A loose plug, a cable beside a motor cable, a missing ground, an overloaded adapter.",
        fix="fasten the plugs, lead the cable away from motor cables, try another adapter",
        found="Of several questions to the device some were answered and some were not.",
    ),
)
