"""A capture that behaves like OpenCV's over FireWire, as its sources tell."""

from __future__ import annotations

import threading

import cv2
import numpy as np
from numpy.typing import NDArray

_SPECIAL = range(-4, 0)
_LARGEST_FEATURE = 31
_U, _V = cv2.CAP_PROP_WHITE_BALANCE_BLUE_U, cv2.CAP_PROP_WHITE_BALANCE_RED_V


class FakeDc1394:
    """Raw integers, clamping, modes by negative numbers, size only before the first picture."""

    def __init__(self, guid: int = 0x00B09D01009A7C42) -> None:
        self.guid = guid
        self.ranges: dict[int, tuple[int, int]] = {
            cv2.CAP_PROP_BRIGHTNESS: (0, 255),
            cv2.CAP_PROP_AUTO_EXPOSURE: (1, 1023),
            cv2.CAP_PROP_SHARPNESS: (0, 4095),
            cv2.CAP_PROP_SATURATION: (0, 4095),
            cv2.CAP_PROP_GAMMA: (512, 4095),
            cv2.CAP_PROP_EXPOSURE: (0, 1590),
            cv2.CAP_PROP_GAIN: (16, 683),
        }
        self.values: dict[int, float] = {p: low for p, (low, _) in self.ranges.items()}
        self.values |= {_U: 500.0, _V: 500.0, cv2.CAP_PROP_GAIN: 68.0}
        self.modes: dict[int, int] = {}
        self.size = (640, 480)
        self.is_started = False
        self.is_released = False
        self.stuck: set[int] = set()
        self.torn: set[int] = set()
        self.grabbed = 0
        self.pictures_left = 10**9
        self.gate = threading.Semaphore(0)
        self.is_paced = False

    def grab(self) -> bool:
        self.is_started = True
        if self.is_paced:
            self.gate.acquire()
        if self.is_released or self.pictures_left == 0:
            return False
        self.pictures_left -= 1
        self.grabbed += 1
        return True

    def retrieve(self) -> NDArray[np.uint8] | None:
        if self.grabbed in self.torn:
            return None
        picture = np.zeros((self.size[1], self.size[0], 3), np.uint8)
        picture[:] = (10, 20, self.grabbed % 256)
        return picture

    def get(self, prop: int) -> float:
        if prop == cv2.CAP_PROP_GUID:
            return float(self.guid & 0xFFFFFFFF)
        return self.values.get(prop, -1.0)

    def set(self, prop: int, value: float) -> bool:
        if prop in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FPS):
            if self.is_started:
                return False
            if prop == cv2.CAP_PROP_FRAME_WIDTH:
                self.size = (round(value), round(value * 3 / 4))
            return True
        if prop not in self.values:
            return False
        if round(value) in _SPECIAL:
            self.modes[prop] = round(value)
            return True
        self.modes[prop] = cv2.CAP_PROP_DC1394_MODE_MANUAL
        if prop in self.ranges:
            low, high = self.ranges[prop]
            value = min(max(value, low), high)
        if prop not in self.stuck:
            self.values[prop] = float(round(value))
        return True

    def release(self) -> None:
        self.is_released = True
