from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cell.drivers.ssc32.driver import Ssc32Arm
from cell.drivers.ssc32.line import straight_line
from cell.errors import DeviceError, DeviceTimeout, Stopped, UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.links.memory import MemoryLink
from cell.twin.wire_faults import FaultyEmulator, WireFault
from tests.cell.drivers.ssc32.bench import (
    ABOVE,
    CHANNELS,
    CONTROLLER_SETTINGS,
    KINEMATICS,
    PROFILE,
    SETTINGS,
    LynxRig,
    confirmed,
    opened_rig,
)

HERE = KINEMATICS.forward(ABOVE)
REST = JointPositions(PROFILE.rest_deg)
THERE = Pose(HERE.x_mm - 50.0, HERE.y_mm + 90.0, HERE.z_mm + 15.0, 180.0, 0.0, HERE.c_deg + 20.0)


def _above_rig() -> LynxRig:
    rig = opened_rig()
    rig.arm.move_joints(ABOVE)
    rig.traffic.clear()
    rig.sent_s.clear()
    return rig


# The first pose


def test_an_unknown_pose_is_refused_until_somebody_confirms_the_first_one() -> None:
    rig = LynxRig(settings=confirmed())
    with pytest.raises(DeviceError, match=r"pose is unknown.*rest pose \(0.00, -60.00"):
        rig.arm.open()
    assert rig.moves == []
    rig.arm.confirm_first_pose()
    rig.arm.open()
    assert rig.arm.read_joints().values == pytest.approx(REST.values, abs=0.06)


def test_a_confirmation_holds_for_one_first_pose_only() -> None:
    rig = LynxRig(settings=confirmed())
    rig.arm.confirm_first_pose()
    rig.arm.open()
    rig.emulator.cut_power(rig.clock.now_s())
    rig.emulator.restore_power(rig.clock.now_s())
    rig.clock.sleep(1.0)
    with pytest.raises(DeviceError, match="pose is unknown"):
        rig.arm.open()


def test_the_first_pose_is_announced_before_anything_jumps() -> None:
    rig = LynxRig()
    rig.arm.open()
    assert any("in 5 s the joints jump" in text for text in rig.warnings)
    first_s = next(
        at_s for at_s, request in zip(rig.sent_s, rig.requests, strict=True) if "#" in request
    )
    assert first_s >= 5.0


def test_the_first_pose_is_taken_one_joint_after_the_other_lifting_before_turning() -> None:
    rig = LynxRig()
    rig.arm.open()
    assert [re.findall(r"#(\d+)P", move) for move in rig.moves] == [
        ["1"],
        ["2"],
        ["3"],
        ["5"],
        ["0"],
    ]
    moved_s = [s for s, request in zip(rig.sent_s, rig.requests, strict=True) if "#" in request]
    gaps_s = [b - a for a, b in zip(moved_s, moved_s[1:], strict=False)]
    assert min(gaps_s) >= SETTINGS.first_joint_s - 1e-9


def test_from_the_rest_pose_the_first_pose_hardly_moves_the_arm() -> None:
    rig = LynxRig()
    rig.arm.open()
    assert max(rig.bank.servos[channel].jumps_us[0] for channel in CHANNELS) < 1.0


def test_a_stop_while_the_first_pose_is_announced_keeps_the_arm_limp() -> None:
    rig = LynxRig()
    rig.token.stop("hand in the way")
    with pytest.raises(Stopped, match="hand in the way"):
        rig.arm.open()
    assert rig.moves == []


def test_a_controller_that_was_moved_before_is_taken_over_where_it_stands() -> None:
    first = _above_rig()
    other = LynxRig()
    other.link = MemoryLink("arm", first.emulator, first.clock)
    taken = Ssc32Arm(other.link, first.clock, confirmed(), KINEMATICS, on_warning=lambda text: None)
    before = first.pulses_us()
    taken.open()
    assert first.pulses_us() == before
    assert taken.read_joints().values == pytest.approx(ABOVE.values, abs=0.6)


def test_half_a_line_that_somebody_left_is_taken_back_before_anything_else() -> None:
    rig = LynxRig()
    rig.link.write(b"#0P2500")
    rig.arm.open()
    assert rig.bank.servos[0].jumps_us == [pytest.approx(0.0, abs=0.5)]


