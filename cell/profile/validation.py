"""From what pydantic says of a document to findings: where, what was given, what is allowed."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from cell.profile.cell import CellProfile, Profile
from cell.profile.findings import Finding, dotted
from cell.profile.schema import Schema, schema_of
from cell.profile.toml_places import KeyPath, Place, TomlPlaces

Document = Mapping[str, object]

PLAYGROUND_TABLES: Final = tuple(
    k for k in Profile.model_fields if k not in CellProfile.model_fields
)
_TOP: Final = Place(0, 1, 1, 1)
_UNKNOWN_KEY: Final = ("extra_forbidden", "unexpected_keyword_argument")
_SECRETS: Final = ("password", "passwd", "secret", "token", "api_key", "key")


class Explainer:
    """Explains the mistakes of one document."""

    def __init__(self, model: type[CellProfile], data: Document, places: TomlPlaces) -> None:
        self._model = model
        self._schema: Schema = schema_of(model)
        self._data = data
        self._places = places
        self._suggested: set[KeyPath] = set()

    def findings(self, error: ValidationError) -> list[Finding]:
        """Return a finding for each mistake; one list of a wrong length is one mistake."""
        errors = [(self._path(one), one) for one in error.errors()]
        unknown = [(path, one) for path, one in errors if one["type"] in _UNKNOWN_KEY]
        found = [self._unknown(path) for path, _ in unknown]
        explained: set[KeyPath] = set()
        for path, one in errors:
            is_gap = one["type"] == "missing" and isinstance(path[-1], int)
            about = path[:-1] if is_gap else path
            if one["type"] in _UNKNOWN_KEY or about in explained or about in self._suggested:
                continue
            explained.add(about)
            found.append(self._explained(about, one))
        return found

    def _path(self, error: ErrorDetails) -> KeyPath:
        """Return the path of a mistake, without the arm's model that pydantic puts in."""
        path: KeyPath = ()
        data: object = self._data
        for number, part in enumerate(error["loc"]):
            is_last = number == len(error["loc"]) - 1
            if isinstance(data, dict) and part not in data and not is_last:
                continue
            if isinstance(part, str) and isinstance(data, list):
                continue
            path = (*path, part)
            data = _within(data, part)
        return path

    def _explained(self, path: KeyPath, error: ErrorDetails) -> Finding:
        if error["type"] == "missing" and _within_path(self._data, path) is None:
            return self._missing(path)
        if error["type"] == "union_tag_not_found":
            return self._missing((*path, "model"))
        if error["type"] == "union_tag_invalid":
            path = (*path, "model")
        return self._wrong_value(path, _own_words(error))

    # The three sorts of mistakes

    def _missing(self, path: KeyPath) -> Finding:
        table, name = path[:-1], str(path[-1])
        facts = self._schema.facts(path, self._data)
        where = f"[{dotted(table)}]" if table else "the profile"
        if facts is None:
            expected, words, unit = self._arm_models(table), "", ""
        else:
            expected, words, unit = facts.expected, facts.words, facts.unit
        if expected.startswith("a table"):
            message = f"{where} has no table `{name}`"
        else:
            message = f"{where} has no `{name}`: {expected}{_in(unit)} is needed"
        place = self._places.enclosing(path) or _TOP
        return Finding(
            severity="error", field=dotted(path), place=place, message=message, hint=words
        )

    def _unknown(self, path: KeyPath) -> Finding:
        table, name = path[:-1], str(path[-1])
        node = self._schema.node(table, self._data)
        known = [] if node is None else [f.name for f in self._schema.fields(node)]
        where = f"in [{dotted(table)}]" if table else "at the top of the profile"
        return Finding(
            severity="error",
            field=dotted(path),
            place=self._places.of_key(path) or _TOP,
            message=f"unknown key `{name}` {where}",
            hint=self._advice(table, name, known),
        )

    def _wrong_value(self, path: KeyPath, words: str = "") -> Finding:
        value = _within_path(self._data, path)
        node = self._schema.node(path, self._data)
        facts = self._schema.facts(path, self._data)
        choices = () if node is None else self._schema.choices(node)
        if path[-1:] == ("model",) and not choices:
            expected, choices = self._arm_models(path[:-1]), self._arms(path[:-1])
        else:
            expected = "another value" if node is None else self._schema.expected(node)
        unit = facts.unit if facts is not None else ""
        given = f"is {shown(value)}; allowed: {expected}{_in(unit)}"
        message = f"`{dotted(path)}` {words or given}"
        hint = "" if facts is None else facts.words
        near = difflib.get_close_matches(str(value), [str(one) for one in choices], 1, 0.5)
        if near:
            hint = f'did you mean "{near[0]}"?'
        place = self._places.of_value(path) or self._places.enclosing(path) or _TOP
        return Finding(
            severity="error", field=dotted(path), place=place, message=message, hint=hint
        )

    # Advice

    def _advice(self, table: KeyPath, name: str, known: Sequence[str]) -> str:
        if not table and name in PLAYGROUND_TABLES and self._model is not Profile:
            return "only a cell with a playground has it, and its arm is a melfa-rv6sdl"
        near = difflib.get_close_matches(name, known, 1, 0.6)
        if near:
            self._suggested.add((*table, near[0]))
            return f"did you mean `{near[0]}`?"
        if any(name == word or name.endswith(f"_{word}") for word in _SECRETS):
            variables = [one for one in known if one.endswith("_variable")]
            named = f"`{variables[0]}`" if variables else "a variable"
            return f"a profile holds no secrets; name the environment variable in {named}"
        homes = [dotted(home) for home in self._homes(name) if home != table]
        if homes:
            return f"it belongs in {' or '.join(f'[{home}]' for home in homes[:3])}"
        return f"known are {', '.join(known)}" if known else ""

    def _homes(self, name: str) -> Iterator[KeyPath]:
        """Yield the tables of the document in which a key would be known."""
        for path in _tables(self._data):
            node = self._schema.node(path, self._data)
            if node is not None and any(f.name == name for f in self._schema.fields(node)):
                yield path

    def _arms(self, table: KeyPath) -> tuple[object, ...]:
        node = self._schema.node(table, {})
        return () if node is None else tuple(self._schema.variants(node))

    def _arm_models(self, table: KeyPath) -> str:
        return f"one of {', '.join(shown(one) for one in self._arms(table))}"


