"""What fields of a profile must be to each other: each rule names the tables it looks at.

A rule runs only when all its tables are sound by themselves, so one mistake is told once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from cell.profile.cell import CellProfile, Profile
from cell.profile.rules.arm import ARM_RULES
from cell.profile.rules.cameras import CAMERA_RULES, CAMERA_TWIN_RULES
from cell.profile.rules.playground import PLAYGROUND_RULES
from cell.profile.rules.problem import Problem
from cell.profile.rules.surroundings import SURROUNDINGS_RULES
from cell.profile.rules.wires import WIRE_RULES

__all__ = ["Problem", "broken_rules", "rule_sentences"]

_EVERYWHERE: Final = (*ARM_RULES, *WIRE_RULES, *CAMERA_RULES, *SURROUNDINGS_RULES)
_ON_PLAYGROUNDS: Final = (*PLAYGROUND_RULES, *CAMERA_TWIN_RULES)


def broken_rules(profile: CellProfile, sound: Sequence[str]) -> list[Problem]:
    """Return what does not go together in a profile.

    Args:
        profile: The profile; tables that are not sound may be missing in it.
        sound: Names of the tables that are there.
    """
    found = [
        p for rule in _EVERYWHERE if set(rule.needs) <= set(sound) for p in rule.check(profile)
    ]
    if isinstance(profile, Profile):
        for rule in _ON_PLAYGROUNDS:
            if set(rule.needs) <= set(sound):
                found += rule.check(profile)
    return found


def rule_sentences() -> list[str]:
    """Return what each rule asks for, in a sentence."""
    return [rule.check.__doc__ or "" for rule in (*_EVERYWHERE, *_ON_PLAYGROUNDS)]