def test_a_firmware_that_does_not_know_escape_is_opened_all_the_same() -> None:
    rig = LynxRig()
    receive = rig.emulator.receive
    rig.emulator.receive = (  # type: ignore[method-assign]
        lambda data, now_s: receive(data.replace(b"\x1b", b"?"), now_s)
    )
    assert "SSC32" in rig.arm.open()


# Motion


def test_a_joint_move_is_one_group_that_keeps_every_joint_within_its_speed() -> None:
    rig = opened_rig()
    rig.traffic.clear()
    rig.arm.set_speed(50.0, 25.0)
    rig.arm.move_joints(ABOVE)
    (move,) = rig.moves
    time_s = int(move.rpartition("T")[2]) / 1000.0
    ways = [abs(b - a) for a, b in zip(REST.values, ABOVE.values, strict=True)]
    fastest = max(
        way / (0.25 * speed) for way, speed in zip(ways, KINEMATICS.joint_speed, strict=True)
    )
    assert time_s == pytest.approx(fastest, abs=0.02)


def test_a_straight_move_keeps_to_its_line_and_its_speed() -> None:
    rig = _above_rig()
    rig.arm.set_speed(40.0, 40.0)
    began_s = rig.clock.now_s()
    seen: list[tuple[float, float, float]] = []
    sleep = rig.clock.sleep

    def watching(duration_s: float) -> None:
        sleep(duration_s)
        joints = tuple(
            servo.map.position(pulse)
            for servo, pulse in zip(SETTINGS.servos, rig.pulses_us(), strict=True)
        )
        seen.append(KINEMATICS.link_points_mm(joints)[-1])

    rig.clock.sleep = watching  # type: ignore[method-assign]
    rig.arm.move(THERE, interpolation="linear", posture=0)
    start, end = (HERE.x_mm, HERE.y_mm, HERE.z_mm), (THERE.x_mm, THERE.y_mm, THERE.z_mm)
    length = math.dist(start, end)
    assert len(seen) > 40
    assert max(_beside(point, start, end) for point in seen) < 0.9
    assert rig.clock.now_s() - began_s == pytest.approx(length / 40.0, rel=0.15)
    joints = rig.arm.read_joints()
    assert joints.values == pytest.approx(KINEMATICS.solve(THERE, 0).values, abs=0.06)


def _beside(
    point: tuple[float, float, float],
    start: tuple[float, float, float],
    end: tuple[float, float, float],
) -> float:
    way = [b - a for a, b in zip(start, end, strict=True)]
    off = [p - a for p, a in zip(point, start, strict=True)]
    share = sum(w * o for w, o in zip(way, off, strict=True)) / sum(w * w for w in way)
    return math.dist(off, [share * w for w in way])


def test_the_controller_is_told_every_servos_greatest_speed() -> None:
    rig = _above_rig()
    rig.arm.move(THERE, interpolation="linear", posture=0)
    rig.arm.move_joints(REST)
    slopes = [abs(servo.us_per_unit) for servo in PROFILE.servos]
    for move in rig.moves:
        caps = [int(cap) for cap in re.findall(r"S(\d+)", move)]
        for cap, slope, speed in zip(caps, slopes, KINEMATICS.joint_speed, strict=True):
            assert slope * speed <= cap <= 1.05 * slope * speed + 1.0 / SETTINGS.segment_s


def test_a_servo_that_is_not_where_the_driver_thinks_goes_there_slowly() -> None:
    rig = _above_rig()
    # Somebody else turns the shoulder between the driver's question and its first order.
    receive = rig.emulator.receive
    speeds: list[float] = []

    def meddling(data: bytes, now_s: float) -> None:
        if data.startswith(b"#0P"):
            if not speeds:
                receive(b"#1P1200\r", now_s)
            receive(data, now_s)
            pulse, soon = (rig.emulator.pulse_us(1, now_s + t) for t in (0.0, 0.01))
            speeds.append(abs(soon - pulse) / 0.01)
        else:
            receive(data, now_s)

    rig.emulator.receive = meddling  # type: ignore[method-assign]
    near = Pose(HERE.x_mm - 5.0, HERE.y_mm, HERE.z_mm, 180.0, 0.0, HERE.c_deg)
    rig.arm.move(near, interpolation="linear", posture=0)
    assert 800.0 < max(speeds) < 1.05 * 90.0 * 10.0
    assert rig.arm.read_joints().values == pytest.approx(KINEMATICS.solve(near, 0).values, abs=0.06)


