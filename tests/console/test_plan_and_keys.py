from __future__ import annotations

import os
import pty
import termios

import pytest

from console.keys import raw_terminal, split_keys
from console.plan import Plan


@pytest.mark.parametrize(
    ("data", "keys"),
    [
        (b"\x1b[A\x1b[B\x1b[C\x1b[D", ["up", "down", "right", "left"]),
        (b"\x1bOA", ["up"]),
        (b"wasD", ["w", "a", "s", "d"]),
        (b"\x1b", ["q"]),
        (b"\x04", ["q"]),
        (b"v\x1b[Cr", ["v", "right", "r"]),
        (b"\xff", ["\xff"]),
    ],
)
def test_keys_are_read_from_what_terminals_send(data: bytes, keys: list[str]) -> None:
    assert split_keys(data) == keys


def test_the_terminal_is_put_back_whatever_happens() -> None:
    leader, follower = pty.openpty()
    try:
        before = termios.tcgetattr(follower)
        with pytest.raises(ZeroDivisionError):
            _fail_in_raw_terminal(follower)
        assert termios.tcgetattr(follower) == before
    finally:
        os.close(leader)
        os.close(follower)


def _fail_in_raw_terminal(descriptor: int) -> None:
    with raw_terminal(descriptor):
        flags = termios.tcgetattr(descriptor)[3]
        assert not flags & termios.ECHO
        assert not flags & termios.ICANON
        raise ZeroDivisionError


def test_the_plan_follows_moves_and_stops_at_walls() -> None:
    plan = Plan()
    plan.step("RIGHT", 0.0, "Robot move", "UP", "STATE_UPDATED")
    plan.step("UP", 0.0, "Robot move", "", "STATE_UPDATED")
    plan.step("UP", -10.0, "Robot hit the wall", "", "STATE_UPDATED")
    assert (plan.x, plan.y, plan.steps, plan.total) == (1, 1, 3, -10.0)
    assert plan.lines()[:4] == [". . . .", ". . @ .", ". o # .", ". . . ."]


def test_the_plan_starts_over() -> None:
    plan = Plan()
    plan.step("LEFT", 20.0, "Target reached", "", "FINISHED")
    assert "finished" in plan.lines()[-1]
    plan.start_over("UP")
    assert (plan.x, plan.y, plan.steps, plan.total, plan.suggestion) == (0, 0, 0, 0.0, "UP")
    assert plan.lines()[:3] == [". . .", ". @ .", ". . ."]


def test_a_long_way_keeps_the_arm_in_the_picture() -> None:
    plan = Plan()
    for _ in range(100):
        plan.step("RIGHT", 0.0, "", "", "STATE_UPDATED")
        plan.step("DOWN", 0.0, "", "", "STATE_UPDATED")
    drawing = plan.lines()[:-4]
    assert any("@" in line for line in drawing)
    assert len(drawing) <= 16
    assert max(map(len, drawing)) <= 64
