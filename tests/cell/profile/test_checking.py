from __future__ import annotations

import random
from pathlib import Path

import pytest

from cell.errors import ProfileError
from cell.profile import (
    CellProfile,
    InvalidProfile,
    Profile,
    load_cell_profile,
    load_profile,
    parse_profile,
    profile_text,
    shipped_profiles,
)
from cell.profile.checking import CheckedProfile, check_profile
from cell.profile.findings import Finding, render_findings
from cell.profile.rules import rule_sentences
from cell.profile.sources import ProfileSource, find_profile
from tests.cell.profile.mistakes import MISTAKES, WARNINGS, Mistake

MASH = profile_text("mash")


def changed(mistake: Mistake) -> str:
    assert mistake.old in MASH
    return MASH.replace(mistake.old, mistake.new, 1)


def checked(text: str) -> CheckedProfile:
    return check_profile(ProfileSource("cell.toml", text))


def require(mistake: Mistake, finding: Finding, text: str) -> None:
    lines = text.split("\n")
    assert mistake.line in lines[finding.place.line - 1]
    assert finding.field == mistake.field
    assert mistake.message in finding.message
    assert mistake.hint in finding.hint
    if mistake.other:
        assert finding.other is not None
        assert mistake.other in lines[finding.other.line - 1]


@pytest.mark.parametrize("name", shipped_profiles())
def test_a_shipped_profile_has_neither_mistakes_nor_warnings(name: str) -> None:
    assert check_profile(find_profile(name)).findings == ()


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda m: m.name)
def test_a_mistake_is_told_once_with_its_line_and_what_is_allowed(mistake: Mistake) -> None:
    text = changed(mistake)
    found = checked(text)
    assert found.profile is None
    errors = [one for one in found.errors if one.field == mistake.field]
    assert len(errors) == 1, [one.message for one in found.errors]
    require(mistake, errors[0], text)


FOLLOWED = {"number for a table", "missing table", "arm of another model"}


@pytest.mark.parametrize(
    "mistake", [m for m in MISTAKES if m.name not in FOLLOWED], ids=lambda m: m.name
)
def test_a_mistake_is_the_only_thing_told(mistake: Mistake) -> None:
    errors = checked(changed(mistake)).errors
    same_cause = {one.message for one in errors}
    if mistake.name == "block wider than the fingers":
        assert len(same_cause) == 3  # One for each kind of block.
    else:
        assert len(errors) == 1, [one.message for one in errors]


@pytest.mark.parametrize("mistake", WARNINGS, ids=lambda m: m.name)
def test_a_warning_is_told_and_the_profile_is_good(mistake: Mistake) -> None:
    text = changed(mistake)
    found = checked(text)
    assert isinstance(found.profile, Profile)
    (warning,) = found.findings
    assert warning.severity == "warning"
    require(mistake, warning, text)


def test_all_mistakes_are_told_at_once_in_the_order_of_the_text() -> None:
    text = MASH
    fields = set()
    for mistake in MISTAKES:
        if mistake.name in ("choice that is near", "whole number out of range", "infinity",
                            "two outputs with one bit", "box inside out"):  # fmt: skip
            text = text.replace(mistake.old, mistake.new, 1)
            fields.add(mistake.field)
    with pytest.raises(InvalidProfile) as caught:
        parse_profile(text, "cell.toml")
    found = caught.value.findings
    assert {one.field for one in found} == fields
    starts = [one.place.start for one in found]
    assert starts == sorted(starts)
    assert str(caught.value).endswith("5 errors, 0 warnings")


