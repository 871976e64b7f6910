from collections.abc import Callable

import pytest

from cell.clock import SimulatedClock
from cell.drivers.sharp_aquos.driver import SharpDisplay
from cell.drivers.sharp_aquos.settings import SharpSettings
from cell.drivers.sharp_aquos.tables import AvMode, Permission, Word
from cell.errors import DeviceError, DeviceTimeout, LinkError
from cell.links.base import Direction
from cell.links.memory import MemoryLink
from cell.links.scripted import ScriptedLink
from cell.profile import load_profile
from cell.twin.emulators.sharp_aquos import SharpTelevision, SharpTelevisionSettings
from tests.cell.twin.emulators.sharp_aquos.bodies import BarePanel


class Bench:
    """Panel, set, wire and driver on one clock; everything said is kept."""

    def __init__(
        self,
        *,
        is_on: bool = True,
        set_up: SharpTelevisionSettings | None = None,
        settings: SharpSettings | None = None,
    ) -> None:
        self.clock = SimulatedClock()
        self.panel = BarePanel()
        self.television = SharpTelevision(
            self.panel, set_up or SharpTelevisionSettings(), is_on=is_on
        )
        self.warnings: list[str] = []
        self.link = MemoryLink("display", self.television, self.clock)
        self.display = SharpDisplay(
            self.link,
            self.clock,
            settings or SharpSettings(),
            on_warning=self.warnings.append,
        )


def test_opening_checks_the_link_and_says_who_is_there() -> None:
    assert Bench().display.open() == "Sharp AQUOS, model not told"
    told = SharpTelevisionSettings(identity=("AQUOS", "LC-40LE705", "1.0"))
    assert Bench(set_up=told).display.open() == "Sharp AQUOS AQUOS LC-40LE705 1.0"


def test_opening_leaves_a_set_in_standby_there() -> None:
    bench = Bench(is_on=False)
    bench.display.open()
    assert not bench.display.is_on()


def test_opening_says_that_the_driver_was_never_tried() -> None:
    bench = Bench()
    bench.display.open()
    bench.display.open()
    assert len(bench.warnings) == 1
    assert "never tried" in bench.warnings[0]


def test_opening_what_is_no_television_fails() -> None:
    link = ScriptedLink("display", [("to_device", b"A\r"), ("from_device", b"OK\r")])
    display = SharpDisplay(link, SimulatedClock(), SharpSettings())
    with pytest.raises(DeviceError, match="instead of ERR; is another device"):
        display.open()


def test_switching_on_waits_until_commands_are_taken() -> None:
    bench = Bench(is_on=False)
    bench.display.open()
    bench.display.switch_on()
    assert bench.clock.now_s() == pytest.approx(10.7, abs=0.7)
    assert bench.panel.is_lit
    bench.display.select_input(2)
    assert bench.panel.input_number == 2


def test_switching_on_what_is_on_is_quick() -> None:
    bench = Bench()
    bench.display.switch_on()
    assert bench.clock.now_s() < 1.0


def test_switching_on_a_set_that_shows_its_tuner_works() -> None:
    bench = Bench()
    bench.display.select_tuner()
    bench.display.switch_off()
    bench.display.switch_on()
    assert bench.panel.is_lit


def test_switching_off_keeps_the_way_back_open() -> None:
    bench = Bench(set_up=SharpTelevisionSettings(permission=Permission.NONE))
    bench.display.switch_off()
    assert not bench.panel.is_lit
    assert not bench.display.is_on()
    bench.display.switch_off()
    bench.display.switch_on()
    assert bench.display.is_on()


def test_a_set_that_may_not_be_switched_on_is_named_with_the_way_out() -> None:
    bench = Bench(is_on=False, set_up=SharpTelevisionSettings(permission=Permission.NONE))
    with pytest.raises(DeviceTimeout, match="switched on by hand once"):
        bench.display.switch_on()
    refusing: list[tuple[Direction, bytes]] = [
        ("to_device", b"POWR????\r"),
        ("from_device", b"0\r"),
    ]
    link = ScriptedLink(
        "display", [*refusing, ("to_device", b"POWR1   \r"), ("from_device", b"ERR\r")]
    )
    display = SharpDisplay(link, SimulatedClock(), SharpSettings())
    with pytest.raises(DeviceError, match="by hand once"):
        display.switch_on()


def test_a_set_that_never_gets_ready_is_a_time_out() -> None:
    bench = Bench(is_on=False, set_up=SharpTelevisionSettings(ready_after_s=1e6))
    with pytest.raises(DeviceTimeout, match="does not take commands 30 s after power on"):
        bench.display.switch_on()
    assert bench.clock.now_s() < 35.0


def test_everything_that_can_be_set_is_set() -> None:
    bench = Bench()
    display = bench.display
    display.set_volume(60)
    assert display.volume() == 60
    display.set_muted(is_muted=True)
    assert display.is_muted()
    display.set_muted(is_muted=False)
    assert not display.is_muted()
    display.set_av_mode(AvMode.GAME)
    display.set_view_mode(11)
    display.set_sleep_timer(90)
    display.select_input(3)
    assert display.selected_input() == 3
    display.next_input()
    assert display.selected_input() == 4
    display.set_number(Word.HORIZONTAL_POSITION, 180)
    display.set_number(Word.REMOTE_KEY, 36)
    assert display.selected_input() == 5
    display.permit_power_on(Permission.SERIAL)


