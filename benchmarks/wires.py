"""What pseudo-terminals cost: steps of a task and exchanges with the arm, beside memory.

Both cells do the same on a simulated clock; only the wires differ. The pseudo-terminal is
opened by pyserial, and every byte passes through the kernel twice for each exchange.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from benchmarks.measure import Result, interleaved_s
from cell.assembly.wires import TwinWires
from cell.clock import SimulatedClock
from cell.profile import load_profile, profile_text
from cell.twin_cell import TwinCell
from dsl.library import library_script
from sessions.hosting import Hosted, host_twin
from sessions.script_source import served_script
from sessions.session import Session
from sessions.wire.dialects import DIALECTS

TO_READY = (b"INITIALIZE_TASK ReachRedCube STATIC_12x12", b"BEGIN_TASK_SETUP", b"END_TASK_SETUP")
BLOCKS = 12
STEPS = 100
QUESTIONS = 200


def run() -> list[Result]:
    with ExitStack() as stack:
        memory, pty = (_hosted(stack, wires) for wires in ("memory", "pty"))
        questions = interleaved_s(
            pty.cell.arm.arm.read_state,
            memory.cell.arm.arm.read_state,
            repeat=BLOCKS,
            number=QUESTIONS,
        )
        steps = interleaved_s(_stepper(memory), _stepper(pty), repeat=BLOCKS, number=STEPS)
        return [
            Result(
                name="actions of a task over pseudo-terminals, no socket, no views",
                value=1.0 / steps[1],
                unit="1/s",
                peer="in memory",
                peer_value=1.0 / steps[0],
            ),
            Result(
                name="read_state of the arm over a pseudo-terminal",
                value=questions[0] * 1e6,
                unit="us",
                peer="in memory",
                peer_value=questions[1] * 1e6,
            ),
        ]


def _hosted(stack: ExitStack, wires: TwinWires) -> Hosted[TwinCell]:
    hosted = host_twin(
        served_script(library_script("mash"), "mash.cell"),
        load_profile("mash"),
        profile_text("mash"),
        seed=1,
        clock=SimulatedClock(),
        wires=wires,
    )
    stack.callback(hosted.close)
    hosted.cell.open()
    return hosted


def _stepper(hosted: Hosted[TwinCell]) -> Callable[[], object]:
    """Return what takes one step of a task that is ready, back and forth by turns."""
    session = Session(hosted.desk, DIALECTS["1.5"], "benchmark")
    for line in TO_READY:
        session.handle(line)
    ways = [b"ACTION RIGHT", b"ACTION LEFT"]

    def step() -> object:
        ways.reverse()
        return session.handle(ways[0])

    return step