def test_a_finding_is_shown_like_a_compiler_shows_it() -> None:
    text = MASH.replace("magnet = 10", "magnet = 8")
    (finding,) = checked(text).errors
    row = text.split("\n").index("magnet = 8") + 1
    lights = row - 2
    assert render_findings([finding], text, "cell.toml") == (
        "error: output 8 switches both lights and magnet\n"
        f"   --> cell.toml:{row}:10\n"
        "    |\n"
        f" {row} | magnet = 8\n"
        "    |          ^\n"
        "    :\n"
        f" {lights} | lights = 8\n"
        "    |          -\n"
        "    = hint: give each its own bit, as it is wired\n"
        "\n"
        "1 error, 0 warnings"
    )


def test_a_terminal_gets_colours_and_nothing_that_moves_its_cursor() -> None:
    text = MASH.replace('name = "mash"', 'name = "\\u001b[2Jx"')
    found = checked(text)
    shown = render_findings(found.errors, text, "cell.toml", colour=True)
    assert "\x1b[31m" in shown
    assert "\x1b[2J" not in shown


def test_no_two_devices_on_one_port_unless_one_is_disabled() -> None:
    text = MASH.replace('"COM8"', '"COM9"').replace(
        'model = "schunk-pg70"', 'model = "schunk-pg70"\nenabled = false'
    )
    assert checked(text).errors == ()


def test_a_byte_order_mark_and_carriage_returns_do_not_matter(tmp_path: Path) -> None:
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + MASH.replace("\n", "\r\n").encode())
    assert load_profile(str(path)) == load_profile("mash")


def test_a_cell_without_a_playground_is_refused_where_one_is_needed() -> None:
    assert isinstance(load_cell_profile("avrs"), CellProfile)
    with pytest.raises(ProfileError, match="avrs is a cell without a playground"):
        load_profile("avrs")


def test_a_playground_table_in_another_cell_says_who_may_have_it() -> None:
    text = profile_text("avrs") + "\n[heights]\nsurface_mm = 1\n"
    (error,) = checked(text).errors
    assert "unknown key `heights`" in error.message
    assert "melfa-rv6sdl" in error.hint


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nope", "there is no profile 'nope'; shipped are avrs, lynx, mash"),
        ("nope.toml", "there is no file nope.toml"),
        ("no/where", "there is no file no/where"),
        ("/", "cannot be read"),
        ("\0", "'\\x00'"),
        ("", "there is no profile ''"),
    ],
)
def test_a_profile_that_is_not_there_is_a_sentence(name: str, said: str) -> None:
    with pytest.raises(ProfileError) as caught:
        load_profile(name)
    assert said in str(caught.value)


def test_a_profile_that_is_no_text_is_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b"name = '\xff'")
    with pytest.raises(ProfileError, match="is not UTF-8 text"):
        load_profile(str(path))


def test_an_own_profile_is_found_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    folder = tmp_path / "robocell" / "profiles"
    folder.mkdir(parents=True)
    (folder / "mine.toml").write_text(MASH.replace('"mash"', '"mine"', 1), "utf-8")
    (folder / "mash.toml").write_text("a shipped name is not taken from here", "utf-8")
    assert load_profile("mine").name == "mine"
    assert load_profile("mash").name == "mash"


def test_any_damage_gives_findings_and_never_another_error() -> None:
    damaged = 0
    for seed in range(400):
        chance = random.Random(seed)
        lines = MASH.split("\n")
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(len(lines))
            other = chance.choice(lines)
            lines[at] = chance.choice(
                ["", other, lines[at][: chance.randint(0, 30)], lines[at].replace("=", "= -"),
                 lines[at].replace("[", "", 1), f"x.{lines[at]}", lines[at].replace('"', "", 1)]
            )  # fmt: skip
        text = "\n".join(lines)
        found = checked(text)
        damaged += bool(found.errors)
        assert (found.profile is None) == bool(found.errors), f"seed {seed}"
        for one in found.findings:
            assert 1 <= one.place.line <= len(lines), f"seed {seed}"
        render_findings(found.findings, text, f"seed {seed}")
    assert damaged > 200


def test_every_rule_says_what_it_asks_for() -> None:
    assert all(sentence.endswith(".") for sentence in rule_sentences())
