from __future__ import annotations

import subprocess
import sys

import pytest

from sessions.errors import LocalProtocolError
from sessions.wire.dialects import DIALECTS, dialect_named


def test_there_are_the_four_dialects_in_the_wild() -> None:
    assert list(DIALECTS) == ["1.2", "1.3", "1.4", "1.5"]
    assert [len(d.verbs) for d in DIALECTS.values()] == [11, 16, 17, 16]


def test_an_unknown_version_is_refused_with_the_known_ones() -> None:
    with pytest.raises(LocalProtocolError, match=r"1\.6.*1\.2, 1\.3, 1\.4, 1\.5"):
        dialect_named("1.6")


def test_the_wire_loads_no_sockets_and_no_cell() -> None:
    program = (
        "import sys, sessions.wire.commands, sessions.wire.incoming, sessions.wire.lines, "
        "sessions.wire.writing; "
        "print([m for m in ('socket', 'asyncio', 'cell', 'numpy', 'dsl') if m in sys.modules])"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60
    )

    assert loaded.stdout.strip() == "[]"
