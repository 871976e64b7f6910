"""Seeds: one number from which everything random in a session follows."""

from __future__ import annotations

import hashlib
import secrets
import threading
from typing import Literal

SEED_BITS = 32


def random_seed() -> int:
    """Return a seed that nobody can foretell, below 2**32."""
    return secrets.randbits(SEED_BITS)


def derive_seed(seed: int, purpose: Literal["session", "task"], ordinal: int) -> int:
    """Return the seed of the `ordinal`-th session of a server or task of a session.

    The first one (ordinal 0) has the seed itself, so that a seed which was told
    or logged can be given again; the others are the first 32 bits of the SHA-256
    of seed, purpose and ordinal.
    """
    if ordinal == 0:
        return seed
    digest = hashlib.sha256(f"{seed}/{purpose}/{ordinal}".encode()).digest()
    return int.from_bytes(digest[: SEED_BITS // 8], "big")


class SeedSequence:
    """The seeds of a server's sessions, one after the other; safe to share by threads."""

    def __init__(self, server_seed: int) -> None:
        self._server_seed = server_seed
        self._next = 0
        self._lock = threading.Lock()

    def next_seed(self) -> int:
        """Return the seed of the next session."""
        with self._lock:
            ordinal = self._next
            self._next += 1
        return derive_seed(self._server_seed, "session", ordinal)
