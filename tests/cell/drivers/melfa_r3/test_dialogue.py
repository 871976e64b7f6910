from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.errors import DeviceError, DeviceTimeout, LinkError, MotionInterrupted
from cell.geometry import Pose
from cell.links.base import Link
from tests.contracts.arm.rig import ABOVE, ARM_SETTINGS, ArmRig, opened_rig

ONCE = replace(ARM_SETTINGS, attempts=1)
NEXT = Pose(530.0, -65.0, 98.0)
BROKEN = [b"?\r", b"QoKX;51", b"QoKX;1.0\r", b"QeR\r", b""]


def test_bytes_that_nobody_asked_for_are_dropped_before_a_request() -> None:
    rig = opened_rig()
    rig.controller.chatter(b"QoKX;1.00\r\x00Qo", rig.clock.now_s())
    assert rig.arm.read_pose() == ABOVE


def test_a_late_reply_is_not_taken_for_the_next_one() -> None:
    rig = opened_rig(ONCE)
    rig.controller.delay_next_reply(2.05)
    with pytest.raises(DeviceTimeout, match="gave no answer to OUT within 2 s"):
        rig.arm.read_output(8)
    assert rig.arm.read_pose() == ABOVE


def test_half_a_reply_is_a_timeout_that_shows_it() -> None:
    rig = opened_rig(ONCE)
    rig.controller.replace_next_reply(b"QoKX;51")
    with pytest.raises(DeviceTimeout, match="answered only b'QoKX;51'"):
        rig.arm.read_pose()
    assert rig.arm.read_pose() == ABOVE


@pytest.mark.parametrize("reply", [b"?\r", b"\xff\xfe\r", b"QoK\xb2;\r", b"QoKX;1.0\r", b"QeR\r"])
def test_a_garbled_reply_is_an_error_and_the_next_request_works(reply: bytes) -> None:
    rig = opened_rig(ONCE)
    rig.controller.replace_next_reply(reply)
    with pytest.raises(GarbledMessage, match="baud rate"):
        rig.arm.read_pose()
    assert rig.arm.read_pose() == ABOVE


def test_a_line_that_never_falls_silent_is_an_error() -> None:
    rig = opened_rig()
    for number in range(200):
        rig.controller.chatter(b"noise", rig.clock.now_s() + 0.01 * number)
    rig.controller.replace_next_reply(b"?\r")
    with pytest.raises(DeviceError):
        rig.arm.read_pose()
    with pytest.raises(DeviceError, match="does not fall silent"):
        rig.arm.read_pose()


def test_a_reply_in_pieces_is_put_together() -> None:
    rig = opened_rig()
    rig.controller.replace_next_reply(b"QoK00")
    rig.controller.chatter(b"01\r", rig.clock.now_s() + 1.0)
    assert rig.arm.read_output(8)


def test_stop_is_sent_at_once_even_after_a_missed_reply() -> None:
    rig = opened_rig()
    rig.controller.fall_silent(is_silent=True)
    with pytest.raises(DeviceTimeout):
        rig.arm.read_pose()
    rig.controller.fall_silent(is_silent=False)
    before_s = rig.clock.now_s()
    rig.arm.stop()
    assert rig.clock.now_s() - before_s < 0.02


@pytest.mark.parametrize("reply", BROKEN)
def test_a_question_whose_answer_is_broken_is_asked_again(reply: bytes) -> None:
    rig = opened_rig()
    rig.traffic.clear()
    rig.controller.replace_next_reply(reply)
    assert rig.arm.read_pose() == ABOVE
    assert rig.requests == ["PPOSF", "PPOSF"]
    assert len(rig.repeats) == 1


def test_a_question_is_asked_three_times_and_no_more() -> None:
    rig = opened_rig()
    rig.controller.fall_silent(is_silent=True)
    rig.traffic.clear()
    with pytest.raises(DeviceTimeout, match="gave no answer to PPOSF"):
        rig.arm.read_pose()
    assert rig.requests == ["PPOSF"] * 3
    assert len(rig.repeats) == 2


@pytest.mark.parametrize("reply", [b"?\r", b"QoK", b"QeR\r", b""])
def test_a_move_whose_answer_is_lost_is_not_started_twice(reply: bytes) -> None:
    rig = opened_rig()
    rig.arm.read_pose()
    replace_reply_to(rig, "EXECMVS", lambda: rig.controller.replace_next_reply(reply))
    rig.traffic.clear()
    rig.arm.move(NEXT, interpolation="linear", posture=7, expected_s=0.1)
    assert rig.requests.count("EXECMVS P1") == 1
    assert "the arm has started" in rig.repeats[0][1]
    assert rig.arm.read_pose() == NEXT


