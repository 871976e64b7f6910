"""The generator that every random draw of a task comes from.

SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators,
OOPSLA 2014). It is written out here because a seed that is told to a client and
recorded must give the same layout for ever: of Python's generator only `random()`
is promised to stay the same from version to version, not how whole numbers and
shuffles are made of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

_MASK = (1 << 64) - 1
Thing = TypeVar("Thing")


class Draws:
    """A stream of random whole numbers that is a function of its seed."""

    def __init__(self, seed: int) -> None:
        self._state = seed & _MASK

    def word(self) -> int:
        """Return the next 64 bits."""
        self._state = (self._state + 0x9E3779B97F4A7C15) & _MASK
        z = self._state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _MASK
        return z ^ (z >> 31)

    def below(self, limit: int) -> int:
        """Return a whole number from 0 to `limit` - 1, each as likely as any other."""
        end = (1 << 64) - (1 << 64) % limit
        word = self.word()
        while word >= end:
            word = self.word()
        return word % limit

    def between(self, low: int, high: int) -> int:
        """Return a whole number from `low` to `high`, both included."""
        return low + self.below(high - low + 1)

    def shuffled(self, things: Sequence[Thing]) -> list[Thing]:
        """Return the things in a random order (Fisher and Yates)."""
        order = list(things)
        for last in range(len(order) - 1, 0, -1):
            other = self.below(last + 1)
            order[last], order[other] = order[other], order[last]
        return order
