"""`cell lights`: the cell's lights by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from console.hand import DEFAULTS, HandOptions, by_hand, tell

if TYPE_CHECKING:
    from cell.by_hand import ByHand


def lights(
    switch: Literal["on", "off", "state"] = "state", /, *, options: HandOptions = DEFAULTS
) -> int:
    """Switch the cell's lights, or tell whether they are on; the arm's servos stay as they are.

    Args:
        switch: on, off, or state.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        if switch == "state":
            hands.reach_controller()
        else:
            hands.take_right()
            hands.playground.switch_lights(is_on=switch == "on")
        is_on = hands.playground.arm.arm.read_output(hands.playground.profile.outputs.lights)
        tell({"on": is_on}, f"the lights are {'on' if is_on else 'off'}", options)

    return by_hand(options, work)
