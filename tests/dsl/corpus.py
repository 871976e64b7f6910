"""The corpora of scripts, and what each is expected to yield."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from dsl.compiler import compile_script

SCRIPTS = Path(__file__).parents[1] / "scripts"
VALID = sorted((SCRIPTS / "valid").glob("*.cell"))
INVALID = sorted((SCRIPTS / "invalid").glob("*.cell"))
RENDERED = sorted((SCRIPTS / "rendered").glob("*.txt"))

_EXPECTATION = re.compile(r"# expect: ([EW]\d{3}) @(\d+)")

Findings = Counter[tuple[str, int]]


def expected(text: str) -> Findings:
    """Return code and line of every diagnostic that a script says it must yield."""
    return Counter((code, int(line)) for code, line in _EXPECTATION.findall(text))


def found(text: str) -> Findings:
    """Return code and line of every diagnostic that a script yields."""
    return Counter((d.code, d.span.line) for d in compile_script(text, "script").diagnostics)


def failure(text: str) -> str | None:
    """Say how a script of the invalid corpus fails its promise, or None."""
    wanted = expected(text)
    if not wanted:
        return "it expects nothing"
    yielded = found(text)
    if wanted != yielded:
        return f"expected {sorted(wanted.elements())}, found {sorted(yielded.elements())}"
    return None
