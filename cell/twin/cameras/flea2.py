"""The register file of an emulated Flea2: inquiry, control and absolute words.

Ranges are data, assumed where the source gives none, and are read by drivers from the
registers like those of a real camera. Two of them are as wide as the cell's own settings
(table C.1) need: gains below 0 dB, and shutters longer than one frame period.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from cell.devices.camera_features import FeatureName
from cell.drivers.iidc.codec import (
    ControlWord,
    InquiryWord,
    decode_absolute,
    decode_control,
    encode_absolute,
    encode_control,
    encode_inquiry,
)
from cell.drivers.iidc.tables import ABSOLUTE_INQUIRY, COMMAND_BASE, CONTROL, INQUIRY, SLOTS
from cell.errors import DeviceError

_ABSOLUTE_BLOCKS = COMMAND_BASE + 0x2000
_BLOCK_STEP = 0x10

SHUTTER_FRAME_PERIODS = 4.0
"""Longest shutter in frame periods: the range doubles when the frame rate is halved."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Register:
    """One feature register of the body.

    Attributes:
        offset: Bytes from the start of each block of registers.
        raw: Least and greatest raw value.
        absolute: Least and greatest absolute value in the camera's unit, None without one.
        power_up: Raw value after power-up (both halves, for the white balance).
        has_auto: Whether the camera can set it itself.
        has_one_push: Whether it can do so once.
        has_manual: Whether it takes values at all.
    """

    offset: int
    raw: tuple[int, int]
    absolute: tuple[float, float] | None = None
    power_up: tuple[int, int] = (0, 0)
    has_auto: bool = False
    has_one_push: bool = False
    has_manual: bool = True


FLEA2: tuple[Register, ...] = (
    Register(offset=SLOTS["brightness"].offset, raw=(0, 255), absolute=(0.0, 6.24)),
    Register(
        offset=SLOTS["exposure"].offset, raw=(0, 1023), absolute=(-7.6, 2.4),
        power_up=(0, 850), has_auto=True, has_one_push=True,
    ),
    Register(
        offset=SLOTS["sharpness"].offset, raw=(0, 4095), power_up=(0, 1024), has_auto=True
    ),
    Register(
        offset=SLOTS["white_balance_red"].offset, raw=(0, 1023), power_up=(700, 550),
        has_auto=True, has_one_push=True,
    ),
    Register(offset=SLOTS["hue"].offset, raw=(0, 4095), absolute=(-180.0, 180.0),
             power_up=(0, 2048)),
    Register(offset=SLOTS["saturation"].offset, raw=(0, 4095), absolute=(0.0, 400.0),
             power_up=(0, 1024), has_auto=True),
    Register(offset=SLOTS["gamma"].offset, raw=(512, 4095), absolute=(0.5, 4.0),
             power_up=(0, 1024)),
    Register(
        offset=SLOTS["shutter"].offset, raw=(0, 4095), absolute=(1e-5, 4.0 / 7.5),
        power_up=(0, 500), has_auto=True, has_one_push=True,
    ),
    Register(
        offset=SLOTS["gain"].offset, raw=(0, 1023), absolute=(-6.0, 24.0),
        power_up=(0, 205), has_auto=True, has_one_push=True,
    ),
    Register(offset=SLOTS["frame_rate"].offset, raw=(0, 4095), absolute=(1.0, 30.0),
             has_auto=True, has_manual=False),
    Register(offset=SLOTS["pan"].offset, raw=(0, 4095)),
    Register(offset=SLOTS["tilt"].offset, raw=(0, 4095)),
)  # fmt: skip
"""Every feature register of the body; the figures are assumed, see `docs/reference/cameras.md`."""

