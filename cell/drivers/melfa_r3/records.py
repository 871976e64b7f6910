"""What the data of replies mean: parsers and printers, one pair a record.

Parsers raise `GarbledMessage` and nothing else; printers give the controller's
own layout, so that a driver and an emulator share every field.
"""

from __future__ import annotations

from cell.drivers.melfa_r3.axes import (
    CARTESIAN,
    JOINTS,
    AxisReport,
    joints_of,
    parse_axes,
    pose_of,
    print_axes,
)
from cell.drivers.melfa_r3.identity import (
    Identity,
    parse_identity,
    print_identity,
)
from cell.drivers.melfa_r3.states import (
    FullState,
    ShortState,
    parse_full_state,
    parse_short_state,
    print_full_state,
    print_short_state,
)
from cell.drivers.melfa_r3.values import (
    HandState,
    StopSources,
    parse_alarm,
    parse_hands,
    parse_parameter,
    parse_percent,
    parse_stop_sources,
    parse_variable,
    parse_word,
    parse_word_pair,
    print_alarm,
    print_hands,
    print_parameter,
    print_stop_sources,
    print_words,
)

__all__ = [
    "AxisReport",
    "CARTESIAN",
    "FullState",
    "HandState",
    "Identity",
    "JOINTS",
    "ShortState",
    "StopSources",
    "joints_of",
    "parse_alarm",
    "parse_axes",
    "parse_full_state",
    "parse_hands",
    "parse_identity",
    "parse_parameter",
    "parse_percent",
    "parse_short_state",
    "parse_stop_sources",
    "parse_variable",
    "parse_word",
    "parse_word_pair",
    "pose_of",
    "print_alarm",
    "print_axes",
    "print_full_state",
    "print_hands",
    "print_identity",
    "print_parameter",
    "print_short_state",
    "print_stop_sources",
    "print_words",
]
