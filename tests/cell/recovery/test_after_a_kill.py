"""A program killed in the middle of its work: the next one checks before it moves anything."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.errors import ResumeRefused
from cell.events import ArmHeld, ResumeChecked
from cell.geometry import JointPositions
from cell.links.base import Direction
from cell.manipulation import Deployment
from cell.twin_cell import TwinCell
from sessions.hosting import store_plan
from tests.sessions.fault_rig import PROFILE, SCRIPT, BoundedClock, Witness, starts_motion

ROOT = Path(__file__).parents[3]
DEADLINE_S = 60.0
WORK = (
    Deployment(slot=7, x_mm=650.0, y_mm=-105.0),
    Deployment(slot=8, x_mm=710.0, y_mm=-165.0),
)
LEFT = "cell: the program before was not ended in order"


def work_until_killed(folder: str, motions: int) -> None:
    """Lay blocks out; die by `SIGKILL` as a motion is on the wire. Runs in its own process."""
    import os

    count = 0

    def tap(link: str, direction: Direction, data: bytes) -> None:
        nonlocal count
        if direction == "to_device" and starts_motion(link, data):
            count += 1
            if count == motions:
                os.kill(os.getpid(), signal.SIGKILL)

    cell = assemble_twin(
        PROFILE,
        store_plan(SCRIPT),
        seed=3,
        clock=SimulatedClock(),
        state_folder=Path(folder),
        tap=tap,
    )
    cell.open()
    cell.lay_out(WORK)


def kill_in_the_middle(folder: Path, motions: int) -> None:
    code = (
        "import sys; from tests.cell.recovery.test_after_a_kill import work_until_killed; "
        "work_until_killed(sys.argv[1], int(sys.argv[2]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(folder), str(motions)],
        cwd=ROOT,
        timeout=DEADLINE_S,
        capture_output=True,
        check=False,
    )
    assert done.returncode == -signal.SIGKILL, done.stderr


@contextmanager
def next_program(folder: Path) -> Iterator[tuple[TwinCell, Witness]]:
    """The cell as the next program has it, and a witness of every byte on its wires."""
    clock = BoundedClock()
    witness = Witness(clock)

    def tap(link: str, direction: Direction, data: bytes) -> None:
        if direction == "to_device":
            witness.saw(link, data)

    cell = assemble_twin(
        PROFILE,
        store_plan(SCRIPT),
        seed=4,
        clock=clock,
        state_folder=folder,
        tap=tap,
        events=witness,
    )
    try:
        yield cell, witness
    finally:
        cell.dispose()


@pytest.mark.parametrize("motions", [7, 9, 13, 16, 18])
def test_the_next_program_checks_first_and_then_brings_every_block_home(
    tmp_path: Path, motions: int
) -> None:
    kill_in_the_middle(tmp_path, motions)
    with next_program(tmp_path) as (cell, witness):
        left = not cell.manipulator.is_table_clean()
        cell.open()
        opened = witness.motions
        assert [b.reason.startswith(LEFT) for b in witness.bodies if isinstance(b, ArmHeld)] == (
            [True] if left else []
        )
        cell.clean()
        (checked,) = [body for body in witness.bodies if isinstance(body, ResumeChecked)]
        assert checked.is_clear
        assert witness.wrong == []
        assert witness.motions > opened
        assert cell.manipulator.is_table_clean()


def turn_key(cell: TwinCell, now_s: float) -> None:
    cell.behind.controller.set_key_switch(now_s, is_automatic=False)


def press_emergency_stop(cell: TwinCell, now_s: float) -> None:
    cell.behind.controller.press_emergency_stop(now_s)


def hold_right(cell: TwinCell, now_s: float) -> None:
    cell.behind.controller.hold_right_by_panel(now_s, is_held=True)


def bend_beyond_limit(cell: TwinCell, now_s: float) -> None:
    world = cell.world
    world.restore(
        blocks=world.whereabouts(),
        joints_deg=(0.0, 0.0, 90.0, 0.0, 130.0, 0.0),
        opening_mm=world.opening_mm(now_s),
        held=None,
        outputs=dict(world.outputs),
        is_gripper_referenced=True,
    )


TROUBLES: dict[str, tuple[Callable[[TwinCell, float], None], str]] = {
    "key": (turn_key, "TEACH"),
    "emergency stop": (press_emergency_stop, "emergency stop"),
    "right": (hold_right, "operation right"),
    "limits": (bend_beyond_limit, "J5 stands at 130.0 deg"),
}


@pytest.mark.parametrize("trouble", TROUBLES)
def test_what_the_check_finds_after_a_kill_keeps_everything_still(
    tmp_path: Path, trouble: str
) -> None:
    kill_in_the_middle(tmp_path, 13)
    bring_about, words = TROUBLES[trouble]
    with next_program(tmp_path) as (cell, witness):
        cell.open()
        motions = witness.motions
        bring_about(cell, cell.clock.now_s())
        for move in (
            cell.clean,
            lambda: cell.lay_out(WORK),
            lambda: cell.move_to(650.0, -105.0, 150.0),
            lambda: cell.move_joints(JointPositions((10, 20, 100, 0, 60, 0))),
            lambda: cell.gripper.move_to(20.0),
        ):
            with pytest.raises(ResumeRefused, match=words):
                move()
        assert witness.motions == motions
        assert witness.wrong == []


def test_a_program_that_ended_in_order_leaves_nothing_to_tell_but_the_check(
    tmp_path: Path,
) -> None:
    with next_program(tmp_path) as (cell, _):
        cell.open()
        cell.lay_out(WORK)
        cell.clean()
    with next_program(tmp_path) as (cell, witness):
        cell.open()
        cell.clean()
        told = [body for body in witness.bodies if isinstance(body, ArmHeld | ResumeChecked)]
        assert [type(body) for body in told] == [ResumeChecked]
        cell.close()
        cell.open()
        cell.move_to(650.0, -105.0, 150.0)
        told = [body for body in witness.bodies if isinstance(body, ArmHeld | ResumeChecked)]
        assert [type(body) for body in told] == [ResumeChecked, ResumeChecked]
        assert witness.wrong == []
