"""What it costs to check a script and to run a task of it."""

from __future__ import annotations

import re
from collections.abc import Sequence

from benchmarks.measure import Result, median_s
from dsl.compiler import compile_script
from dsl.host import Placement
from dsl.interpreter import Task
from dsl.library import library_script
from dsl.parser import grammar
from dsl.program import Program

_LINES = 1000
_STEPS = 2000
_SEEDS = 200


def run() -> list[Result]:
    return [_checking(), _step(), _layout()]


def script_of(lines: int) -> str:
    """Return the shipped script, its tasks repeated under new names up to a number of lines."""
    shipped = library_script("mash")
    begin = shipped.index("\n# One lattice cell")
    store, tasks = shipped[:begin], shipped[begin:]
    names = sorted(set(re.findall(r"\b[A-Z][A-Z0-9x_]*\b|\bReachRedCube\b", tasks)), key=len)
    cameras = {name for name in names if name.startswith("CAMERA_")}
    pattern = re.compile(rf"\b({'|'.join(n for n in reversed(names) if n not in cameras)})\b")
    copies = [store]
    while "".join(copies).count("\n") < lines:
        copies.append(pattern.sub(rf"\g<1>_{len(copies)}", tasks))
    return "".join(copies)


def _checking() -> Result:
    text = script_of(_LINES)
    if compile_script(text, "benchmark").diagnostics:
        raise RuntimeError("the script of the benchmark has diagnostics")
    checked = median_s(lambda: compile_script(text, "benchmark"), repeat=11)
    parsed = median_s(lambda: grammar().parse(text), repeat=11)
    return Result(
        name=f"parse and check {text.count(chr(10))} lines",
        value=1e3 * checked,
        unit="ms",
        peer="lark alone, same text",
        peer_value=1e3 * parsed,
        target=200.0,
    )


class _NoHost:
    """Does nothing at once."""

    def show(self, picture: str) -> None:
        pass

    def lay_out(self, placements: Sequence[Placement]) -> None:
        pass

    def move_to(self, x: int, y: int, travel_mm: float) -> None:
        pass


def _shipped() -> Program:
    program = compile_script(library_script("mash"), "mash").program
    if program is None:
        raise RuntimeError("the shipped script has errors")
    return program


def _step() -> Result:
    host = _NoHost()
    task = Task(_shipped(), "ReachRedCube", "STATIC_12x12", 1, host)

    def steps() -> None:
        for _ in range(_STEPS // 2):
            task.act("RIGHT")
            task.act("LEFT")

    def bare() -> None:
        for _ in range(_STEPS):
            host.move_to(1, 0, 65.0)

    return Result(
        name="one step of a task, without a cell",
        value=1e6 * median_s(steps, repeat=11) / _STEPS,
        unit="µs",
        peer="calling the host",
        peer_value=1e6 * median_s(bare, repeat=11) / _STEPS,
        target=15.0,
    )


def _layout() -> Result:
    program, host = _shipped(), _NoHost()
    seeds = iter(range(10**9))

    def random_ones() -> None:
        for _ in range(_SEEDS):
            Task(program, "ReachRedCube.Random", "RANDOM_12x12", next(seeds), host)

    def fixed_ones() -> None:
        for _ in range(_SEEDS):
            Task(program, "ReachRedCube", "STATIC_12x12", 1, host)

    return Result(
        name="a random layout of 4 to 7 blocks",
        value=1e6 * median_s(random_ones, repeat=7) / _SEEDS,
        unit="µs",
        peer="a fixed layout",
        peer_value=1e6 * median_s(fixed_ones, repeat=7) / _SEEDS,
    )
