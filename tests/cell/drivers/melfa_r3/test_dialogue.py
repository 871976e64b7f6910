from __future__ import annotations

import pytest

from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.errors import DeviceError, DeviceTimeout
from tests.contracts.arm.rig import ABOVE, opened_rig


def test_bytes_that_nobody_asked_for_are_dropped_before_a_request() -> None:
    rig = opened_rig()
    rig.controller.chatter(b"QoKX;1.00\r\x00Qo", rig.clock.now_s())
    assert rig.arm.read_pose() == ABOVE


def test_a_late_reply_is_not_taken_for_the_next_one() -> None:
    rig = opened_rig()
    rig.controller.delay_next_reply(2.05)
    with pytest.raises(DeviceTimeout, match="gave no answer to OUT within 2 s"):
        rig.arm.read_output(8)
    assert rig.arm.read_pose() == ABOVE


def test_half_a_reply_is_a_timeout_that_shows_it() -> None:
    rig = opened_rig()
    rig.controller.replace_next_reply(b"QoKX;51")
    with pytest.raises(DeviceTimeout, match="answered only b'QoKX;51'"):
        rig.arm.read_pose()
    assert rig.arm.read_pose() == ABOVE


@pytest.mark.parametrize("reply", [b"?\r", b"\xff\xfe\r", b"QoK\xb2;\r", b"QoKX;1.0\r", b"QeR\r"])
def test_a_garbled_reply_is_an_error_and_the_next_request_works(reply: bytes) -> None:
    rig = opened_rig()
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
