"""The watchdog hands screen and cameras to a check of calibrations, and files what it tells."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cell.errors import DeviceError
from cell.pictures import HEIGHT_PX, WIDTH_PX
from cell.profile import Profile, load_profile
from cell.twin.screen import PageFault, TwinScreen
from cell.watchdog import CalibrationWord, Sight, Watchdog
from tests.cell.watchdog.rig import Rig

HOLDS = CalibrationWord(verdict="holds", text="camera top is 0.02 mm off")
MOVED = CalibrationWord(
    verdict="moved", text="camera top is 2.10 mm off", hint="calibrate again: cell calibrate screen"
)
MOVED_MORE = CalibrationWord(
    verdict="moved", text="camera top is 3.47 mm off", hint="calibrate again: cell calibrate screen"
)
CANNOT_TELL = CalibrationWord(verdict="cannot tell", text="too few dots")
PATTERN = np.full((HEIGHT_PX, WIDTH_PX, 3), 90, np.uint8)


class Check:
    """Looks once, and tells what the test wants."""

    def __init__(self, word: CalibrationWord) -> None:
        self.word = word
        self.between: Callable[[], None] = lambda: None
        self.looks = 0

    def is_due(self) -> bool:
        return True

    def look(self, sight: Sight) -> CalibrationWord:
        sight.show_pixels(PATTERN, "dots")
        assert sight.grab("top").pixels.shape == (960, 1280, 3)
        self.between()
        sight.grab("top")
        self.looks += 1
        return self.word


def one_camera() -> Profile:
    profile = load_profile("mash")
    return profile.model_copy(update={"cameras": {"top": profile.cameras["top"]}})


def rig_with(check: Check, is_wanted: Callable[[], bool] = lambda: False) -> Rig:
    rig = Rig(profile=one_camera())
    rig.watchdog = Watchdog(
        rig.cell, lambda: rig._lend(), rig.history, rig.outbox, rig.wall_clock, rig.clock,
        wire=rig.wire, versions={}, calibrations=check, is_wanted=is_wanted,
    )  # fmt: skip
    return rig


def outcome(rig: Rig) -> tuple[str, str]:
    done = rig.watchdog.run_round(["calibrations"])
    assert done is not None
    assert [r.component for r in done.records] == ["arm", "display", "calibrations"]
    return done.records[-1].outcome, done.records[-1].detail


def test_calibrations_that_hold_pass() -> None:
    assert outcome(rig_with(Check(HOLDS))) == ("ok", HOLDS.text)


def test_what_moved_is_filed_once_with_its_pictures_until_it_holds_again() -> None:
    check = Check(MOVED)
    rig = rig_with(check)
    told, detail = outcome(rig)
    assert told == "failed"
    assert "2.10 mm" in detail
    assert "cell calibrate screen" in detail
    check.word = MOVED_MORE
    outcome(rig)
    (fault,) = rig.history.faults()
    assert (fault.component, fault.times, fault.ended) == ("calibrations", 2, "")
    check.word = CANNOT_TELL
    assert outcome(rig) == ("cannot tell", "too few dots")
    assert rig.history.faults()[0].ended == ""
    check.word = HOLDS
    outcome(rig)
    assert rig.history.faults()[0].ended


def test_a_check_that_cannot_tell_is_no_fault_of_a_device() -> None:
    rig = rig_with(Check(CANNOT_TELL))
    assert outcome(rig)[0] == "cannot tell"
    assert rig.history.faults() == []


@pytest.mark.parametrize("before", ["forest", "pixels"])
def test_screen_television_and_lights_are_left_as_they_were(before: str) -> None:
    rig = rig_with(Check(HOLDS))
    screen, world = rig.cell.screen, rig.cell.behind.world
    noise = np.random.default_rng(3).integers(0, 256, PATTERN.shape, np.uint8)
    screen.show_pixels(noise, "mine") if before == "pixels" else screen.show(before)
    name, pixels = world.sent_picture, world.sent_pixels
    assert outcome(rig)[0] == "ok"
    assert world.sent_picture == name
    assert world.sent_pixels is pixels
    assert not rig.cell.display.is_on()
    assert not world.scene().are_lights_on
    assert not rig.cell.arm.is_held


def test_the_check_ends_when_a_client_asks_for_the_cell() -> None:
    check, asked = Check(HOLDS), []
    check.between = lambda: asked.append(True)
    rig = rig_with(check, lambda: bool(asked))
    rig.cell.screen.show("forest")
    told, detail = outcome(rig)
    assert told == "not tested"
    assert "client" in detail
    assert check.looks == 0
    assert rig.cell.screen.shown() == "forest"
    assert rig.history.faults() == []


def test_the_check_ends_when_the_watchdog_is_stopped() -> None:
    check = Check(HOLDS)
    rig = rig_with(check)
    check.between = rig.watchdog.stop
    assert outcome(rig)[0] == "not tested"
    assert check.looks == 0


def test_a_page_that_is_gone_is_told_and_the_arm_is_not_held_for_it() -> None:
    rig = rig_with(Check(HOLDS))
    screen = rig.cell.screen
    assert isinstance(screen, TwinScreen)
    screen.disturb(PageFault.CLOSED)
    told, detail = outcome(rig)
    assert told == "failed"
    assert "no page" in detail
    assert not rig.cell.arm.is_held


def test_a_television_that_fails_is_told_by_its_own_test_alone() -> None:
    check = Check(HOLDS)
    rig = rig_with(check)

    def fail() -> str:
        raise DeviceError("display", "does not answer")

    rig.cell.display.open = fail  # type: ignore[method-assign]
    assert outcome(rig) == ("not tested", "it needs the display")
    assert [fault.component for fault in rig.history.faults()] == ["display"]
