import pytest

from cell.drivers.sharp_aquos.tables import SCART_FIRST, THREE_HDMI, Permission
from cell.twin.emulators.sharp_aquos import SharpTelevision, SharpTelevisionSettings
from tests.cell.twin.emulators.sharp_aquos.bodies import BarePanel

SETTINGS = SharpTelevisionSettings()


class Bench:
    """A set on a bench: ask it, let time pass, hear what it says."""

    def __init__(self, settings: SharpTelevisionSettings = SETTINGS, *, is_on: bool = True) -> None:
        self.panel = BarePanel()
        self.television = SharpTelevision(self.panel, settings, is_on=is_on)
        self.now_s = 10.0

    def pass_time(self, duration_s: float) -> bytes:
        self.now_s += duration_s
        return self.television.transmit(self.now_s)

    def ask(self, line: str) -> bytes:
        """Send a line and return what comes back within a second."""
        self.television.receive(line.encode() + b"\r", self.now_s)
        return self.pass_time(1.0)


def test_the_link_check_is_answered_with_err() -> None:
    assert Bench().ask("A") == b"ERR\r"


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("POWR????", b"1\r"),
        ("RSPW????", b"1\r"),
        ("IAVD????", b"1\r"),
        ("VOLM????", b"20\r"),
        ("MUTE?   ", b"2\r"),
        ("AVMD????", b"1\r"),
        ("WIDE????", b"1\r"),
        ("OFTM????", b"0\r"),
        ("VOLM30  ", b"OK\r"),
        ("VOLM030 ", b"OK\r"),
        ("VOLM0030", b"OK\r"),
        ("  VOLM30", b"ERR\r"),
        ("VOLM61  ", b"ERR\r"),
        ("VOLM-1  ", b"ERR\r"),
        ("VOLM30", b"ERR\r"),
        ("VOLM30   ", b"ERR\r"),
        ("VOLMxx  ", b"ERR\r"),
        ("ABCD1   ", b"ERR\r"),
        ("", b"ERR\r"),
        ("IAVD8   ", b"OK\r"),
        ("IAVD9   ", b"ERR\r"),
        ("AVMD100 ", b"OK\r"),
        ("AVMD9   ", b"ERR\r"),
        ("WIDE11  ", b"OK\r"),
        ("WIDE12  ", b"ERR\r"),
        ("OFTM5   ", b"ERR\r"),
        ("ACSU2   ", b"OK\r"),
        ("ACHA0   ", b"OK\r"),
        ("HPOS180 ", b"OK\r"),
        ("PHSE41  ", b"ERR\r"),
        ("ITGD????", b"ERR\r"),
        ("DCCH5   ", b"ERR\r"),
        ("CHUP0   ", b"ERR\r"),
        ("RCKY38  ", b"OK\r"),
        ("RCKY50  ", b"ERR\r"),
        ("TVNM1   ", b"ERR\r"),
        ("MNRD1   ", b"ERR\r"),
    ],
)
def test_a_line_has_its_answer(line: str, answer: bytes) -> None:
    assert Bench().ask(line) == answer


def test_an_answer_takes_its_bytes_time_on_the_line() -> None:
    bench = Bench()
    bench.television.receive(b"VOLM30  \r", bench.now_s)
    expected_s = bench.now_s + (9 + 3) * SETTINGS.byte_s + SETTINGS.answer_s
    assert bench.television.next_output_s() == pytest.approx(expected_s)
    assert bench.television.transmit(expected_s - 1e-4) == b"OK"
    assert bench.television.transmit(expected_s + 1e-9) == b"\r"
    assert bench.television.next_output_s() is None


def test_standby_answers_power_and_its_permission_only() -> None:
    bench = Bench(is_on=False)
    assert bench.ask("POWR????") == b"0\r"
    assert bench.ask("RSPW1   ") == b"OK\r"
    assert bench.ask("VOLM30  ") == b"ERR\r"
    assert bench.ask("IAVD????") == b"ERR\r"


@pytest.mark.parametrize("permission", [Permission.NONE, Permission.NETWORK])
def test_standby_without_permission_is_silent(permission: Permission) -> None:
    bench = Bench(SharpTelevisionSettings(permission=permission), is_on=False)
    assert bench.ask("POWR1   ") == b""
    assert bench.ask("A") == b""
    assert not bench.television.is_on


def test_after_power_on_the_picture_comes_first_and_commands_later() -> None:
    bench = Bench(is_on=False)
    assert bench.ask("POWR1   ") == b"OK\r"
    assert bench.ask("POWR????") == b"1\r"
    assert bench.ask("IAVD2   ") == b"ERR\r"
    assert not bench.panel.is_lit
    bench.pass_time(2.0)
    assert bench.panel.changes == [(14.0, True, 1)]
    assert bench.ask("IAVD2   ") == b"ERR\r"
    bench.pass_time(6.0)
    assert bench.ask("IAVD2   ") == b"OK\r"
    assert bench.panel.input_number == 2


