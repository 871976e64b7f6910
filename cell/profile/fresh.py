"""The text of a new profile: every field with what it is for, its unit and what it takes."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from cell.profile.checking import check_profile
from cell.profile.findings import dotted
from cell.profile.schema import FieldFacts, Schema, schema_of
from cell.profile.sources import ProfileSource
from cell.profile.toml_places import KeyPath

_WIDTH: Final = 96
Document = Mapping[str, object]


def fresh_profile(name: str, base: ProfileSource, ports: Mapping[str, str] | None = None) -> str:
    """Return the text of a new profile.

    Args:
        name: Name of the new cell.
        base: The profile whose figures it begins with.
        ports: Serial ports by device, such as `{"arm": "/dev/ttyUSB0"}`; those of the base
            unless given.

    Raises:
        InvalidProfile: The base has mistakes.
        ProfileError: The name is none that a cell can have.
    """
    profile = check_profile(base).require()
    data = dict(tomllib.loads(base.text))
    data["name"] = name
    for device, port in (ports or {}).items():
        _set_port(data, device, port)
    schema = schema_of(type(profile))
    rows = [
        f"# The cell {name}.",
        f"# The figures are those of {base.name} until you change them; above all look at ports,",
        "# camera identities, boxes, heights and the place of the store.",
        "# A line `# key = value` shows a default: take the # away to change it.",
        f"# `cell profile check {name}` tells what is wrong, line by line.",
        "",
        *_table((), data, schema, data),
    ]
    text = "\n".join(rows).rstrip() + "\n"
    check_profile(replace(base, name=f"{name}.toml", text=text)).require()
    return text


def _set_port(data: dict[str, object], device: str, port: str) -> None:
    table = data.get(device)
    if isinstance(table, dict) and isinstance(table.get("serial"), dict):
        serial = {k: v for k, v in table["serial"].items() if k != "usb_serial"}
        data[device] = {**table, "serial": {**serial, "port": port}}


def _table(path: KeyPath, table: Document, schema: Schema, data: Document) -> Iterator[str]:
    """Yield the lines of a table: its own fields first, then the tables within it."""
    node = schema.node(path, data)
    fields = () if node is None else schema.fields(node)
    inner: list[FieldFacts] = []
    for field in fields:
        value = table.get(field.name)
        if field.name in table and not _is_table(value):
            yield from _comment(_explained(field))
            yield f"{_key(field.name)} = {written(value)}"
        elif field.name in table:
            inner.append(field)
        elif not _is_table_node(schema, field):
            yield from _comment(_explained(field))
            yield f"# {_key(field.name)} = {written(field.default)}"
    for field in inner:
        yield from _inner((*path, field.name), table[field.name], field, schema, data)


def _inner(
    path: KeyPath, value: object, field: FieldFacts, schema: Schema, data: Document
) -> Iterator[str]:
    if isinstance(value, list):
        for number, one in enumerate(value):
            yield ""
            yield from () if number else _comment(field.words)
            yield f"[[{dotted(path)}]]"
            yield from _table((*path, number), one, schema, data)
        return
    entries = value if isinstance(value, dict) else {}
    yield ""
    yield from _comment(field.words)
    if schema.element(field.node) is None:
        yield f"[{dotted(path)}]"
        yield from _table(path, entries, schema, data)
        return
    for number, (key, one) in enumerate(entries.items()):
        yield from [""] if number else []
        yield f"[{dotted((*path, key))}]"
        yield from _table((*path, key), one, schema, data)


def _explained(field: FieldFacts) -> str:
    takes = field.expected + (f", in {field.unit}" if field.unit else "")
    return f"{field.words} Takes {takes}."


def _is_table(value: object) -> bool:
    return isinstance(value, dict) or (
        isinstance(value, list) and bool(value) and isinstance(value[0], dict)
    )


def _is_table_node(schema: Schema, field: FieldFacts) -> bool:
    return field.expected.startswith(("a table", "a list of tables")) or field.default is None


def _comment(text: str) -> Iterator[str]:
    line = "#"
    for word in text.split():
        if len(line) + 1 + len(word) > _WIDTH:
            yield line
            line = "#"
        line += f" {word}"
    if line != "#":
        yield line


def _key(name: str) -> str:
    return dotted((name,))


def written(value: object) -> str:
    """Return a value that is no table as TOML."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(written(one) for one in value)}]"
    if isinstance(value, (bool, str)):
        return json.dumps(value, ensure_ascii=False)
    return f"{value}"
