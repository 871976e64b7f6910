"""The controller over TCP: packets without an end, and HC frames."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cell.clock import SimulatedClock
from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.drivers.melfa_r3.driver import MelfaArm
from cell.drivers.melfa_r3.ethernet import FramedLink, PacketLink
from cell.drivers.melfa_r3.hc_framing import Frame, FrameReader, encode_frame
from cell.errors import DeviceTimeout
from cell.geometry import Pose
from cell.links.base import Link
from cell.links.memory import MemoryLink
from cell.twin.emulators.melfa_r3 import MelfaController
from cell.twin.emulators.melfa_r3.ethernet import EthernetPort
from cell.twin.wire_faults import FaultyEmulator, WireFault
from tests.contracts.arm.rig import (
    ABOVE,
    ARM_SETTINGS,
    CONTROLLER_SETTINGS,
    KINEMATICS,
    PROFILE,
    FakeBody,
)

CNTLON = bytes.fromhex("0248433030303030303030305230303041313B313B434E544C4F4E304303")
"""The worked example of the reference: `1;1;CNTLON` as request number 0."""


def _rig(*, is_framed: bool) -> tuple[MelfaArm, FaultyEmulator, SimulatedClock]:
    clock = SimulatedClock()
    body = FakeBody(PROFILE.rest_deg)
    controller = MelfaController(body, KINEMATICS, CONTROLLER_SETTINGS)
    wire = FaultyEmulator(EthernetPort(controller))
    plain = MemoryLink("arm", wire, clock)
    link: Link = FramedLink(plain, clock) if is_framed else PacketLink(plain)
    arm = MelfaArm(link, clock, ARM_SETTINGS, on_warning=lambda text: None)
    return arm, wire, clock


def test_the_worked_example_is_encoded_and_read() -> None:
    frame = Frame(0, "R", "1;1;CNTLON")
    assert encode_frame(frame) == CNTLON
    assert FrameReader().feed(CNTLON) == [frame]


@given(st.text(alphabet=st.characters(max_codepoint=255), max_size=80), st.integers(0, 998),
       st.lists(st.integers(0, 120), max_size=6))  # fmt: skip
def test_frames_are_read_in_whatever_pieces_they_come(
    payload: str, sequence: int, cuts: list[int]
) -> None:
    frame = Frame(sequence, "S", payload)
    data = b"noise" + encode_frame(frame) * 2
    reader, found, start = FrameReader(), [], 0
    for end in [*sorted(cuts), len(data)]:
        found += reader.feed(data[start:end])
        start = max(start, end)
    assert found == [frame, frame]


@given(st.binary(max_size=60))
def test_no_bytes_upset_the_reader(data: bytes) -> None:
    reader = FrameReader()
    try:
        reader.feed(data)
    except GarbledMessage:
        assert reader.feed(CNTLON) == [Frame(0, "R", "1;1;CNTLON")]


@pytest.mark.parametrize("place", range(1, len(CNTLON)))
def test_a_changed_byte_gives_no_frame(place: int) -> None:
    data = bytearray(CNTLON)
    data[place] ^= 0x11
    found: list[Frame] = []
    with suppress(GarbledMessage):
        found = FrameReader().feed(bytes(data))
    assert found == []


@pytest.mark.parametrize("is_framed", [False, True])
def test_the_arm_opens_and_moves_over_the_network(is_framed: bool) -> None:
    arm, _, _ = _rig(is_framed=is_framed)
    assert "RV-6SDL" in arm.open()
    arm.move(ABOVE, interpolation="joint", posture=7, expected_s=1.5)
    arm.move(Pose(490.0, -65.0, 98.0), interpolation="linear", posture=7)
    assert arm.read_pose() == Pose(490.0, -65.0, 98.0)
    arm.close()


@pytest.mark.parametrize("is_framed", [False, True])
def test_a_lost_reply_is_asked_for_again(is_framed: bool) -> None:
    arm, wire, _ = _rig(is_framed=is_framed)
    arm.open()
    wire.inject(WireFault.LOST)
    assert not arm.read_state().is_moving


def test_a_damaged_frame_is_asked_for_again() -> None:
    arm, wire, _ = _rig(is_framed=True)
    arm.open()
    wire.inject(WireFault.CORRUPTED)
    assert arm.read_state().is_servo_on


def test_a_controller_without_frames_is_said() -> None:
    clock = SimulatedClock()
    controller = MelfaController(FakeBody(PROFILE.rest_deg), KINEMATICS, CONTROLLER_SETTINGS)
    link = FramedLink(MemoryLink("arm", controller, clock), clock)
    with pytest.raises(DeviceTimeout, match="framing to text"):
        link.write(b"1;1;STATE\r")


@pytest.mark.parametrize("end", [b"", b"\r", b"\r\n", b"\x00"])
def test_requests_end_as_their_senders_like(end: bytes) -> None:
    clock = SimulatedClock()
    controller = MelfaController(FakeBody(PROFILE.rest_deg), KINEMATICS, CONTROLLER_SETTINGS)
    link = MemoryLink("arm", EthernetPort(controller), clock)
    link.write(b"1;1;OPEN=X" + end)
    reply = link.read(1.0)
    assert reply.startswith(b"QoK3F;3F;")
    assert reply.endswith(b";")
