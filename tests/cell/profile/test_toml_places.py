from __future__ import annotations

import random
import tomllib
from datetime import date, datetime

import pytest

from cell.profile import profile_text, shipped_profiles
from cell.profile.toml_places import KeyPath, Place, TomlPlaces, locate, place_at


def leaves(value: object, path: KeyPath = ()) -> dict[KeyPath, object]:
    """Return every value of a document that is neither table nor array, by its path."""
    if isinstance(value, dict):
        return {p: v for key, one in value.items() for p, v in leaves(one, (*path, key)).items()}
    if isinstance(value, list):
        return {p: v for i, one in enumerate(value) for p, v in leaves(one, (*path, i)).items()}
    return {path: value}


def require_every_place_to_hold_its_value(text: str, note: str) -> TomlPlaces:
    found = locate(text)
    for path, value in leaves(tomllib.loads(text)).items():
        place = found.values[path]
        written = text[place.start : place.end]
        assert tomllib.loads(f"x = {written}")["x"] == value, f"{note}: {path}"
        lines = text.split("\n")
        assert lines[place.line - 1][place.column - 1 :].startswith(written.split("\n")[0]), note
    return found


@pytest.mark.parametrize("name", shipped_profiles())
def test_every_value_of_a_shipped_profile_is_where_it_is_said_to_be(name: str) -> None:
    require_every_place_to_hold_its_value(profile_text(name), name)


DOCUMENT = r'''# a comment with [brackets] and "quotes
title = "a \"quoted\" # no comment" # a comment
'literal key' = 'C:\path'
"with \u00e9" . inner = """
several "lines" ] }
of \""" text"""
raw = \'\'\'a 'b' \'\'\'
quotes = """two quotes"""""
a.b.c = 1
a.b . d = 1979-05-27 07:32:00   # a date with a blank
nested = [ [1, 2], ["x]", '}'], # inside
  { k = 1, "l m" = [ ] } ,
]
empty = {}
[table . "sub.table"]
key = -1.5e-3
[[array]]
n = 0
[[array.inner]]
m = 1
[[array.inner]]
m = 2
[array.inner.deep]
o = 3
[[array]]
n = 1
[[array.inner]]
m = 4
'''.replace("\\'\\'\\'", "'''")


def test_every_form_of_key_and_value_is_found() -> None:
    found = require_every_place_to_hold_its_value(DOCUMENT, "document")
    assert (
        found.values[("array", 0, "inner", 1, "deep", "o")].line
        == DOCUMENT.split("\n").index("o = 3") + 1
    )
    assert found.values[("array", 1, "inner", 0, "m")].line > found.tables[("array", 1)].line
    assert ("empty",) in found.values


def test_line_and_column_count_from_one() -> None:
    found = locate("\n  port = 'x'\n")
    assert found.keys[("port",)] == Place(3, 7, 2, 3)
    assert found.values[("port",)] == Place(10, 13, 2, 10)


def test_a_missing_key_leads_to_the_table_that_lacks_it() -> None:
    found = locate("[a]\nx = { y = 1 }\n[b.c]\nz = 1\n")
    assert found.enclosing(("a", "x", "q")) == found.keys[("a", "x")]
    assert found.enclosing(("a", "q")) == found.tables[("a",)]
    assert found.enclosing(("b", "c", "deep", "deeper")) == found.tables[("b", "c")]
    assert found.enclosing(("b", "q")) == found.tables[("b", "c")]
    assert found.enclosing(("q",)) is None


def test_a_key_given_twice_is_found_at_both_places() -> None:
    found = locate("[a]\nx = 1\ny = 2\nx = 3\n")
    ((path, again),) = found.repeated
    assert path == ("a", "x")
    assert (found.keys[path].line, again.line) == (2, 4)


def test_a_table_given_twice_is_found_at_both_places() -> None:
    found = locate("[a]\nx = 1\n[b]\n[a]\n")
    ((path, again),) = found.repeated
    assert path == ("a",)
    assert again.line == 4


def test_a_place_stays_within_the_text() -> None:
    assert place_at("ab\ncd", 2, 1) == Place(3, 4, 2, 1)
    assert place_at("ab\ncd", 9, 9) == Place(5, 6, 2, 3)


BARE = "abcxyz-_0"
WEIRD = "a .]}\"'\\#=é\u20ac"


def random_key(chance: random.Random) -> str:
    name = "".join(chance.choices(BARE, k=chance.randint(1, 4)))
    other = "".join(c for c in chance.choices(WEIRD, k=4) if c not in "'\\\"")
    return chance.choice([name, name, f'"{other}{name}"', f"'{name}{other}'"])


def random_value(chance: random.Random, depth: int) -> str:
    kind = chance.randint(0, 11 if depth else 8)
    plain = [
        str(chance.randint(-99, 99)),
        f"{chance.random():.3f}",
        "true",
        date(2026, 1, chance.randint(1, 28)).isoformat(),
        str(datetime(2026, 1, 1, 2, 3, chance.randint(0, 59))),
        '"a \\" ] } # = \\\\"',
        "'b \" ] } # \\'",
        '"""m\n\n ] " "" \\""" # """',
        "'''n\n ' '' ] '''",
    ]
    if kind < len(plain):
        return plain[kind]
    if kind == 11:
        keys = {random_key(chance): None for _ in range(chance.randint(0, 3))}
        return "{ " + ", ".join(f"{k} = {random_value(chance, 0)}" for k in keys) + " }"
    gap = chance.choice(["", " ", "\n  ", " # ] }\n"])
    inner = [random_value(chance, depth - 1) for _ in range(chance.randint(0, 4))]
    return f"[{gap}" + f"{gap},{gap}".join(inner) + f"{gap}]"


def random_document(chance: random.Random) -> str:
    """Return a text that may be TOML: keys may be given twice."""
    lines = []
    for _ in range(chance.randint(1, 12)):
        path = chance.choice([" . ", "."]).join(
            random_key(chance) for _ in range(chance.randint(1, 3))
        )
        kind = chance.randint(0, 9)
        if kind == 0:
            lines.append(f"[{path}]  # header")
        elif kind == 1:
            lines.append(f"[[{path}]]")
        elif kind == 2:
            lines.append(chance.choice(["", "   ", "# [x] = 1"]))
        else:
            lines.append(f"{path} = {random_value(chance, 2)}")
    return "\n".join(lines) + chance.choice(["", "\n", "\n\n# end"])


def test_random_documents_are_located_as_they_are_read() -> None:
    valid = 0
    for seed in range(1500):
        text = random_document(random.Random(seed))
        try:
            tomllib.loads(text)
        except tomllib.TOMLDecodeError:
            locate(text)
            continue
        valid += 1
        require_every_place_to_hold_its_value(text, f"seed {seed}")
    assert valid > 500


def test_any_text_is_located_without_an_error() -> None:
    sample = profile_text("mash")
    for seed in range(300):
        chance = random.Random(seed)
        cut = chance.randrange(len(sample))
        noise = "".join(chance.choices("[]{}=\"'#.,\n\\ a1", k=chance.randint(0, 12)))
        locate(sample[:cut] + noise + sample[cut + chance.randint(0, 9) :])