def test_segments_are_sent_in_step_with_the_clock() -> None:
    rig = _above_rig()
    rig.arm.move(THERE, interpolation="linear", posture=0)
    sent = [s for s, request in zip(rig.sent_s, rig.requests, strict=True) if "T" in request]
    gaps = [b - a for a, b in zip(sent, sent[1:], strict=False)]
    assert gaps == pytest.approx([SETTINGS.segment_s] * len(gaps), abs=1e-6)


def test_a_line_that_leaves_the_reach_in_between_is_refused_before_anything_is_sent() -> None:
    rig = opened_rig()
    # Both ends are in reach; halfway the tool would be nearer to the base than the arm folds.
    side = math.degrees(math.atan2(150.0, 40.0))
    rig.arm.move_joints(KINEMATICS.solve(Pose(40.0, -150.0, 60.0, 180.0, 0.0, -side), 0))
    other = Pose(40.0, 150.0, 60.0, 180.0, 0.0, side)
    KINEMATICS.solve(other, 0)
    rig.traffic.clear()
    with pytest.raises(DeviceError, match="linear move.*out of range"):
        rig.arm.move(other, interpolation="linear", posture=0)
    assert rig.moves == []


def test_a_stop_falls_between_two_segments_and_the_arm_stands() -> None:
    rig = _above_rig()
    began_s = rig.clock.now_s()
    sleep = rig.clock.sleep

    def stopping(duration_s: float) -> None:
        sleep(duration_s)
        if rig.clock.now_s() > began_s + 0.7:
            rig.token.stop("enough")

    rig.clock.sleep = stopping  # type: ignore[method-assign]
    with pytest.raises(Stopped, match="enough"):
        rig.arm.move(THERE, interpolation="linear", posture=0)
    assert rig.clock.now_s() - began_s < 0.7 + 3 * SETTINGS.segment_s
    standing = rig.pulses_us()
    sleep(1.0)
    assert rig.pulses_us() == standing
    rig.clock.sleep = sleep  # type: ignore[method-assign]
    rig.token.clear()
    rig.arm.move(THERE, interpolation="linear", posture=0)


@pytest.mark.parametrize("knows_stop", [True, False])
def test_a_stop_in_a_joint_move_holds_the_arm_on_its_way(knows_stop: bool) -> None:
    rig = LynxRig(
        settings=replace(SETTINGS, knows_stop=knows_stop),
        controller_settings=replace(CONTROLLER_SETTINGS, knows_stop=knows_stop),
    )
    rig.arm.open()
    rig.arm.set_speed(50.0, 10.0)
    sleep, began_s = rig.clock.sleep, rig.clock.now_s()

    def stopping(duration_s: float) -> None:
        sleep(duration_s)
        if rig.clock.now_s() > began_s + 1.0:
            rig.token.stop("enough")

    rig.clock.sleep = stopping  # type: ignore[method-assign]
    with pytest.raises(Stopped):
        rig.arm.move_joints(ABOVE)
    assert not rig.arm.read_state().is_moving
    here = rig.arm.read_joints().values
    assert here[1] == pytest.approx(-60.0 + 0.1 * 90.0 * 1.2, abs=4.0)


def test_a_stop_does_not_pulse_servos_that_have_no_pulses() -> None:
    rig = LynxRig()
    rig.say(b"#0P1500\r")
    rig.link.write(b"#0P2000T5000\r")
    rig.clock.sleep(1.0)
    rig.arm.stop()
    assert [bool(pulse) for pulse in rig.pulses_us()] == [True, False, False, False, False]


def test_power_lost_in_a_straight_move_is_noticed_and_ends_it() -> None:
    rig = _above_rig()
    sleep, began_s = rig.clock.sleep, rig.clock.now_s()

    def failing(duration_s: float) -> None:
        sleep(duration_s)
        if began_s + 0.5 < rig.clock.now_s() < began_s + 0.56:
            rig.emulator.cut_power(rig.clock.now_s())

    rig.clock.sleep = failing  # type: ignore[method-assign]
    with pytest.raises(DeviceTimeout, match="logic supply"):
        rig.arm.move(THERE, interpolation="linear", posture=0)
    assert rig.clock.now_s() - began_s < 0.5 + SETTINGS.watch_s + 3.0


def test_an_arm_out_of_service_is_told_to_open_again_and_does_not_jump() -> None:
    rig = _above_rig()
    rig.emulator.cut_power(rig.clock.now_s())
    rig.emulator.restore_power(rig.clock.now_s())
    rig.clock.sleep(1.0)
    with pytest.raises(DeviceError, match="sent no pulses to J1.*first move jumps"):
        rig.arm.move(THERE, interpolation="linear", posture=0)
    assert rig.moves == []


