"""Runs benchmarks and prints one table: `python -m benchmarks [NAME...] [--json]`."""

from __future__ import annotations

import importlib
import json
import os
import platform
import sys
from dataclasses import asdict
from pathlib import Path

import benchmarks
from benchmarks.measure import Result

_HEADINGS = ("benchmark", "figure", "unit", "beside", "is", "ratio", "target", "")


def main(arguments: list[str]) -> int:
    """Run the named benchmarks, or all; return the exit code."""
    as_json = "--json" in arguments
    wanted = [word for word in arguments if not word.startswith("-")]
    names = _names()
    unknown = [name for name in wanted if name not in names]
    if unknown or any(word.startswith("-") and word != "--json" for word in arguments):
        print(f"usage: python -m benchmarks [{' | '.join(names)}]... [--json]", file=sys.stderr)
        return 2
    results: dict[str, list[Result]] = {}
    for name in wanted or names:
        print(f"{name} ...", file=sys.stderr, flush=True)
        results[name] = list(importlib.import_module(f"benchmarks.{name}").run())
    print(_as_json(results) if as_json else _as_table(results))
    return 0


def _names() -> list[str]:
    """Return the modules beside this one that can be run; none is imported for it."""
    folder = Path(benchmarks.__path__[0])
    return sorted(path.stem for path in folder.glob("*.py") if "\ndef run(" in path.read_text())


def _machine() -> str:
    return f"Python {platform.python_version()}, {os.cpu_count()} cores, {platform.machine()}"


def _as_json(results: dict[str, list[Result]]) -> str:
    rows = [
        {"module": module, **asdict(result), "ratio": result.ratio, "is_met": result.is_met}
        for module, some in results.items()
        for result in some
    ]
    return json.dumps({"machine": _machine(), "results": rows}, indent=2)


def _as_table(results: dict[str, list[Result]]) -> str:
    rows = [_row(module, result) for module, some in results.items() for result in some]
    widths = [max(len(row[i]) for row in (_HEADINGS, *rows)) for i in range(len(_HEADINGS))]
    lines = [_line(_HEADINGS, widths), "  ".join("-" * width for width in widths)]
    lines += [_line(row, widths) for row in rows]
    return "\n".join([_machine(), "", *lines])


def _row(module: str, result: Result) -> tuple[str, ...]:
    target = "" if result.target is None else f"{result.target_is} {_figure(result.target)}"
    if target and result.of == "ratio":
        target += " x"
    return (
        f"{module}: {result.name}",
        _figure(result.value),
        result.unit,
        result.peer,
        "" if result.peer_value is None else _figure(result.peer_value),
        "" if result.ratio is None else f"{result.ratio:.3g}",
        target,
        {True: "met", False: "MISSED", None: ""}[result.is_met],
    )


def _line(cells: tuple[str, ...], widths: list[int]) -> str:
    padded = [
        cell.rjust(width) if column in (1, 4, 5) else cell.ljust(width)
        for column, (cell, width) in enumerate(zip(cells, widths, strict=True))
    ]
    return "  ".join(padded).rstrip()


def _figure(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
