"""The command line as a child process, and in this one."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]


def environment(home: Path) -> dict[str, str]:
    """Return an environment whose data and state are under `home`."""
    kept = {name: value for name, value in os.environ.items() if name in ("PATH", "LANG")}
    return {
        **kept,
        "HOME": str(home),
        "XDG_DATA_HOME": str(home / "data"),
        "XDG_STATE_HOME": str(home / "state"),
        "PYTHONPATH": str(REPOSITORY),
        "COLUMNS": "100",
    }


def command(words: Sequence[str]) -> list[str]:
    """Return the call of the command line with this interpreter."""
    code = "import sys; from console.cli import main; sys.exit(main())"
    return [sys.executable, "-W", "error", "-c", code, *words]


def run_cell(
    *words: str, home: Path, stdin: str = "", extra: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run `cell` in a process of its own and wait for its end."""
    return subprocess.run(
        command(words),
        env={**environment(home), **(extra or {})},
        input=stdin,
        capture_output=True,
        text=True,
        timeout=90,
        check=False,
    )