def test_an_order_lost_on_the_line_is_noticed_at_the_end() -> None:
    rig = opened_rig()
    receive = rig.emulator.receive

    def deaf(data: bytes, now_s: float) -> None:
        if not data.startswith(b"#"):
            receive(data, now_s)

    rig.emulator.receive = deaf  # type: ignore[method-assign]
    with pytest.raises(DeviceError, match="ended at.*instead of.*lost on the line"):
        rig.arm.move_joints(ABOVE)


def test_a_move_longer_than_the_controller_can_count_is_refused() -> None:
    rig = opened_rig()
    rig.arm.set_speed(50.0, 0.1)
    rig.traffic.clear()
    with pytest.raises(DeviceError, match="longer than the controller can count"):
        rig.arm.move_joints(ABOVE)
    assert rig.moves == []


@pytest.mark.parametrize(
    "fault", [WireFault.LOST, WireFault.CORRUPTED, WireFault.HALF, WireFault.GARBAGE]
)
@pytest.mark.parametrize("seed", range(8))
def test_a_broken_answer_never_moves_the_arm_elsewhere(fault: WireFault, seed: int) -> None:
    rig = _above_rig()
    faulty = FaultyEmulator(rig.emulator, seed=seed)
    link = MemoryLink("arm", faulty, rig.clock)
    arm = Ssc32Arm(link, rig.clock, SETTINGS, KINEMATICS, on_warning=lambda text: None)
    arm.open()
    faulty.inject(fault)
    try:
        arm.move_joints(REST)
    except DeviceError:
        faulty.clear()
        arm.move_joints(REST)
    assert arm.read_joints().values == pytest.approx(REST.values, abs=0.6)


@pytest.mark.parametrize("seed", range(60))
@pytest.mark.parametrize("is_linear", [True, False])
def test_a_bit_turned_over_in_an_answer_never_makes_the_arm_leap(
    seed: int, is_linear: bool
) -> None:
    rig = _above_rig()
    faulty = FaultyEmulator(rig.emulator, seed=seed)
    link = MemoryLink("arm", faulty, rig.clock)
    arm = Ssc32Arm(link, rig.clock, SETTINGS, KINEMATICS, on_warning=lambda text: None)
    arm.open()
    fastest = [0.0] * 5
    receive = rig.emulator.receive

    def watching(data: bytes, now_s: float) -> None:
        receive(data, now_s)
        for index, channel in enumerate(CHANNELS):
            here, soon = (rig.emulator.pulse_us(channel, now_s + t) for t in (0.0, 0.001))
            fastest[index] = max(fastest[index], abs(soon - here) / 0.001)

    rig.emulator.receive = watching  # type: ignore[method-assign]
    for _ in range(3):
        faulty.inject(WireFault.CORRUPTED)
    try:
        if is_linear:
            arm.move(THERE, interpolation="linear", posture=0)
        else:
            arm.move_joints(REST)
    except DeviceError:
        # Refusing is allowed, leaping is not.
        faulty.clear()
    for speed, servo, allowed in zip(fastest, PROFILE.servos, KINEMATICS.joint_speed, strict=True):
        in_deg_s = speed / abs(servo.us_per_unit)
        assert in_deg_s <= 1.05 * allowed + 4.0, f"seed {seed}"


def test_a_strange_answer_does_not_keep_a_moving_arm_from_being_stopped() -> None:
    rig = opened_rig()
    rig.link.write(b"#1P1800T3000\r")
    rig.clock.sleep(0.5)
    answers = iter((b".",))
    transmit = rig.emulator.transmit

    def lying(now_s: float) -> bytes:
        data = transmit(now_s)
        return next(answers, data) if data == b"+" else data

    rig.emulator.transmit = lying  # type: ignore[method-assign]
    rig.arm.stop()
    standing = rig.pulses_us()
    rig.clock.sleep(1.0)
    assert rig.pulses_us() == standing
    assert standing[1] < 1100.0


# What it tells


def test_commanded_angles_are_told_to_the_microsecond_though_the_controller_rounds() -> None:
    rig = opened_rig()
    target = JointPositions((12.3, -20.1, 30.2, 40.4, 5.1))
    rig.arm.move_joints(target)
    assert rig.arm.read_joints().values == pytest.approx(target.values, abs=0.06)


