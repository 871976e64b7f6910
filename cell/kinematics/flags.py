"""The controller's structure flags: FL1 names the posture, FL2 counts turns.

FL1 has the bits Right (4), Above (2) and NonFlip (1); 7 is Right-Above-NonFlip.
FL2 holds a signed number of turns for each axis, axis n in the n-th nibble from
the right: an angle of -180..180 deg is turn 0, the next 360 deg turn 1.
"""

from __future__ import annotations

from math import ceil

RIGHT = 4
"""The wrist's centre lies on the +X side of the turning base."""
ABOVE = 2
"""The elbow lies above the line from shoulder to wrist."""
NON_FLIP = 1
"""J5 is not negative."""
POSTURES = range(8)


def posture_name(posture: int) -> str:
    """Return a posture in words, such as `Right-Above-NonFlip`."""
    return "-".join(
        (
            "Right" if posture & RIGHT else "Left",
            "Above" if posture & ABOVE else "Below",
            "NonFlip" if posture & NON_FLIP else "Flip",
        )
    )


def turn_number(angle_deg: float) -> int:
    """Return which turn an angle lies in: 0 from -180 to 180 deg, 1 above, -1 below."""
    if angle_deg > 180.0:
        return ceil((angle_deg - 180.0) / 360.0)
    if angle_deg < -180.0:
        return -ceil((-180.0 - angle_deg) / 360.0)
    return 0


def turns_flag(joints_deg: tuple[float, ...]) -> int:
    """Return FL2 of joint angles, J1 first; each nibble is a two's complement number."""
    flag = 0
    for axis, angle_deg in enumerate(joints_deg):
        if not -180.0 <= angle_deg <= 180.0:
            flag |= (turn_number(angle_deg) & 0xF) << (4 * axis)
    return flag


def axis_turns(flag: int, axis: int) -> int:
    """Return the signed number of turns that FL2 gives for an axis (1 to 8)."""
    nibble = (flag >> (4 * (axis - 1))) & 0xF
    return nibble - 16 if nibble > 7 else nibble
