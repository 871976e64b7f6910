"""Options that several commands have."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from cyclopts import Parameter

Wires = Literal["memory", "pty", "hardware"]
"""How devices are reached; as `cell.assembly.wires`, which is heavy to import."""

AsJson: TypeAlias = Annotated[
    bool, Parameter(name="--json", negative="", help="Write JSON for programs.")
]
ProfileName: TypeAlias = Annotated[
    str, Parameter(name="--profile", help="Name of a shipped profile, or the path of one.")
]
TwinWiresOption: TypeAlias = Annotated[
    Literal["memory", "pty"],
    Parameter(name="--wires", help="How emulated devices are reached."),
]
WiresOption: TypeAlias = Annotated[
    Wires,
    Parameter(
        name="--wires",
        help="Emulated devices in memory or behind pseudo-terminals, or the profile's ports.",
    ),
]
