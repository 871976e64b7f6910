from __future__ import annotations

import random
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cell.drivers.ssc32.servo_map import LinearServoMap
from cell.twin.emulators.ssc32 import (
    ServoBank,
    ServoErrors,
    Ssc32Controller,
    Ssc32ControllerSettings,
    TwinServo,
)
from tests.cell.drivers.ssc32.bench import CONTROLLER_SETTINGS, PROFILE

SETTINGS = Ssc32ControllerSettings()


def _servo() -> TwinServo:
    return TwinServo(LinearServoMap(centre_us=1500.0, us_per_unit=10.0), ServoErrors())


class Wire:
    """A controller with two servos, spoken to at chosen times."""

    def __init__(self, own: Ssc32ControllerSettings = SETTINGS) -> None:
        self.servos = {0: _servo(), 1: _servo()}
        self.controller = Ssc32Controller(ServoBank(self.servos), own)

    def say(self, data: bytes, now_s: float) -> bytes:
        self.controller.receive(data, now_s)
        return self.controller.transmit(now_s + 0.1)

    def pulses(self, now_s: float) -> tuple[float, float]:
        return self.controller.pulse_us(0, now_s), self.controller.pulse_us(1, now_s)


def test_the_worked_examples_answer_as_the_reference_says() -> None:
    wire = Wire()
    assert wire.say(b"#5P1500\r", 0.0) == b""
    assert wire.say(bytes.fromhex("23 35 50 31 35 30 30 53 37 35 30 0D"), 1.0) == b""
    assert wire.say(bytes.fromhex("51 0D"), 2.0) == b"."
    assert wire.say(bytes.fromhex("51 50 20 35 0D"), 3.0) == b"\x96"
    wire.say(b"#0P1500#1P1500\r", 4.0)
    wire.say(bytes.fromhex("23 30 50 31 36 30 30 23 31 50 37 35 30 54 32 35 30 30 0D"), 5.0)
    assert wire.say(b"Q\r", 7.4) == b"+"
    assert wire.say(b"Q\r", 7.6) == b"."
    assert wire.say(b"QP0QP1\r", 8.0) == bytes((160, 75))


def test_before_the_first_move_every_pulse_is_zero() -> None:
    everything = b"".join(b"QP%d" % channel for channel in range(32)) + b"\r"
    assert Wire().say(everything, 0.0) == bytes(32)


def test_the_first_move_ignores_speed_and_time_and_jumps() -> None:
    wire = Wire()
    wire.say(b"#0P2000S10T9000\r", 0.0)
    assert wire.pulses(0.0)[0] == 2000.0
    assert wire.say(b"Q\r", 0.1) == b"."
    assert wire.servos[0].jumps_us == [500.0]


def test_a_timed_move_goes_evenly_and_all_arrive_together() -> None:
    wire = Wire()
    wire.say(b"#0P1500#1P1500\r", 0.0)
    wire.say(b"#0P1700#1P1000T1000\r", 1.0)
    assert wire.pulses(1.5) == pytest.approx((1600.0, 1250.0))
    assert wire.pulses(2.0) == (1700.0, 1000.0)


def test_the_slowest_servos_speed_decides_the_whole_group() -> None:
    wire = Wire()
    wire.say(b"#0P1500#1P1500\r", 0.0)
    wire.say(b"#0P1600S100#1P1600S1000T200\r", 1.0)
    assert wire.pulses(1.5) == pytest.approx((1550.0, 1550.0))
    assert wire.say(b"Q\r", 1.9) == b"+"
    assert wire.say(b"Q\r", 2.1) == b"."


def test_a_speed_of_zero_or_none_is_full_speed() -> None:
    wire = Wire()
    wire.say(b"#0P1500#1P1500\r", 0.0)
    wire.say(b"#0P2500S0\r#1P500\r", 1.0)
    assert wire.pulses(1.0) == (2500.0, 500.0)
    # The shaft follows no faster than a servo can: 1000 us at 4000 us/s.
    assert wire.servos[0].truth(1.1) == pytest.approx(40.0)
    assert wire.servos[1].truth(1.1) == pytest.approx(-40.0)
    assert wire.servos[0].truth(1.25) == pytest.approx(100.0)


