"""`cell tv`: the television under the playground by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cyclopts import App

from console.exits import ConsoleError
from console.figures import Whole
from console.hand import DEFAULTS, HandOptions, as_lines, by_hand, tell
from console.output import say

if TYPE_CHECKING:
    from cell.by_hand import ByHand

app = App(name="tv")


@app.command
def on(*, options: HandOptions = DEFAULTS) -> int:
    """Switch the television on, to the profile's input, and wait until it takes commands.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.reach_display()
        say("switching on; it takes some seconds ...")
        hands.playground.display.switch_on()
        number = hands.playground.profile.display.input
        hands.playground.display.select_input(number)
        tell({"on": True, "input": number}, f"the television is on, input {number}", options)

    return by_hand(options, work)


@app.command
def off(*, options: HandOptions = DEFAULTS) -> int:
    """Put the television into standby.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.reach_display()
        hands.playground.display.switch_off()
        tell({"on": False}, "the television is in standby", options)

    return by_hand(options, work)


@app.command(name="input")
def select_input(number: Whole, /, *, options: HandOptions = DEFAULTS) -> int:
    """Select an input; the television is switched on if it is not.

    Args:
        number: Number of the input, as on the remote control.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.playground.display.require_input(number)
        _switch_on(hands)
        hands.playground.display.select_input(number)
        tell({"input": number}, f"input {number}", options)

    return by_hand(options, work)


@app.command
def volume(level: Whole, /, *, options: HandOptions = DEFAULTS) -> int:
    """Set the volume, 0 to 60; the television is switched on if it is not.

    Args:
        level: The volume.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.playground.display.require_volume(level)
        _switch_on(hands)
        hands.playground.display.set_volume(level)
        tell({"volume": level}, f"volume {level}", options)

    return by_hand(options, work)


@app.command
def picture(name: str, /, *, options: HandOptions = DEFAULTS) -> int:
    """Show a picture under the playground; the television is switched on if it is not.

    Args:
        name: black, white, mash, water or forest.
        options: Options of every command by hand.
    """
    from cell.pictures import PICTURE_NAMES

    if name not in PICTURE_NAMES:
        raise ConsoleError(f"there is no picture {name!r}; there are {', '.join(PICTURE_NAMES)}")

    def work(hands: ByHand) -> None:
        _switch_on(hands)
        hands.playground.display.select_input(hands.playground.profile.display.input)
        hands.playground.show(name)
        tell({"picture": name}, f"the screen shows {name}", options)

    return by_hand(options, work)


@app.command
def state(*, options: HandOptions = DEFAULTS) -> int:
    """Tell who the television is, whether it is on, its input and volume.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        from cell.drivers.sharp_aquos.driver import SharpDisplay

        identity = hands.reach_display()
        display = hands.playground.display
        told: dict[str, object] = {"identity": identity, "on": display.is_on()}
        if told["on"] and isinstance(display, SharpDisplay):
            told |= {"input": display.selected_input(), "volume": display.volume()}
        told["picture"] = hands.playground.screen.shown()
        tell(told, as_lines(told), options)

    return by_hand(options, work)


def _switch_on(hands: ByHand) -> None:
    hands.reach_display()
    if not hands.playground.display.is_on():
        say("switching on; it takes some seconds ...")
        hands.playground.display.switch_on()