def _own_words(error: ErrorDetails) -> str:
    """Return what a field's own check has to say, empty where pydantic's types refused."""
    cause = error.get("ctx", {}).get("error")
    return str(cause) if error["type"] == "value_error" and cause is not None else ""


def shown(value: object) -> str:
    """Return a value as TOML writes it, cut where it is long."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "a list of tables"
    if isinstance(value, list):
        text = f"[{', '.join(shown(one) for one in value)}]"
        counted = f" ({len(value)} value{'' if len(value) == 1 else 's'})"
        return (text if len(text) <= 60 else text[:57] + "...") + counted
    if isinstance(value, (str, bool)):
        text = json.dumps(value, ensure_ascii=False)
        return text if len(text) <= 60 else text[:57] + '..."'
    return f"{value}"


def _in(unit: str) -> str:
    return f" ({unit})" if unit else ""


def _within(data: object, part: str | int) -> object:
    if isinstance(data, dict):
        return data.get(part)
    if isinstance(data, list) and isinstance(part, int) and part < len(data):
        return data[part]
    return None


def _within_path(data: object, path: KeyPath) -> object:
    for part in path:
        data = _within(data, part)
    return data


def _tables(data: object, path: KeyPath = ()) -> Iterator[KeyPath]:
    if isinstance(data, dict):
        yield path
        for key, inner in data.items():
            yield from _tables(inner, (*path, key))
    elif isinstance(data, list):
        for number, inner in enumerate(data):
            yield from _tables(inner, (*path, number))
