"""Options that several commands have."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from cyclopts import Parameter

AsJson: TypeAlias = Annotated[
    bool, Parameter(name="--json", negative="", help="Write JSON for programs.")
]
ProfileName: TypeAlias = Annotated[
    str, Parameter(name="--profile", help="Name of a shipped profile, or the path of one.")
]