def test_a_move_that_the_controller_never_heard_is_sent_again() -> None:
    rig = opened_rig()
    rig.arm.read_pose()
    deafen_to(rig, "EXECMVS")
    rig.traffic.clear()
    rig.arm.move(NEXT, interpolation="linear", posture=7, expected_s=0.1)
    assert rig.requests.count("EXECMVS P1") == 2
    assert "the arm has not moved" in rig.repeats[0][1]
    assert rig.arm.read_pose() == NEXT


def test_a_move_stopped_by_hand_while_its_answer_was_lost_is_not_sent_again() -> None:
    rig = opened_rig()
    rig.arm.read_pose()

    def stop_soon() -> None:
        rig.controller.replace_next_reply(b"")
        press = rig.controller.press_stop_button
        act_at(rig, rig.clock.now_s() + 0.3, lambda: press(rig.clock.now_s()))

    replace_reply_to(rig, "EXECMVS", stop_soon)
    rig.traffic.clear()
    far = Pose(510.0, 235.0, 98.0)
    with pytest.raises(MotionInterrupted, match="without an alarm"):
        rig.arm.move(far, interpolation="linear", posture=7, expected_s=1.2)
    assert rig.requests.count("EXECMVS P1") == 1


def test_a_link_that_is_back_soon_is_only_a_repeat() -> None:
    rig = opened_rig()
    broken = BrokenFor(rig, 2)
    assert rig.arm.read_pose() == ABOVE
    assert broken.left == 0
    assert len(rig.repeats) == 2


class BrokenFor:
    """Breaks the rig's link for so many writes."""

    def __init__(self, rig: ArmRig, writes: int) -> None:
        self.left = writes
        write = rig.link.write

        def broken(data: bytes) -> None:
            if self.left:
                self.left -= 1
                raise LinkError("the cable is out")
            write(data)

        rig.link.write = broken  # type: ignore[method-assign]


def replace_reply_to(rig: ArmRig, request: str, act: Callable[[], None]) -> None:
    """Do something just before a request of that beginning is heard, once."""
    link: Link = rig.link
    write, done = link.write, list[bool]()

    def watched(data: bytes) -> None:
        if request.encode() in data and not done:
            done.append(True)
            act()
        write(data)

    rig.link.write = watched  # type: ignore[method-assign]


@pytest.mark.parametrize("leftovers", [b"1;1;STA", b"\x81\xfe\x00\x99", b"x" * 300])
def test_leftovers_in_the_controllers_line_cost_one_more_request_to_open(leftovers: bytes) -> None:
    rig = ArmRig()
    rig.link.write(leftovers)
    rig.arm.open()
    assert rig.requests[:2] == [f"OPEN={ARM_SETTINGS.client}"] * 2
    assert len(rig.repeats) == 1
    assert "its line held leftovers" in rig.repeats[0][1]


def test_a_controller_that_does_not_know_how_to_open_is_asked_twice_only() -> None:
    rig = ArmRig()
    write, count = rig.link.write, 0

    def unknowing(data: bytes) -> None:
        nonlocal count
        count += b"OPEN" in data
        rig.controller.replace_next_reply(b"QeR4200\r")
        write(data)

    rig.link.write = unknowing  # type: ignore[method-assign]
    with pytest.raises(DeviceError, match="refused OPEN"):
        rig.arm.open()
    assert count == 2


def test_a_clean_line_is_opened_with_one_request() -> None:
    rig = ArmRig()
    rig.arm.open()
    assert [request for request in rig.requests if request.startswith("OPEN")] == [
        f"OPEN={ARM_SETTINGS.client}"
    ]


def deafen_to(rig: ArmRig, request: str) -> None:
    """Lose a request of that beginning on the way, once."""
    write, done = rig.link.write, list[bool]()

    def deaf(data: bytes) -> None:
        if request.encode() in data and not done:
            done.append(True)
            return
        write(data)

    rig.link.write = deaf  # type: ignore[method-assign]


def act_at(rig: ArmRig, due_s: float, act: Callable[[], None]) -> None:
    """Do something at a moment of the simulated time."""
    sleep, clock, done = rig.clock.sleep, rig.clock, list[bool]()

    def hooked(duration_s: float) -> None:
        end_s = clock.now_s() + duration_s
        if not done and end_s >= due_s:
            done.append(True)
            sleep(due_s - clock.now_s())
            act()
        sleep(end_s - clock.now_s())

    rig.clock.sleep = hooked  # type: ignore[method-assign]