def test_power_off_darkens_the_panel_and_keeps_the_input() -> None:
    bench = Bench()
    bench.ask("IAVD3   ")
    assert bench.ask("POWR0   ") == b"OK\r"
    assert not bench.panel.is_lit
    bench.ask("POWR1   ")
    bench.pass_time(10.0)
    assert bench.ask("IAVD????") == b"3\r"


def test_power_commands_may_be_repeated() -> None:
    bench = Bench()
    assert bench.ask("POWR1   ") == b"OK\r"
    assert bench.ask("IAVD????") == b"1\r"
    bench.ask("POWR0   ")
    assert bench.ask("POWR0   ") == b"OK\r"


def test_inputs_that_the_set_does_not_have_are_refused() -> None:
    bench = Bench(SharpTelevisionSettings(inputs=THREE_HDMI))
    assert bench.ask("IAVD6   ") == b"OK\r"
    assert bench.ask("IAVD7   ") == b"ERR\r"
    assert Bench(SharpTelevisionSettings(inputs=SCART_FIRST)).ask("IAVD8   ") == b"OK\r"


def test_the_next_input_wraps_around() -> None:
    bench = Bench(SharpTelevisionSettings(inputs=THREE_HDMI))
    for expected in (2, 3, 4, 5, 6, 1):
        assert bench.ask("ITGD0   ") == b"OK\r"
        assert bench.panel.input_number == expected


def test_on_the_tuner_there_is_no_input_but_there_are_channels() -> None:
    bench = Bench()
    assert bench.ask("ITVD0   ") == b"OK\r"
    assert bench.ask("IAVD????") == b"ERR\r"
    assert bench.ask("DCCH5   ") == b"OK\r"
    assert bench.ask("CHUP0   ") == b""
    assert bench.ask("DCCH????") == b"6\r"
    talkative = Bench(SharpTelevisionSettings(is_channel_silent=False))
    talkative.ask("ITVD0   ")
    assert talkative.ask("CHDW0   ") == b"OK\r"


def test_mute_and_av_mode_toggle() -> None:
    bench = Bench()
    bench.ask("MUTE0   ")
    assert bench.ask("MUTE????") == b"1\r"
    bench.ask("MUTE0   ")
    assert bench.ask("MUTE????") == b"2\r"
    bench.ask("AVMD8   ")
    bench.ask("AVMD0   ")
    assert bench.ask("AVMD????") == b"1\r"


def test_the_sleep_timer_switches_off_in_its_time() -> None:
    bench = Bench()
    bench.ask("OFTM1   ")
    bench.pass_time(29 * 60.0)
    assert bench.television.is_on
    bench.pass_time(61.0)
    assert not bench.television.is_on
    assert bench.panel.changes[-1] == (10.0 + 1800.0, False, 1)


def test_the_sleep_timer_can_be_taken_back() -> None:
    bench = Bench()
    bench.ask("OFTM1   ")
    bench.ask("OFTM0   ")
    bench.pass_time(7200.0)
    assert bench.television.is_on


def test_remote_keys_switch_off_and_change_the_input() -> None:
    bench = Bench()
    assert bench.ask("RCKY36  ") == b"OK\r"
    assert bench.panel.input_number == 2
    assert bench.ask("RCKY12  ") == b"OK\r"
    assert not bench.television.is_on


def test_a_set_that_tells_who_it_is_does_so() -> None:
    bench = Bench(SharpTelevisionSettings(identity=("AQUOS", "LC-40LE705", "1.0")))
    assert bench.ask("TVNM1   ") == b"AQUOS\r"
    assert bench.ask("MNRD1   ") == b"LC-40LE705\r"
    assert bench.ask("SWVN1   ") == b"1.0\r"


def test_an_unplugged_set_needs_a_hand_on_its_key() -> None:
    bench = Bench()
    bench.television.unplug(bench.now_s)
    assert bench.ask("POWR1   ") == b""
    bench.television.press_power(bench.now_s)
    bench.pass_time(10.0)
    assert bench.ask("POWR????") == b"1\r"
    bench.television.press_power(bench.now_s)
    assert not bench.panel.is_lit


def test_a_corrupted_answer_and_a_cut_wire_can_be_ordered() -> None:
    bench = Bench()
    bench.television.corrupt_next_reply()
    assert bench.ask("VOLM1   ") == b"\xcfK\r"
    bench.television.go_silent()
    assert bench.ask("VOLM1   ") == b""
    bench.television.speak_again()
    assert bench.ask("VOLM1   ") == b"OK\r"
