"""The sensor: from light to grey levels.

Light is counted in nominal levels: the grey level it gives at the camera's own
default settings, without an upper bound. Settings act relative to these defaults:
light is multiplied by shutter and gain, red and blue by their white balance; then
hue and saturation turn the colours, the level clips, gamma bends it and brightness
shifts it. Exposure target, pan and tilt belong to the camera's automatic modes and
its window on the sensor; with these off they change no pixel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import CameraSettings

NEUTRAL_SHARPNESS = 1024
FULL_LEVEL = 255.0

_LUMA = np.array([0.299, 0.587, 0.114])
_NOISE_MARGIN_PX = 64
_POOL_SEED = 1394
_LARGEST_PICTURE_PX = (960, 1280)


@dataclass(frozen=True, slots=True)
class Exposure:
    """What a camera's settings make of the light.

    Attributes:
        settings: The settings in force.
        defaults: The settings at which levels are nominal.
    """

    settings: CameraSettings
    defaults: CameraSettings

    @property
    def amplification(self) -> float:
        """Factor of the analogue gain over the default gain (20 dB are ten times)."""
        return float(10.0 ** ((self.settings.gain_db - self.defaults.gain_db) / 20.0))

    def linear(self, light: NDArray[np.floating]) -> NDArray[np.float32]:
        """Return exposed light of shape (..., 3), before clipping and gamma, never negative."""
        matrix = _channel_matrix(self.settings, self.defaults)
        if matrix.ndim == 1:
            return np.asarray(light.astype(np.float32) * matrix)
        return np.asarray(np.maximum(light.astype(np.float32) @ matrix.T, 0.0))

    def is_bent(self) -> bool:
        """Return whether gamma or brightness change levels after clipping."""
        return self.settings.gamma != 1.0 or self.settings.brightness_percent != 0.0

    def levels(self, exposed: NDArray[np.float32]) -> NDArray[np.uint8]:
        """Return grey levels of exposed light: clipped, bent by gamma, shifted, rounded."""
        clipped = np.clip(exposed, 0.0, FULL_LEVEL)
        if self.is_bent():
            clipped = FULL_LEVEL * (clipped / FULL_LEVEL) ** (1.0 / self.settings.gamma)
            clipped = clipped + self.settings.brightness_percent / 100.0 * FULL_LEVEL
        return np.clip(np.rint(clipped), 0.0, FULL_LEVEL).astype(np.uint8)

    def bend_table(self) -> NDArray[np.uint8]:
        """Return the table from clipped to bent levels, 256 entries."""
        return self.levels(np.arange(256, dtype=np.float32))

    def sharpening(self) -> float:
        """Return the weight of the unsharp mask; 0 at the neutral setting."""
        return (self.settings.sharpness - NEUTRAL_SHARPNESS) / NEUTRAL_SHARPNESS


@lru_cache(maxsize=16)
def _channel_matrix(now: CameraSettings, default: CameraSettings) -> NDArray[np.float32]:
    """Return what takes nominal to exposed light: (3,) by channel, or (3, 3) when they mix."""
    amplification = Exposure(now, default).amplification
    balance = np.array(
        [
            now.white_balance_red / default.white_balance_red,
            1.0,
            now.white_balance_blue / default.white_balance_blue,
        ]
    )
    gains = now.shutter_ms / default.shutter_ms * amplification * balance
    if now.saturation_percent == 100.0 and now.hue_deg == 0.0:
        return gains.astype(np.float32)
    mixed = _colour_matrix(now.saturation_percent / 100.0, now.hue_deg) * gains
    return np.asarray(mixed, np.float32)


def _colour_matrix(saturation: float, hue_deg: float) -> NDArray[np.float64]:
    """Return the matrix that scales and turns colours about grey, keeping luma."""
    cos, sin = math.cos(math.radians(hue_deg)), math.sin(math.radians(hue_deg))
    axis = 1.0 / math.sqrt(3.0)
    cross = axis * np.array([[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
    turn = cos * np.eye(3) + sin * cross + (1.0 - cos) / 3.0 * np.ones((3, 3))
    grey = np.tile(_LUMA, (3, 1))
    return (saturation * np.eye(3) + (1.0 - saturation) * grey) @ turn


class SensorNoise:
    """Noise fields that a seed and a frame number pick from one pool.

    All cameras share one large field; each frame takes its own window of it, so any
    frame's noise is known from the seed and its number alone.
    """

    def __init__(self, seed: int, deviation: float) -> None:
        """Make the pool.

        Args:
            seed: Decides which window each frame takes.
            deviation: Standard deviation in grey levels.
        """
        self._seed = seed
        self._more, self._less = _noise_pool(round(deviation, 4))

    def apply(self, picture: NDArray[np.uint8], frame_number: int) -> NDArray[np.uint8]:
        """Return a new picture with the noise of a frame added."""
        height, width = picture.shape[:2]
        side = _NOISE_MARGIN_PX + 1
        pick = np.random.SeedSequence([self._seed, frame_number]).generate_state(1)[0]
        down, right = divmod(int(pick) % (side * side), side)
        window = np.s_[down : down + height, right : right + width]
        noisy = cv2.add(picture, self._more[window])
        return np.asarray(cv2.subtract(noisy, self._less[window], dst=noisy), np.uint8)


@lru_cache(maxsize=6)
def _noise_pool(deviation: float) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return what to add and what to take away: normal noise rounded to whole levels."""
    base = _uniform_field()
    middle = (np.arange(4096) + 0.5) / 4096
    # Rounding adds a variance of 1/12 of a level; taking it off keeps the deviation exact.
    spread = math.sqrt(max(deviation * deviation - 1.0 / 12.0, 0.0))
    offsets = np.rint(spread * _normal_quantile(middle)).astype(np.int16)
    more = np.take(np.maximum(offsets, 0).astype(np.uint8), base)
    less = np.take(np.maximum(-offsets, 0).astype(np.uint8), base)
    return more, less


@lru_cache(maxsize=1)
def _uniform_field() -> NDArray[np.uint16]:
    rows, columns = (size + _NOISE_MARGIN_PX for size in _LARGEST_PICTURE_PX)
    generator = np.random.default_rng(_POOL_SEED)
    return generator.integers(0, 4096, (rows, columns, 3), dtype=np.uint16)


def _normal_quantile(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return quantiles of the normal distribution by inverting its integral on a table."""
    x = np.linspace(-5.0, 5.0, 20001)
    density = np.exp(-0.5 * x * x)
    cumulated = np.cumsum(density) - 0.5 * density
    return np.interp(share, cumulated / density.sum(), x)