def test_the_sleep_timer_takes_the_minutes_of_its_table() -> None:
    bench = Bench()
    bench.display.set_sleep_timer(30)
    bench.clock.sleep(1801.0)
    assert not bench.display.is_on()
    with pytest.raises(DeviceError, match="cannot sleep in 45 minutes; use one of 0, 30, 60"):
        bench.display.set_sleep_timer(45)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda d: d.set_volume(61), "volume cannot be 61; allowed is 0 to 60"),
        (lambda d: d.set_volume(-1), "allowed is 0 to 60"),
        (lambda d: d.set_view_mode(12), "view mode cannot be 12"),
        (lambda d: d.select_input(9), r"has no input 9; there are 1 \(HDMI 1\)"),
        (lambda d: d.set_number(Word.PHASE, 41), "phase cannot be 41"),
    ],
)
def test_a_value_out_of_range_sends_nothing(
    call: Callable[[SharpDisplay], None], message: str
) -> None:
    display = SharpDisplay(ScriptedLink("display", []), SimulatedClock(), SharpSettings())
    with pytest.raises(DeviceError, match=message):
        call(display)


def test_a_refusal_names_the_command_and_the_likely_causes() -> None:
    bench = Bench(is_on=False)
    with pytest.raises(DeviceError, match="refused 'VOLM3'; it is in standby"):
        bench.display.set_volume(3)
    with pytest.raises(DeviceError, match=r"refused 'IAVD\?\?\?\?'"):
        bench.display.selected_input()


def test_silence_is_a_time_out_that_names_the_likely_cause() -> None:
    bench = Bench()
    bench.television.go_silent()
    with pytest.raises(DeviceTimeout, match="no answer to 'A' within 1 s; is the set plugged in"):
        bench.display.open()
    # Three tries of 1 s, and twice a silence of 0.2 s before asking again.
    assert bench.clock.now_s() == pytest.approx(3.4, abs=0.01)


def test_channel_keys_may_stay_without_an_answer() -> None:
    bench = Bench()
    bench.display.select_tuner()
    bench.display.set_number(Word.CHANNEL_UP, 0)
    bench.television.go_silent()
    with pytest.raises(DeviceTimeout):
        bench.display.set_number(Word.SURROUND, 0)


def test_a_damaged_answer_is_asked_for_again() -> None:
    bench = Bench()
    bench.television.corrupt_next_reply()
    assert bench.display.volume() == 20


def test_what_does_more_when_sent_twice_is_sent_once() -> None:
    bench = Bench()
    bench.television.corrupt_next_reply()
    with pytest.raises(DeviceTimeout):
        bench.display.next_input()
    assert bench.panel.input_number == 2


def test_an_answer_that_comes_too_late_is_not_the_next_ones() -> None:
    slow = SharpTelevisionSettings(answer_s=1.5)
    bench = Bench(set_up=slow, settings=SharpSettings(attempts=1))
    with pytest.raises(DeviceTimeout):
        bench.display.volume()
    bench.clock.sleep(5.0)
    with pytest.raises(DeviceTimeout):
        bench.display.selected_input()


def test_an_ok_is_not_the_answer_to_a_question() -> None:
    traffic: list[tuple[Direction, bytes]] = [
        ("to_device", b"VOLM????\r"),
        ("from_device", b"OK\r"),
        ("from_device", b"12\r"),
    ]
    display = SharpDisplay(ScriptedLink("display", traffic), SimulatedClock(), SharpSettings())
    assert display.volume() == 12


def test_a_text_where_a_number_is_due_is_told() -> None:
    traffic: list[tuple[Direction, bytes]] = [
        ("to_device", b"VOLM????\r"),
        ("from_device", b"loud\r"),
    ]
    display = SharpDisplay(ScriptedLink("display", traffic), SimulatedClock(), SharpSettings())
    with pytest.raises(DeviceError, match=r"answered .*loud.* to 'VOLM"):
        display.volume()


def test_numbers_are_padded_as_the_settings_say() -> None:
    traffic: list[tuple[Direction, bytes]] = [
        ("to_device", b"VOLM030 \r"),
        ("from_device", b"OK\r"),
    ]
    link = ScriptedLink("display", traffic)
    settings = SharpSettings(padding="three digits")
    SharpDisplay(link, SimulatedClock(), settings).set_volume(30)
    assert link.is_exhausted


def test_closing_leaves_the_set_as_it_is_and_may_be_repeated() -> None:
    bench = Bench()
    bench.display.open()
    bench.display.close()
    bench.display.close()
    assert bench.television.is_on
    assert bench.display.open() == "Sharp AQUOS, model not told"


def test_a_link_that_is_gone_is_an_error_of_the_link() -> None:
    bench = Bench()
    bench.link.close()
    with pytest.raises(LinkError, match="closed"):
        bench.display.is_on()


def test_the_settings_come_from_the_profile() -> None:
    profile = load_profile("mash").display
    assert SharpSettings.from_profile(profile).inputs[1] == "HDMI 1"
    assert SharpTelevisionSettings.from_profile(profile).byte_s == pytest.approx(11 / 9600)
