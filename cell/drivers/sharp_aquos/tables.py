"""Command words, their ranges, the inputs: what differs from model to model.

No list for the LC-40LE705 itself was found; it is assumed to be that of its
European siblings. What is assumed stands here, and not in the driver's logic.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, StrEnum
from types import MappingProxyType


class Word(StrEnum):
    """The four letters with which a command begins."""

    POWER = "POWR"
    POWER_PERMISSION = "RSPW"
    NEXT_INPUT = "ITGD"
    TUNER = "ITVD"
    INPUT = "IAVD"
    AV_MODE = "AVMD"
    VOLUME = "VOLM"
    MUTE = "MUTE"
    VIEW_MODE = "WIDE"
    SLEEP_TIMER = "OFTM"
    SURROUND = "ACSU"
    AUDIO = "ACHA"
    HORIZONTAL_POSITION = "HPOS"
    VERTICAL_POSITION = "VPOS"
    CLOCK = "CLCK"
    PHASE = "PHSE"
    CHANNEL_UP = "CHUP"
    CHANNEL_DOWN = "CHDW"
    ANALOGUE_CHANNEL = "DCCH"
    REMOTE_KEY = "RCKY"
    NAME = "TVNM"
    MODEL = "MNRD"
    SOFTWARE = "SWVN"


@dataclass(frozen=True, slots=True)
class Range:
    """Which numbers a command word takes, and whether it also tells its value."""

    least: int
    most: int
    can_be_asked: bool = True
    others: frozenset[int] = frozenset()

    def allows(self, value: int) -> bool:
        """Return whether a number may follow the word."""
        return self.least <= value <= self.most or value in self.others


RANGES: MappingProxyType[Word, Range] = MappingProxyType(
    {
        Word.POWER: Range(0, 1),
        Word.POWER_PERMISSION: Range(0, 2),
        Word.NEXT_INPUT: Range(0, 9, can_be_asked=False),
        Word.TUNER: Range(0, 9, can_be_asked=False),
        Word.INPUT: Range(1, 8),
        Word.AV_MODE: Range(0, 8, others=frozenset({100})),
        Word.VOLUME: Range(0, 60),
        Word.MUTE: Range(0, 2),
        Word.VIEW_MODE: Range(0, 11),
        Word.SLEEP_TIMER: Range(0, 4),
        Word.SURROUND: Range(0, 2),
        Word.AUDIO: Range(0, 9, can_be_asked=False),
        Word.HORIZONTAL_POSITION: Range(0, 180),
        Word.VERTICAL_POSITION: Range(0, 180),
        Word.CLOCK: Range(0, 180),
        Word.PHASE: Range(0, 40),
        Word.CHANNEL_UP: Range(0, 9, can_be_asked=False),
        Word.CHANNEL_DOWN: Range(0, 9, can_be_asked=False),
        Word.ANALOGUE_CHANNEL: Range(1, 999),
        Word.REMOTE_KEY: Range(0, 99, can_be_asked=False),
        Word.NAME: Range(1, 1, can_be_asked=False),
        Word.MODEL: Range(1, 1, can_be_asked=False),
        Word.SOFTWARE: Range(1, 1, can_be_asked=False),
    }
)

TELLS_TEXT = frozenset({Word.NAME, Word.MODEL, Word.SOFTWARE})
"""Words whose answer is a text instead of OK."""

MAY_STAY_SILENT = frozenset({Word.CHANNEL_UP, Word.CHANNEL_DOWN})
"""Words that some sets carry out without an answer."""

NOT_REPEATABLE = frozenset({Word.NEXT_INPUT, Word.CHANNEL_UP, Word.CHANNEL_DOWN, Word.REMOTE_KEY})
"""Words that do more when sent twice."""

STANDBY_WORDS = frozenset({Word.POWER, Word.POWER_PERMISSION})
"""Words that a set in standby answers (assumed)."""


class Permission(IntEnum):
    """Whence a set in standby may be switched on."""

    NONE = 0
    SERIAL = 1
    NETWORK = 2


class AvMode(IntEnum):
    """Picture presets; TOGGLE goes to the next one."""

    TOGGLE = 0
    STANDARD = 1
    MOVIE = 2
    GAME = 3
    USER = 4
    DYNAMIC_FIXED = 5
    DYNAMIC = 6
    PC = 7
    XVYCC = 8
    AUTOMATIC = 100


class Mute(IntEnum):
    """Sound off or on; TOGGLE changes between them."""

    TOGGLE = 0
    ON = 1
    OFF = 2


SLEEP_MINUTES = (0, 30, 60, 90, 120)
"""Minutes of the sleep timer by the number that sets it; 0 is off."""

InputMap = MappingProxyType[int, str]

HDMI_FIRST: InputMap = MappingProxyType(
    {
        1: "HDMI 1",
        2: "HDMI 2",
        3: "HDMI 3",
        4: "HDMI 4",
        5: "component",
        6: "video 1",
        7: "video 2",
        8: "PC",
    }
)
"""Inputs of sets with four HDMI sockets (seen in two sources)."""

THREE_HDMI: InputMap = MappingProxyType(
    {1: "HDMI 1", 2: "HDMI 2", 3: "HDMI 3", 4: "video", 5: "component", 6: "PC"}
)
"""Inputs of sets with three HDMI sockets (one source)."""

SCART_FIRST: InputMap = MappingProxyType(
    {
        1: "EXT 1",
        2: "EXT 2",
        3: "EXT 3",
        4: "HDMI 1",
        5: "HDMI 2",
        6: "HDMI 3",
        7: "HDMI 4",
        8: "PC",
    }
)
"""Inputs of European sets that count their SCART sockets first (assumed)."""

INPUTS_OF_MODEL: MappingProxyType[str, InputMap] = MappingProxyType({"sharp-lc40le705": HDMI_FIRST})
"""Which inputs each model of the profile has (assumed)."""


class Key(IntEnum):
    """Keys of the remote control (one source); 0 to 9 are the digits."""

    POWER = 12
    INPUT = 36
    MENU = 38
    ENTER = 40
    UP = 41
    DOWN = 42
    LEFT = 43
    RIGHT = 44
    RETURN = 45
    EXIT = 46