_RAW_FOLLOWS = (SLOTS["shutter"].offset, SLOTS["gain"].offset)
"""Registers whose raw value is read-only in automatic and in absolute mode."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptRegisters:
    """What was set of a body, by the offset of each register.

    Attributes:
        words: Control words.
        absolutes: Absolute values in the camera's unit.
        rate_hz: Frame rate.
    """

    words: dict[int, ControlWord]
    absolutes: dict[int, float]
    rate_hz: float


class Flea2Registers:
    """What the body answers to reads and writes of its registers.

    Attributes:
        is_powered: Whether it is on the bus.
        is_reset: Whether its settings are those of power-up; whoever sets them clears it.
    """

    def __init__(self, camera: str) -> None:
        """Power a body up.

        Args:
            camera: Name of the camera, for messages.
        """
        self._camera = camera
        self._registers = {register.offset: register for register in FLEA2}
        self._words: dict[int, ControlWord] = {}
        self._absolutes: dict[int, float] = {}
        self._rate_hz = 7.5
        self._revision = 0
        self.power_up()

    @property
    def revision(self) -> int:
        """Differs whenever any register differs."""
        return self._revision

    def check_power(self) -> None:
        """Return if the body has power.

        Raises:
            DeviceError: It has none.
        """
        if not self.is_powered:
            raise DeviceError(
                f"camera {self._camera}",
                "is not on the bus",
                hint="plug its cable in and open it again",
            )

    def power_up(self) -> None:
        """Begin as after power-up: what can be automatic is, and no setting is kept."""
        self.is_powered = True
        self.is_reset = True
        for offset, register in self._registers.items():
            high, low = register.power_up
            self._words[offset] = ControlWord(is_auto=register.has_auto, high_value=high, value=low)
            self._follow_raw(offset)
        self.set_frame_rate(self._rate_hz)

    def kept(self) -> KeptRegisters:
        """Return what was set."""
        return KeptRegisters(
            words=dict(self._words), absolutes=dict(self._absolutes), rate_hz=self._rate_hz
        )

    def restore(self, kept: KeptRegisters) -> None:
        """Go on from what was kept; registers that the body does not have are left out."""
        self.set_frame_rate(kept.rate_hz)
        self._words |= {o: word for o, word in kept.words.items() if o in self._words}
        self._absolutes |= {o: v for o, v in kept.absolutes.items() if o in self._absolutes}
        self._revision += 1

    def set_frame_rate(self, rate_hz: float) -> None:
        """Run at a rate; the longest shutter goes with the frame period."""
        self._rate_hz = rate_hz
        shutter = SLOTS["shutter"].offset
        register = self._registers[shutter]
        low = 1e-5 if register.absolute is None else register.absolute[0]
        span = (low, SHUTTER_FRAME_PERIODS / rate_hz)
        self._registers[shutter] = replace(register, absolute=span)
        self._set_absolute(shutter, min(self._absolutes[shutter], span[1]))
        self._set_absolute(SLOTS["frame_rate"].offset, rate_hz)

    def read(self, address: int) -> int:
        """Return a register's word.

        Raises:
            DeviceError: The body has no power.
        """
        self.check_power()
        offset = address - INQUIRY
        if offset in self._registers:
            return encode_inquiry(_inquiry(self._registers[offset]))
        offset = address - CONTROL
        if offset in self._words:
            return encode_control(self._words[offset])
        offset = address - ABSOLUTE_INQUIRY
        if offset in self._registers:
            has_absolute = self._registers[offset].absolute is not None
            return _block(offset) // 4 if has_absolute else 0
        for offset, register in self._registers.items():
            step = address - _block(offset)
            if register.absolute is not None and step in (0, 4, 8):
                return encode_absolute((*register.absolute, self._absolutes[offset])[step // 4])
        return 0

    def write(self, address: int, word: int) -> None:
        """Write a register; what it does not take is ignored, as the body does.

        Raises:
            DeviceError: The body has no power.
        """
        self.check_power()
        offset = address - CONTROL
        if offset in self._words:
            self._write_control(offset, decode_control(word))
            return
        for offset, register in self._registers.items():
            if address == _block(offset) + 8 and register.absolute is not None:
                state = self._words[offset]
                if state.is_absolute and state.is_on and not state.is_auto:
                    self._set_absolute(offset, decode_absolute(word))

    def leave_auto(self, name: FeatureName) -> bool:
        """Switch a feature to automatic; return whether the body can."""
        offset = SLOTS[name].offset
        if not self._registers[offset].has_auto:
            return False
        self._words[offset] = replace(self._words[offset], is_auto=True, is_on=True)
        self._revision += 1
        return True

    def is_auto(self, name: FeatureName) -> bool:
        """Return whether the body sets a feature itself."""
        word = self._words[SLOTS[name].offset]
        return word.is_auto and word.is_on

    def absolute(self, name: FeatureName) -> float:
        """Return an absolute value in the body's unit."""
        return self._absolutes[SLOTS[name].offset]

    def adjust(self, name: FeatureName, value: float) -> None:
        """Let the body itself set an absolute value, in whole raw steps."""
        offset = SLOTS[name].offset
        self._set_absolute(offset, value)
        self._follow_raw(offset)

    def adjust_white_balance(self, factors: Mapping[FeatureName, float]) -> None:
        """Let the body itself multiply its white balance."""
        offset = SLOTS["white_balance_red"].offset
        low, high = self._registers[offset].raw
        word = self._words[offset]
        red = round(word.value * factors["white_balance_red"])
        blue = round(word.high_value * factors["white_balance_blue"])
        changed = replace(
            word, value=min(max(red, low + 1), high), high_value=min(max(blue, low + 1), high)
        )
        if changed != word:
            self._words[offset] = changed
            self._revision += 1

    def _write_control(self, offset: int, asked: ControlWord) -> None:
        register, before = self._registers[offset], self._words[offset]
        if not register.has_manual:
            return
        low, high = register.raw
        is_auto = asked.is_auto and register.has_auto
        is_absolute = asked.is_absolute and register.absolute is not None
        is_kept = is_absolute or is_auto
        after = ControlWord(
            is_absolute=is_absolute,
            is_on=asked.is_on,
            is_auto=is_auto,
            value=before.value if is_kept else min(max(asked.value, low), high),
            high_value=before.high_value if is_kept else min(max(asked.high_value, low), high),
        )
        if not _is_white_balance(offset):
            after = replace(after, high_value=0)
        if offset in _RAW_FOLLOWS and (before.is_auto or before.is_absolute):
            # The word that ends such a mode does not carry a value yet.
            after = replace(after, value=before.value)
        self._words[offset] = after
        if not is_kept:
            self._follow_raw(offset)
        self._revision += 1

    def _set_absolute(self, offset: int, value: float) -> None:
        register = self._registers[offset]
        if register.absolute is None:
            return
        low, high = register.absolute
        value = min(max(value, low), high)
        if value == self._absolutes.get(offset):
            return
        share = (value - low) / (high - low)
        raw = round(register.raw[0] + share * (register.raw[1] - register.raw[0]))
        self._absolutes[offset] = value
        self._words[offset] = replace(self._words[offset], value=raw)
        self._revision += 1

    def _follow_raw(self, offset: int) -> None:
        register = self._registers[offset]
        if register.absolute is None:
            return
        low, high = register.absolute
        share = (self._words[offset].value - register.raw[0]) / (register.raw[1] - register.raw[0])
        self._absolutes[offset] = low + share * (high - low)
        self._revision += 1


def _block(offset: int) -> int:
    return _ABSOLUTE_BLOCKS + (offset // 4) * _BLOCK_STEP


def _is_white_balance(offset: int) -> bool:
    return offset == SLOTS["white_balance_red"].offset


def _inquiry(register: Register) -> InquiryWord:
    return InquiryWord(
        is_present=True,
        has_absolute=register.absolute is not None,
        has_one_push=register.has_one_push,
        is_readable=True,
        has_on_off=register.has_auto and register.has_manual,
        has_auto=register.has_auto,
        has_manual=register.has_manual,
        raw_min=register.raw[0],
        raw_max=register.raw[1],
    )
