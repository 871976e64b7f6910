"""The reference page of profiles, made from the models: `python -m cell.profile.reference`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from cell.profile.cell import CellProfile, Profile
from cell.profile.rules import rule_sentences
from cell.profile.schema import FieldFacts, Node, Schema, schema_of
from cell.profile.validation import PLAYGROUND_TABLES

PAGE: Final = Path(__file__).parents[2] / "docs" / "reference" / "profile.md"

_INTRODUCTION: Final = """\
# Profiles

A profile is a TOML file with every figure in which one cell differs from another. Shipped
ones go by their names (`cell profile list`); your own go by name when they are in the folder
that `cell profile list` tells, and by path (ending in `.toml`) from anywhere.

`cell profile new NAME` writes one with every field explained, `cell profile check` shows all
mistakes with their lines, `cell profile show` tells every value and where it came from,
`cell profile diff` compares two by meaning.

A key that is not known is a mistake, and so is a value of the wrong type: TOML tells numbers
from texts. Names of fields end in their unit. A profile holds no secrets; it names the
environment variables that do.

This page is made from the models by `python -m cell.profile.reference`.
"""


def reference_page() -> str:
    """Return the page as Markdown."""
    schema, playground = schema_of(CellProfile), schema_of(Profile)
    sections = [_INTRODUCTION]
    sections += _section("The whole file", "", schema, schema.root)
    extra = [f for f in playground.fields(playground.root) if f.name in PLAYGROUND_TABLES]
    sections.append(
        "A cell with a playground has these as well, and its arm is a `melfa-rv6sdl`:\n\n"
        + _field_rows(extra, playground)
    )
    for field in schema.fields(schema.root):
        sections += _sections_below(field, field.name, schema)
    for field in extra:
        sections += _sections_below(field, field.name, playground)
    rules = "\n".join(f"- {sentence}" for sentence in rule_sentences())
    sections.append(f"## What fields must be to each other\n\n{rules}\n")
    return "\n".join(sections)


def _sections_below(field: FieldFacts, path: str, schema: Schema) -> Iterator[str]:
    """Yield a section for the table that a field holds, and for those within it."""
    variants = schema.variants(field.node)
    if variants:
        for model, node in variants.items():
            yield from _with_inner(f'{path}.model = "{model}"', path, node, schema)
        return
    element = schema.element(field.node)
    if element is not None:
        below = f"[[{path}]]" if field.expected == "a list of tables" else f"[{path}.NAME]"
        yield from _with_inner(below, f"{path}.NAME", element, schema)
    elif field.expected == "a table":
        yield from _with_inner(f"[{path}]", path, schema.table(field.node, {}), schema)


def _with_inner(title: str, path: str, node: Node, schema: Schema) -> Iterator[str]:
    if not schema.fields(node):
        return
    yield from _section(f"`{title}`", schema.summary(node), schema, node)
    for field in schema.fields(node):
        yield from _sections_below(field, f"{path}.{field.name}", schema)


def _section(title: str, summary: str, schema: Schema, node: Node) -> Iterator[str]:
    words = f"{summary}\n\n" if summary else ""
    yield f"## {title}\n\n{words}{_field_rows(schema.fields(node), schema)}"


def _field_rows(fields: list[FieldFacts] | tuple[FieldFacts, ...], schema: Schema) -> str:
    rows = [
        "| field | takes | unit | default | what it is for |",
        "| --- | --- | --- | --- | --- |",
    ]
    for field in fields:
        cells = (f"`{field.name}`", _takes(field, schema), field.unit, _default(field), field.words)
        rows.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(rows) + "\n"


def _takes(field: FieldFacts, schema: Schema) -> str:
    return "a table, chosen by its `model`" if schema.variants(field.node) else field.expected


def _default(field: FieldFacts) -> str:
    if field.is_required:
        return "**must be given**"
    if field.default is None or field.expected.startswith("a list of tables"):
        return "none"
    if isinstance(field.default, dict):
        return "its defaults" if field.default else "none"
    return f"`{json.dumps(field.default, ensure_ascii=False)}`"


def write_reference(page: Path = PAGE) -> None:
    """Write the page."""
    page.write_text(reference_page(), "utf-8")


if __name__ == "__main__":
    write_reference()
