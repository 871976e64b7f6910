"""What is known of each field of a profile: what it takes, its unit, its default, its words.

Made from the models: kinds, ranges and defaults from their JSON schema, the words from the
docstrings below the fields. Checks, the reference page and `cell profile` read it here.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, is_dataclass
from functools import cache
from typing import Final, cast, get_args

from pydantic import BaseModel

from cell.profile.cell import CellProfile
from cell.profile.glossary import GLOSSARY
from cell.profile.toml_places import KeyPath

Node = Mapping[str, object]
"""A node of a JSON schema."""

_UNITS: Final = (
    ("_mm_s2", "mm/s²"), ("_deg_s", "deg/s"), ("_mm_s", "mm/s"), ("_percent", "%"),
    ("_bytes", "bytes"), ("_deg", "deg"), ("_mm", "mm"), ("_px", "px"), ("_ms", "ms"),
    ("_db", "dB"), ("_ev", "EV"), ("_hz", "Hz"), ("_us", "µs"), ("_a", "A"), ("_s", "s"),
)  # fmt: skip
_NUMBERS: Final = {"integer": "whole number", "number": "number"}


def unit_of(name: str) -> str:
    """Return the unit that a field's name ends in, or an empty string."""
    if name == "baud":
        return "bit/s"
    return next((unit for ending, unit in _UNITS if name.endswith(ending)), "")


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldFacts:
    """What is known of one field.

    Attributes:
        name: Its key.
        node: Its part of the JSON schema.
        expected: What it takes, such as `a whole number from 1 to 3`.
        unit: Its unit, or an empty string.
        is_required: Whether it must be given.
        default: Its default, if it need not be given.
        words: What it is for.
        choices: The values allowed, where they are few.
    """

    name: str
    node: Node
    expected: str
    unit: str
    is_required: bool
    default: object
    words: str
    choices: tuple[object, ...]


class Schema:
    """The fields of one kind of profile."""

    def __init__(self, model: type[CellProfile]) -> None:
        self._root: Node = model.model_json_schema()
        self._words = _all_words(model)

    def fields(self, table: Node) -> tuple[FieldFacts, ...]:
        """Return the fields of a table; none for what is no table."""
        table = self._resolved(table)
        required = cast("list[str]", table.get("required", []))
        words = self._words.get(cast(str, table.get("title", "")), {})
        return tuple(
            FieldFacts(
                name=name,
                node=node,
                expected=self.expected(node),
                unit=unit_of(name),
                is_required=name in required,
                default=node.get("default"),
                words=words.get(name)
                or cast(str, node.get("description"))
                or GLOSSARY.get(name, ""),
                choices=self.choices(node),
            )
            for name, node in _children(table)
        )

    @property
    def root(self) -> Node:
        """The outermost table."""
        return self._root

    def summary(self, table: Node) -> str:
        """Return what a table is for."""
        return cast(str, self._resolved(table).get("description", ""))

    def node(self, path: KeyPath, data: object) -> Node | None:
        """Return the schema of a path, or None where nothing is known.

        Args:
            path: The path.
            data: The document; where there are several arms, its `model` says which.
        """
        node: Node | None = self._root
        for part in path:
            if node is None:
                return None
            node = self._child(self.table(node, data), part)
            data = _within(data, part)
        return None if node is None else self.table(node, data)

    def facts(self, path: KeyPath, data: object) -> FieldFacts | None:
        """Return what is known of the field at a path."""
        table = self.node(path[:-1], data)
        if table is None:
            return None
        return next((f for f in self.fields(table) if f.name == path[-1]), None)

    def table(self, node: Node, data: object) -> Node:
        """Return the very table that a node means for its data: an arm by its `model`."""
        node = self._resolved(node)
        variants = self.variants(node)
        if variants and isinstance(data, dict) and data.get("model") in variants:
            return variants[data["model"]]
        return node

    def variants(self, node: Node) -> dict[str, Node]:
        """Return the tables that a field may hold, by the `model` that chooses."""
        discriminator = cast("Mapping[str, Mapping[str, str]]", node.get("discriminator", {}))
        mapping = discriminator.get("mapping", {})
        return {model: self._resolved({"$ref": target}) for model, target in mapping.items()}

    def element(self, node: Node) -> Node | None:
        """Return what each entry of a list or of a table of named entries is."""
        inner = self._resolved(node)
        for key in ("items", "additionalProperties"):
            if isinstance(inner.get(key), dict):
                return self._resolved(cast(Node, inner[key]))
        return None

    def choices(self, node: Node) -> tuple[object, ...]:
        """Return the values that a field allows, where they are few."""
        node = self._resolved(node)
        if "const" in node:
            return (node["const"],)
        return tuple(cast("list[object]", node.get("enum", [])))

    def expected(self, node: Node) -> str:
        """Return what a field takes, as part of a sentence."""
        node = self._resolved(node)
        choices = self.choices(node)
        if choices:
            return _one_of(choices)
        kind = cast(str, node.get("type", ""))
        if kind in _NUMBERS:
            return f"a {_NUMBERS[kind]}{_range(node)}"
        if kind == "boolean":
            return "true or false"
        if kind == "string":
            return self._expected_text(node)
        if kind == "array":
            return self._expected_list(node)
        if self.element(node) is not None:
            return "a table of named tables"
        return "a table"

    def _expected_text(self, node: Node) -> str:
        if node.get("format") == "date":
            return "a date such as 2026-01-31"
        pattern = cast(str, node.get("pattern", ""))
        if pattern.startswith("^http"):
            return "an address such as http://192.168.0.90"
        if pattern:
            return "a name of letters, digits, '.', '-' and '_'"
        return "a text that is not empty" if node.get("minLength") else "a text"

    def _expected_list(self, node: Node) -> str:
        items = cast("list[Node]", node.get("prefixItems", []))
        if not items:
            return "a list of tables"
        inner = self._resolved(items[0])
        if inner.get("type") == "array":
            return f"{len(items)} lists of {self._expected_list(inner)}"
        whole = "whole numbers" if inner.get("type") == "integer" else "numbers"
        return f"{len(items)} {whole}{_range(inner)}"

    def _child(self, node: Node, part: str | int) -> Node | None:
        if isinstance(part, int):
            prefix = cast("list[Node]", node.get("prefixItems", []))
            return prefix[part] if part < len(prefix) else self.element(node)
        found = dict(_children(node)).get(part)
        return found if found is not None else self.element(node)

    def _resolved(self, node: Node) -> Node:
        """Return a node with references followed and the choice of nothing left out."""
        while True:
            if "$ref" in node:
                name = cast(str, node["$ref"]).rpartition("/")[2]
                node = cast("Mapping[str, Node]", self._root["$defs"])[name]
            elif "anyOf" in node:
                options = cast("list[Node]", node["anyOf"])
                node = next(one for one in options if one.get("type") != "null")
            else:
                return node


