"""Hobby servos as they are: a pulse train goes in, a shaft turns after it, not quite there.

The controller commands a pulse width that changes evenly during a move. The shaft follows it
no faster than the servo can, and where it comes to rest differs from what the pulse means
by gain, offset and a wave: the potentiometer inside is not linear. What the shaft really
does is the twin's truth; the controller never knows.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from cell.drivers.ssc32.servo_map import ServoMap, servo_map
from cell.profile.lynx import LynxProfile

_CENTRE_US = 1500.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoErrors:
    """How a servo differs from its straight line.

    Attributes:
        gain: Share by which it turns further than its slope says.
        offset: How far the horn is set off, in the unit of its positions.
        wave: Height of the potentiometer's wave, in the same unit.
        wave_us: Length of that wave.
        wave_rad: Where it starts.
    """

    gain: float = 0.0
    offset: float = 0.0
    wave: float = 0.0
    wave_us: float = 1400.0
    wave_rad: float = 0.0

    @staticmethod
    def draw(source: random.Random, *, scale: float = 1.0) -> ServoErrors:
        """Return the errors of some servo, as hobby servos come; `scale` 0 has none.

        Gain 2 %, horn 1.5 deg (a spline's tooth is 15 deg, the offset takes the rest), wave
        1 to 2 deg: what people measure on such servos; assumed.
        """
        return ServoErrors(
            gain=scale * source.gauss(0.0, 0.02),
            offset=scale * source.gauss(0.0, 1.5),
            wave=scale * source.uniform(1.0, 2.0),
            wave_us=source.uniform(1100.0, 1800.0),
            wave_rad=source.uniform(0.0, 2.0 * math.pi),
        )

    def bent(self, position: float, pulse_us: float) -> float:
        """Return where the shaft stands for a pulse that means `position`."""
        wave = self.wave * math.sin(2.0 * math.pi * (pulse_us - _CENTRE_US) / self.wave_us
                                    + self.wave_rad)  # fmt: skip
        return position * (1.0 + self.gain) + self.offset + wave


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptServo:
    """A servo at rest.

    Attributes:
        pulse_us: Pulse it is sent, None for none since power-up.
        shaft_us: Where its shaft stands, as the pulse that holds it there.
        limp_us: Where its shaft lies without pulses.
        offset_us: What the controller adds to every pulse.
    """

    pulse_us: float | None
    shaft_us: float
    limp_us: float
    offset_us: float


class TwinServo:
    """One servo: the pulse commanded over time, and the shaft behind it.

    Args:
        line: What its pulses mean if it were perfect.
        errors: How it differs from that.
        limp_us: Where its shaft lies without pulses, as the pulse that would hold it there.
        full_speed_us_s: Greatest speed of the shaft; 4000 us/s is 360 deg/s.
    """

    def __init__(
        self,
        line: ServoMap,
        errors: ServoErrors,
        *,
        limp_us: float = _CENTRE_US,
        full_speed_us_s: float = 4000.0,
    ) -> None:
        self._line = line
        self._errors = errors
        self._limp_us = limp_us
        self._full_speed_us_s = full_speed_us_s
        self._offset_us = 0.0
        self._start_us: float | None = None
        self._target_us = 0.0
        self._start_s = 0.0
        self._end_s = 0.0
        self._shaft_us = limp_us
        self._shaft_s = 0.0
        self._has_supply = True
        self.jumps_us: list[float] = []
        """How far the shaft was from each first pulse; for tests."""

    @property
    def is_pulsed(self) -> bool:
        """Whether the controller sends it pulses."""
        return self._start_us is not None

    def pulse_us(self, now_s: float) -> float:
        """Return the commanded pulse width, 0 without pulses."""
        if self._start_us is None:
            return 0.0
        if now_s >= self._end_s:
            return self._target_us
        share = (now_s - self._start_s) / (self._end_s - self._start_s)
        return self._start_us + share * (self._target_us - self._start_us)

    def is_moving(self, now_s: float) -> bool:
        """Return whether the commanded pulse still changes."""
        return self._start_us is not None and now_s < self._end_s

    def command(self, target_us: float, duration_s: float, now_s: float) -> None:
        """Change the pulse evenly to a target; the first one since power-up jumps there."""
        self._follow(now_s)
        if self._start_us is None:
            self.jumps_us.append(abs(target_us - self._shaft_us))
            self._start_us, duration_s = target_us, 0.0
        else:
            self._start_us = self.pulse_us(now_s)
        self._target_us = target_us
        self._start_s, self._end_s = now_s, now_s + duration_s

    def hold(self, now_s: float) -> None:
        """Let the pulse stay as it is now."""
        if self._start_us is not None:
            self.command(self.pulse_us(now_s), 0.0, now_s)

    def shift(self, offset_us: float, now_s: float) -> None:
        """Add an offset to every pulse; the commanded width does not tell."""
        self._follow(now_s)
        self._offset_us = offset_us

    def lose_pulses(self, now_s: float) -> None:
        """Send no more pulses: the servo goes limp and the arm slumps."""
        self._follow(now_s)
        self._start_us = None
        self._shaft_us = self._limp_us

    def set_supply(self, now_s: float, *, is_on: bool) -> None:
        """Switch the servo's supply, which the controller does not notice."""
        self._follow(now_s)
        self._has_supply = is_on
        if not is_on:
            self._shaft_us = self._limp_us

    def put_by_hand(self, position: float, now_s: float) -> None:
        """Turn the limp shaft by hand to where it really stands at `position`."""
        self._follow(now_s)
        self._limp_us = self._line.pulse_us(position)
        if self._start_us is None or not self._has_supply:
            self._shaft_us = self._limp_us

    def kept(self, now_s: float) -> KeptServo:
        """Return what is left of it when its time begins anew: a move under way is over."""
        self._follow(now_s)
        is_driven = self._start_us is not None and self._has_supply
        return KeptServo(
            pulse_us=None if self._start_us is None else self._target_us,
            shaft_us=self._target_us + self._offset_us if is_driven else self._shaft_us,
            limp_us=self._limp_us,
            offset_us=self._offset_us,
        )

    def restore(self, kept: KeptServo) -> None:
        """Go on from what was kept, at time 0."""
        self._start_us = kept.pulse_us
        self._target_us = 0.0 if kept.pulse_us is None else kept.pulse_us
        self._start_s = self._end_s = 0.0
        self._shaft_us, self._limp_us = kept.shaft_us, kept.limp_us
        self._offset_us = kept.offset_us

    def truth(self, now_s: float) -> float:
        """Return where the shaft really stands; only tests and the world may ask."""
        self._follow(now_s)
        return self._errors.bent(self._line.position(self._shaft_us), self._shaft_us)

    def meant(self, now_s: float) -> float | None:
        """Return the position that the commanded pulse stands for, None without pulses."""
        return None if self._start_us is None else self._line.position(self.pulse_us(now_s))

    def _follow(self, now_s: float) -> None:
        """Let the shaft run after the pulse up to now."""
        while self._shaft_s < now_s:
            is_ramp = self._shaft_s < self._end_s
            until_s = min(now_s, self._end_s) if is_ramp else now_s
            if self._start_us is not None and self._has_supply:
                span_s = until_s - self._shaft_s
                here = self.pulse_us(self._shaft_s) + self._offset_us
                there = self.pulse_us(until_s) + self._offset_us
                self._shaft_us = _chase(
                    self._shaft_us, here, (there - here) / span_s, span_s, self._full_speed_us_s
                )
            self._shaft_s = until_s


class ServoBank:
    """The servos on a controller's channels.

    Args:
        servos: The servo on each channel that has one.
    """

    def __init__(self, servos: Mapping[int, TwinServo]) -> None:
        self.servos = dict(servos)

    @staticmethod
    def from_profile(profile: LynxProfile, *, seed: int, error_scale: float = 1.0) -> ServoBank:
        """Return the servos of a profile's arm and fingers with errors drawn by a seed.

        They start limp in the rest pose, as a technician puts them; a measured map in the
        profile is nothing they know, so the straight line is what they differ from.
        """
        source = random.Random(seed)
        servos: dict[int, TwinServo] = {}
        for number, rest in zip(profile.servos, profile.rest_deg, strict=True):
            line = servo_map(number.model_copy(update={"map": ()}))
            errors = ServoErrors.draw(source, scale=error_scale)
            servos[number.channel] = TwinServo(line, errors, limp_us=line.pulse_us(rest))
        fingers = profile.fingers
        line = servo_map(fingers.servo.model_copy(update={"map": ()}))
        errors = ServoErrors.draw(source, scale=0.2 * error_scale)
        servos[fingers.servo.channel] = TwinServo(
            line, errors, limp_us=line.pulse_us(fingers.open_mm)
        )
        return ServoBank(servos)

    def __iter__(self) -> Iterable[TwinServo]:
        return iter(self.servos.values())

    def get(self, channel: int) -> TwinServo | None:
        """Return the servo on a channel, None where nothing is plugged in."""
        return self.servos.get(channel)


def _chase(shaft: float, pulse: float, slope: float, span_s: float, speed: float) -> float:
    """Return where a shaft of limited speed is after chasing an evenly changing pulse."""
    gap = pulse - shaft
    sign = math.copysign(1.0, gap)
    closing = speed - sign * slope
    if gap and (closing <= 0 or abs(gap) > closing * span_s):
        return shaft + sign * speed * span_s
    caught_s = abs(gap) / closing if gap else 0.0
    if abs(slope) <= speed:
        return pulse + slope * span_s
    met = pulse + slope * caught_s
    return met + math.copysign(speed, slope) * (span_s - caught_s)