def test_a_new_move_starts_where_the_old_one_has_come_to() -> None:
    wire = Wire()
    wire.say(b"#0P1500\r", 0.0)
    wire.say(b"#0P2500T1000\r", 1.0)
    wire.say(b"#0P1500T1000\r", 1.5)
    assert wire.pulses(1.5)[0] == pytest.approx(2000.0)
    assert wire.pulses(2.0)[0] == pytest.approx(1750.0)


@pytest.mark.parametrize("knows_stop", [True, False])
def test_stop_holds_a_servo_on_its_way_where_the_firmware_knows_it(knows_stop: bool) -> None:
    wire = Wire(replace(SETTINGS, knows_stop=knows_stop))
    wire.say(b"#0P1500\r", 0.0)
    wire.say(b"#0P2500T1000\r", 1.0)
    assert wire.say(b"STOP0\r", 1.5) == b""
    assert wire.pulses(3.0)[0] == pytest.approx(2000.0 if knows_stop else 2500.0)


def test_answers_take_the_latency_and_the_time_of_their_bytes() -> None:
    wire = Wire()
    wire.controller.receive(b"Q\r", 1.0)
    due_s = wire.controller.next_output_s()
    assert due_s == pytest.approx(1.0 + 3 * SETTINGS.byte_s + SETTINGS.latency_s)
    assert wire.controller.transmit(1.0005) == b""
    assert wire.controller.transmit(1.01) == b"."
    assert wire.controller.next_output_s() is None


def test_what_is_unknown_or_out_of_range_is_passed_over_as_a_whole() -> None:
    wire = Wire()
    for line in (b"#0P1500#1P9999\r", b"HELLO\r", b"\r", b"#0P1500T99999\r", b"\xff\x00#\r"):
        assert wire.say(line, 0.0) == b""
    assert wire.pulses(1.0) == (0.0, 0.0)
    assert wire.say(b"Q\r", 2.0) == b"."


def test_an_offset_turns_the_shaft_and_is_not_told() -> None:
    wire = Wire()
    wire.say(b"#0P1500\r", 0.0)
    wire.say(b"#0PO50\r", 1.0)
    assert wire.say(b"QP0\r", 2.0) == b"\x96"
    assert wire.servos[0].truth(3.0) == pytest.approx(5.0)


def test_outputs_and_banks_switch_and_take_a_servos_pulses() -> None:
    wire = Wire()
    wire.say(b"#1P1500\r", 0.0)
    wire.say(b"#1H#9H#10L\r", 1.0)
    assert [wire.controller.output(c) for c in (1, 9, 10, 11)] == [True, True, False, None]
    assert wire.say(b"QP1\r", 2.0) == b"\x00"
    wire.say(b"#3:129\r", 3.0)
    assert [wire.controller.output(c) for c in (24, 25, 31)] == [True, False, True]
    wire.say(b"#1P1500\r", 4.0)
    assert wire.controller.output(1) is None


def test_inputs_latches_and_volts() -> None:
    wire = Wire()
    wire.controller.set_input("A", is_high=False)
    wire.controller.set_input("F", is_high=False)
    wire.controller.set_input("F", is_high=True)
    wire.controller.set_volts("B", 2.5)
    assert wire.say(b"A B F\r", 0.0) == b"011"
    assert wire.say(b"alflbl\r", 1.0) == b"001"
    assert wire.say(b"AL FL\r", 2.0) == b"01"
    assert wire.say(b"VAVB\r", 3.0) == bytes((0, 128))


def test_the_version_is_a_line() -> None:
    assert Wire().say(b"ver\r", 0.0) == b"SSC32-V2.01XE\r"