@cache
def schema_of(model: type[CellProfile]) -> Schema:
    """Return the schema of a kind of profile; made once."""
    return Schema(model)


def _children(node: Node) -> Iterator[tuple[str, Node]]:
    return iter(cast("Mapping[str, Node]", node.get("properties", {})).items())


def _within(data: object, part: str | int) -> object:
    if isinstance(data, dict):
        return data.get(part)
    if isinstance(data, list) and isinstance(part, int) and part < len(data):
        return data[part]
    return None


def _one_of(choices: tuple[object, ...]) -> str:
    shown = [f'"{one}"' if isinstance(one, str) else str(one) for one in choices]
    return shown[0] if len(shown) == 1 else f"{', '.join(shown[:-1])} or {shown[-1]}"


def _range(node: Node) -> str:
    """Return the range of a number: ` from 1 to 3`, ` above 0`, or nothing."""
    low, high, above = (node.get(key) for key in ("minimum", "maximum", "exclusiveMinimum"))
    if low is not None and high is not None:
        return f" from {_figure(low)} to {_figure(high)}"
    if above is not None and high is not None:
        return f" above {_figure(above)}, {_figure(high)} at most"
    if above is not None:
        return f" above {_figure(above)}"
    if high is not None:
        return f" of {_figure(high)} at most"
    return "" if low is None else f" of {_figure(low)} or more"


def _figure(value: object) -> str:
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


def _all_words(model: type[CellProfile]) -> dict[str, dict[str, str]]:
    """Return the docstrings below the fields of a model and of all tables in it."""
    words: dict[str, dict[str, str]] = {}
    waiting: list[type] = [model]
    while waiting:
        table = waiting.pop()
        if table.__name__ in words:
            continue
        words[table.__name__] = {}
        for base in reversed(table.__mro__):
            if base is not BaseModel and (issubclass(base, BaseModel) or is_dataclass(base)):
                words[table.__name__] |= _words_below(base)
        waiting += _tables_within(table)
    return words


def _tables_within(table: type) -> list[type]:
    if issubclass(table, BaseModel):
        annotations = [info.annotation for info in table.model_fields.values()]
    else:
        annotations = list(inspect.get_annotations(table, eval_str=True).values())
    return [one for annotation in annotations for one in _classes_in(annotation)]


def _classes_in(annotation: object) -> Iterator[type]:
    if isinstance(annotation, type) and (
        issubclass(annotation, BaseModel) or is_dataclass(annotation)
    ):
        yield annotation
    for inner in get_args(annotation):
        yield from _classes_in(inner)


def _words_below(table: type) -> dict[str, str]:
    """Return the docstrings that stand below the fields of one class."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(table)))
    except (OSError, TypeError):
        return {}  # Without its source the words of the schema are all there is.
    (found,) = tree.body
    if not isinstance(found, ast.ClassDef):
        return {}
    words: dict[str, str] = {}
    for field, below in zip(found.body, found.body[1:], strict=False):
        if (
            isinstance(field, ast.AnnAssign)
            and isinstance(field.target, ast.Name)
            and isinstance(below, ast.Expr)
            and isinstance(below.value, ast.Constant)
            and isinstance(below.value.value, str)
        ):
            words[field.target.id] = " ".join(below.value.value.split())
    return words
