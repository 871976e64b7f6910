"""Turns a camera's knobs until its patches look like the target, in few pictures.

Levels go with the light until they clip, so one picture tells by how much each channel is
off, and the next one is nearly right. Where nothing can be read because all is clipped, it
goes darker first; where all is dark, brighter. How far a knob really moves the light is
learned from the pictures: raw registers and cameras with a bent response come out too, in a
few more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from calibration.camera_settings.knobs import Knobs, Plan, turn
from calibration.camera_settings.target import Match, Target, match
from calibration.procedure import Steps, capture, tell
from calibration.requests import Picture

MOST_PICTURES = 20
DONE_ERROR = 1.0
"""Mean difference in grey levels at which the search has come to its end."""

_MOST_CLIPPED_SHARE = 0.5
_DARKER, _BRIGHTER = math.log(0.25), math.log(8.0)
_LEAST_LOG_STEP = 0.004
_PATIENCE = 3
_LEAST_LEARNED_STEP = 0.15
_RESPONSE_RANGE = (0.25, 4.0)
_LEAST_EFFECT = 0.05
_SHUTTER_LOG = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class Try:
    """One picture of the search.

    Attributes:
        knobs: What it was taken with.
        picture: The picture.
        match: How it compares.
    """

    knobs: Knobs
    picture: Picture
    match: Match


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """What a search came to.

    Attributes:
        best: The picture that looks most like the target; its knobs are in force.
        tries: All pictures, in order.
        short: ln light in R G B that could not be reached at the end: above 0 too dark.
        has_effect: Whether the pictures followed the knobs.
    """

    best: Try
    tries: tuple[Try, ...]
    short: tuple[float, float, float]
    has_effect: bool


def search(
    camera: str,
    target: Target,
    knobs: Knobs,
    *,
    gamma: float = 1.0,
    most_pictures: int = MOST_PICTURES,
) -> Steps[Found]:
    """Turn the knobs until the patches match.

    Args:
        camera: Name of the camera.
        target: What it shall look like.
        knobs: As they are.
        gamma: Of the camera.
        most_pictures: How many pictures may be taken.
    """
    tries: list[Try] = []
    learner = _Learner()
    short = (0.0, 0.0, 0.0)
    while len(tries) < most_pictures:
        picture = yield from capture(camera, f"settings {len(tries) + 1}")
        now = Try(knobs=knobs, picture=picture, match=match(target, picture.pixels, gamma))
        if tries:
            learner.learn(tries[-1], now)
        tries.append(now)
        yield from tell(
            f"picture {len(tries)}: mean difference {now.match.fit_error:.1f} grey levels",
            len(tries),
            most_pictures,
        )
        plan = knobs.plan(learner.step(_wanted(now.match)))
        if _is_settled(tries) and not _has_better_shutter(knobs, plan):
            break
        short = plan.short
        before = knobs.values
        knobs = yield from turn(camera, knobs, plan.values)
        if knobs.values == before:
            break
    least = min(_cost(one) for one in tries)
    # Of those that look the same, the last one: its shutter lets less flicker through.
    best = next(one for one in reversed(tries) if _cost(one) <= least + DONE_ERROR / 2.0)
    if best is not tries[-1] or knobs.values != best.knobs.values:
        knobs = yield from turn(camera, knobs, best.knobs.values)
    return Found(best=best, tries=tuple(tries), short=short, has_effect=learner.has_effect)


class _Learner:
    """How much of a wanted change pictures really show, by channel."""

    def __init__(self) -> None:
        self._response = [1.0, 1.0, 1.0]
        self._effects: list[float] = []

    @property
    def has_effect(self) -> bool:
        """Whether at least one large step was seen in the pictures."""
        return not self._effects or max(self._effects) > _LEAST_EFFECT

    def learn(self, before: Try, after: Try) -> None:
        """Compare what two pictures differ in with what their knobs do."""
        if not (before.match.is_readable and after.match.is_readable):
            return
        turned = after.knobs.exposure_log - before.knobs.exposure_log
        seen = [b - a for b, a in zip(before.match.log_ratios, after.match.log_ratios, strict=True)]
        if abs(turned) > _LEAST_LEARNED_STEP:
            self._effects.append(seen[1] / turned)
            self._update(1, seen[1] / turned)
        for index, name in ((0, "red"), (2, "blue")):
            first: Knobs = before.knobs
            second: Knobs = after.knobs
            old = first.red if name == "red" else first.blue
            new = second.red if name == "red" else second.blue
            if old is None or new is None or abs(new.log - old.log) <= _LEAST_LEARNED_STEP:
                continue
            share = (seen[index] - seen[1]) / (new.log - old.log)
            self._effects.append(share)
            self._update(index, share)

    def step(self, wanted: tuple[float, float, float]) -> tuple[float, float, float]:
        """Return what to turn the knobs by, ln light, so that pictures change as wanted."""
        green = wanted[1] / self._response[1]
        red = green + (wanted[0] - wanted[1]) / self._response[0]
        blue = green + (wanted[2] - wanted[1]) / self._response[2]
        return red, green, blue

    def _update(self, index: int, response: float) -> None:
        low, high = _RESPONSE_RANGE
        self._response[index] = min(max(response, low), high)


def _wanted(seen: Match) -> tuple[float, float, float]:
    """Return what the next picture's light shall change by, ln by channel."""
    if _is_exposed(seen):
        return seen.log_ratios
    if seen.clipped_share >= seen.dark_share and seen.clipped_share > 0.0:
        return (_DARKER,) * 3
    if seen.usable == 0:
        return (_BRIGHTER,) * 3
    return seen.log_ratios


def _has_better_shutter(knobs: Knobs, plan: Plan) -> bool:
    """Return whether the same light would come with a shutter that suits lamps and gain more."""
    shutter = knobs.shutter
    if shutter is None or not shutter.is_absolute:
        return False
    return abs(shutter.log_of(plan.values["shutter"]) - shutter.log) > _SHUTTER_LOG


def _is_exposed(seen: Match) -> bool:
    """Return whether a picture tells what is missing."""
    return seen.is_readable and seen.clipped_share <= _MOST_CLIPPED_SHARE


def _is_settled(tries: list[Try]) -> bool:
    """Return whether nothing more is to be gained."""
    last = tries[-1].match
    if _is_exposed(last):
        if max(abs(log) for log in last.log_ratios) < _LEAST_LOG_STEP:
            return True
        if last.fit_error <= DONE_ERROR / 2.0:
            return True
    costs = [_cost(one) for one in tries if _is_exposed(one.match)]
    recent = costs[-_PATIENCE:]
    return len(costs) > _PATIENCE and min(costs[:-_PATIENCE]) <= min(recent)


def _cost(one: Try) -> float:
    """Return how far a picture is from the target; the held-out half is not asked."""
    missing = 255.0 * (one.match.clipped_share + one.match.dark_share)
    off = max(abs(log) for log in one.match.log_ratios)
    return min(one.match.fit_error, 255.0) + missing + off
