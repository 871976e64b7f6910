"""What is around the cell: boxes in the arm's way, and secrets that a profile must not hold."""

from __future__ import annotations

import re
from collections.abc import Iterator

from cell.profile.cell import CellProfile
from cell.profile.findings import dotted
from cell.profile.rules.problem import Problem, Rule
from cell.profile.toml_places import KeyPath

_USERINFO = re.compile(r"^https?://[^/@\s]*:[^/@\s]+@")
_VARIABLE = re.compile(r"^[A-Za-z_][A-Za-z0-9_]*$")


def _boxes(profile: CellProfile) -> Iterator[Problem]:
    """Every box reaches from less to more along x, y and z, and has a name of its own."""
    names: dict[str, int] = {}
    for number, box in enumerate(profile.boxes):
        first = names.setdefault(box.name, number)
        if first != number:
            yield Problem(
                ("boxes", number, "name"),
                f'two boxes are called "{box.name}"; refusals must tell them apart',
                other=("boxes", first, "name"),
            )
        for axis, (low, high) in enumerate(zip(box.min_mm, box.max_mm, strict=True)):
            if low >= high:
                yield Problem(
                    ("boxes", number, "max_mm", axis),
                    f'the box "{box.name}" reaches from {low:g} to {high:g} mm along '
                    f"{'xyz'[axis]}: its greatest must be above its least",
                    other=("boxes", number, "min_mm", axis),
                )


def _secrets(profile: CellProfile) -> Iterator[Problem]:
    """Warning: an address with a password in it, or a secret where its variable is named."""
    urls: list[tuple[KeyPath, str]] = []
    variables: list[tuple[KeyPath, str]] = []
    if "web_camera" in profile.__dict__ and profile.web_camera is not None:
        variables.append(
            (("web_camera", "password_variable"), profile.web_camera.password_variable)
        )
    reports = profile.reports
    if reports.bugzilla is not None:
        urls.append((("reports", "bugzilla", "url"), reports.bugzilla.url))
        variables.append((("reports", "bugzilla", "key_variable"), reports.bugzilla.key_variable))
    if reports.webhook is not None:
        urls.append((("reports", "webhook", "url"), reports.webhook.url))
    for path, url in urls:
        if _USERINFO.match(url):
            yield Problem(
                path,
                f"`{dotted(path)}` holds a password",
                "take it out of the address; profiles are copied and recorded with every session",
                severity="warning",
            )
    for path, variable in variables:
        if variable and not _VARIABLE.match(variable):
            yield Problem(
                path,
                f"`{dotted(path)}` is no name of an environment variable; is it the secret itself?",
                "put the secret into an environment variable and its name here",
                severity="warning",
            )


SURROUNDINGS_RULES = (Rule(("boxes",), _boxes), Rule(("reports",), _secrets))