def test_offsets_of_the_profile_are_told_before_the_first_pulse() -> None:
    servos = (replace(SETTINGS.servos[0], offset_us=-30), *SETTINGS.servos[1:])
    rig = LynxRig(settings=replace(SETTINGS, servos=servos))
    rig.arm.open()
    assert rig.requests.index("#0PO-30") < rig.requests.index(rig.moves[1])
    assert rig.moves[0] == "#0PO-30"


def test_a_firmware_without_a_version_is_opened_all_the_same() -> None:
    rig = LynxRig()
    receive = rig.emulator.receive
    rig.emulator.receive = (  # type: ignore[method-assign]
        lambda data, now_s: receive(data.replace(b"VER\r", b"\r"), now_s)
    )
    assert "unknown version" in rig.arm.open()
    assert any("going on without the version" in text for text in rig.warnings)


def test_the_panel_reads_inputs_latches_and_volts() -> None:
    rig = opened_rig()
    rig.emulator.set_input("B", is_high=False)
    rig.emulator.set_input("C", is_high=False)
    rig.emulator.set_input("C", is_high=True)
    rig.emulator.set_volts("H", 3.3)
    panel = rig.arm.panel
    assert panel.inputs("ABC") == (True, False, True)
    assert panel.latched_inputs("ABC") == (True, False, False)
    assert panel.latched_inputs("ABC") == (True, False, True)
    assert panel.volts("AH") == pytest.approx((0.0, 3.3), abs=0.01)
    panel.put_byte(2, 0b1000_0001)
    assert [rig.emulator.output(channel) for channel in (16, 17, 23)] == [True, False, True]


# Straight lines


@settings(max_examples=60)
@given(
    st.floats(130.0, 230.0), st.floats(-50.0, 50.0), st.floats(20.0, 120.0),
    st.floats(130.0, 230.0), st.floats(-50.0, 50.0), st.floats(20.0, 120.0),
    st.floats(-60.0, 60.0), st.floats(-60.0, 60.0),
)  # fmt: skip
def test_a_line_with_the_gripper_down_stays_straight_and_down(
    r0: float, w0: float, z0: float, r1: float, w1: float, z1: float, c0: float, c1: float
) -> None:
    start, end = _down(r0, w0, z0, c0), _down(r1, w1, z1, c1)
    try:
        first = KINEMATICS.solve(start, 0)
        stances = straight_line(KINEMATICS, first, end, 0, step_mm=4.0, step_deg=2.0)
    except UnreachablePose as error:
        if error.what in {"J1", "J2", "J3", "J4", "J5", "reach"}:
            return
        raise
    a, b = (start.x_mm, start.y_mm, start.z_mm), (end.x_mm, end.y_mm, end.z_mm)
    previous = first
    for stance in stances:
        point = KINEMATICS.link_points_mm(stance.values)[-1]
        assert math.dist(a, b) < 1e-6 or _beside(point, a, b) < 1e-6
        assert sum(stance.values[1:4]) == pytest.approx(90.0, abs=1e-6)
        before = KINEMATICS.link_points_mm(previous.values)[-1]
        assert math.dist(before, point) <= 4.0 + 1e-6
        previous = stance
    assert KINEMATICS.forward(stances[-1]).x_mm == pytest.approx(end.x_mm)


def _down(reach_mm: float, direction_deg: float, z_mm: float, c_deg: float) -> Pose:
    heading = math.radians(direction_deg)
    x_mm, y_mm = reach_mm * math.cos(heading), reach_mm * math.sin(heading)
    return Pose(x_mm, y_mm, z_mm, 180.0, 0.0, c_deg)


def test_a_question_that_is_asked_again_is_told() -> None:
    rig = _above_rig()
    faulty = FaultyEmulator(rig.emulator)
    told: list[tuple[str, str]] = []
    arm = Ssc32Arm(
        MemoryLink("arm", faulty, rig.clock),
        rig.clock,
        SETTINGS,
        KINEMATICS,
        on_warning=lambda text: None,
        on_repeat=lambda device, problem: told.append((device, problem)),
    )
    faulty.inject(WireFault.LOST)
    assert arm.read_joints().values == pytest.approx(ABOVE.values, abs=0.6)
    assert len(told) == 1
    assert told[0][0] == "arm"
    assert "gave no answer to QP0QP1QP2QP3QP5" in told[0][1]