def test_losing_power_forgets_everything_and_starting_takes_its_time() -> None:
    wire = Wire()
    wire.say(b"#0P2000\r#9H\r", 0.0)
    wire.controller.receive(b"VER\r#1P15", 1.0)
    wire.controller.cut_power(1.0)
    assert wire.controller.transmit(1.5) == b""
    assert wire.say(b"Q\r", 2.0) == b""
    wire.controller.restore_power(3.0)
    assert wire.say(b"Q\r", 3.1) == b""
    assert wire.say(b"00\rQP0QP1\r", 4.0) == bytes(2)
    assert wire.controller.output(9) is None


def test_losing_the_servo_supply_is_not_noticed_by_the_controller_but_by_the_arm() -> None:
    wire = Wire()
    wire.say(b"#0P2000\r", 0.0)
    wire.controller.switch_servo_supply(1.0, is_on=False)
    assert wire.say(b"QP0\r", 2.0) == bytes((200,))
    assert wire.servos[0].truth(2.0) == pytest.approx(0.0)
    wire.controller.switch_servo_supply(3.0, is_on=True)
    assert wire.servos[0].truth(4.0) == pytest.approx(50.0)


@given(
    st.lists(st.tuples(st.binary(max_size=40), st.floats(0.0, 2.0)), max_size=30),
    st.booleans(),
)
@settings(max_examples=300)
def test_any_bytes_at_any_time_neither_raise_nor_hang(
    pieces: list[tuple[bytes, float]], is_cut: bool
) -> None:
    wire = Wire()
    now_s = 0.0
    for data, pause_s in pieces:
        wire.controller.receive(data, now_s)
        now_s += pause_s
        wire.controller.transmit(now_s)
        due_s = wire.controller.next_output_s()
        assert due_s is None or due_s > now_s
    if is_cut:
        wire.controller.cut_power(now_s)
        wire.controller.restore_power(now_s)
        now_s += 1.0
    wire.controller.receive(b"\x1b", now_s)
    wire.controller.transmit(now_s + 10.0)
    assert wire.say(b"Q\r", now_s + 20.0) in (b".", b"+")


_WORDS = (
    b"#0", b"#1", b"#31", b"#32", b"P1500", b"P500", b"P2500", b"P9", b"S0", b"S100", b"T0",
    b"T500", b"T65535", b"PO5", b"H", b"L", b":255", b"Q", b"QP0", b"QP1", b"VER", b"A", b"AL",
    b"VA", b"STOP0", b"\x1b", b"\r", b"\r", b"\r", b" ", b"\t", b"\n", b"\xff",
)  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_words_in_any_order_keep_every_pulse_a_pulse(seed: int) -> None:
    source = random.Random(seed)
    wire = Wire()
    now_s = 0.0
    for _ in range(400):
        wire.controller.receive(source.choice(_WORDS), now_s)
        now_s += source.uniform(0.0, 0.2)
        for pulse in wire.pulses(now_s):
            assert pulse == 0.0 or 500.0 <= pulse <= 2500.0, f"seed {seed}"
        for servo in wire.servos.values():
            assert -110.0 <= servo.truth(now_s) <= 110.0, f"seed {seed}"
    wire.controller.transmit(now_s + 100.0)
    assert wire.say(b"\x1bQ\r", now_s + 200.0) in (b".", b"+")


@given(st.binary(max_size=200), st.lists(st.integers(1, 5), max_size=60))
def test_how_bytes_are_cut_into_pieces_changes_nothing(data: bytes, sizes: list[int]) -> None:
    whole, cut = Wire(), Wire()
    one = whole.say(data, 0.0)
    position = 0
    for size in sizes:
        cut.controller.receive(data[position : position + size], 0.0)
        position += size
    cut.controller.receive(data[position:], 0.0)
    assert cut.controller.transmit(0.1) == one
    assert cut.pulses(0.0) == whole.pulses(0.0)


def test_the_profile_says_how_fast_bytes_travel() -> None:
    assert CONTROLLER_SETTINGS.byte_s == pytest.approx(10 / 115200)
    serial = PROFILE.serial.model_copy(update={"baud": 9600, "stop_bits": 2})
    slow = Ssc32ControllerSettings.from_profile(PROFILE.model_copy(update={"serial": serial}))
    assert slow.byte_s == pytest.approx(11 / 9600)
