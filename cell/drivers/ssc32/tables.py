"""The numbers of the SSC-32's protocol. What is marked assumed was never seen on hardware."""

from __future__ import annotations

CHANNELS = 32
BANKS = 4
"""Eight channels each. Assumed: 0 to 3."""
LEAST_PULSE_US = 500
GREATEST_PULSE_US = 2500
GREATEST_TIME_MS = 65_535
"""T is in milliseconds; where a manual says microseconds, it is taken for a misprint."""
GREATEST_SPEED_US_S = 65_535
"""Assumed: a 16 bit figure like T. A speed of 0, or none, is full speed (assumed, too)."""
GREATEST_OFFSET_US = 100
"""Assumed, for `PO`, either way."""
QUERY_UNIT_US = 10
"""`QP` answers in units of this."""
ANALOGUE_COUNTS_PER_V = 51.2
INPUTS = "ABCDEF"
ANALOGUES = "ABCDEFGH"
MAX_LINE_BYTES = 1024
"""Assumed: the longest line kept; the rest of a longer one is dropped with it."""

CARRIAGE_RETURN = 0x0D
ESCAPE = 0x1B
IGNORED = frozenset(b" \t\n")
FINISHED = b"."
MOVING = b"+"
