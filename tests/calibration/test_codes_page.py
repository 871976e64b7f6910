"""Every finding that a calibration may name stands in the reference."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
CODE = re.compile(r'\bcode="([a-z0-9-]+)"')


def test_every_named_finding_stands_in_the_reference() -> None:
    pages = "".join(p.read_text("utf-8") for p in (ROOT / "docs/reference").glob("*.md"))
    named = {
        (code, path.relative_to(ROOT).as_posix())
        for path in (ROOT / "calibration").rglob("*.py")
        for code in CODE.findall(path.read_text("utf-8"))
    }
    assert len(named) > 80
    assert sorted(f"{code} of {path}" for code, path in named if f"`{code}`" not in pages) == []
