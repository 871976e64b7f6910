"""Events as JSON and the JSON schema that describes them, both made from `cell.events`."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from functools import lru_cache
from json.encoder import encode_basestring_ascii
from typing import get_args, get_type_hints

from cell.events import Body, Event

_BODIES: tuple[type, ...] = get_args(Body)
_JSON_TYPES = {int: "integer", float: "number", str: "string", bool: "boolean"}

Writer = Callable[[Event], bytes]


def encode_event(event: Event) -> bytes:
    """Return an event as one JSON object: `sequence`, `time_s`, `type`, then its fields."""
    return _WRITERS[type(event.body)](event)


def decode_event(data: bytes) -> dict[str, object]:
    """Return the fields of an encoded event.

    Raises:
        ValueError: The bytes are no JSON object.
    """
    decoded: object = json.loads(data)
    if not isinstance(decoded, dict):
        raise ValueError(f"an event is a JSON object, not {decoded!r}")
    return decoded


def event_schema() -> str:
    """Return the JSON schema of all events."""
    return json.dumps({"type": "object", "oneOf": [_schema_of(body) for body in _BODIES]})


def _schema_of(body: type) -> dict[str, object]:
    properties: dict[str, object] = {
        "sequence": {"type": "integer"},
        "time_s": {"type": "number"},
        "type": {"const": body.__name__},
    }
    properties.update({name: _type_of(kind) for name, kind in _field_types(body).items()})
    description = (body.__doc__ or "").partition("\n")[0]
    return {
        "title": body.__name__,
        "description": description,
        "required": list(properties),
        "properties": properties,
    }


def _type_of(kind: type) -> dict[str, object]:
    if is_dataclass(kind):
        inner = _field_types(kind)
        return {"type": "object", "properties": {n: _type_of(k) for n, k in inner.items()}}
    return {"type": _JSON_TYPES[kind]}


def _field_types(owner: type) -> dict[str, type]:
    hints = get_type_hints(owner)
    return {field.name: hints[field.name] for field in fields(owner)}


def _writer_of(body: type) -> Writer:
    """Return a function that writes events of a class, made of source as `dataclass` does it.

    Events are written on the path of every step: the text around the values is constant and
    every value is fetched by name. Python writes finite numbers as JSON does; if one is not
    finite, so is their sum, and the event is written again with care.
    """
    leaves = list(_leaves(body, "event.body."))
    total = " + ".join(["event.time_s", *(path for path, kind in leaves if kind is float)])
    lines = [
        "def write(event):",
        f"    total = {total}",
        "    if total - total != 0.0:",
        f"        return {_literal(body, careful=True)}.encode('ascii')",
        f"    return {_literal(body, careful=False)}.encode('ascii')",
    ]
    made: dict[str, Writer] = {}
    exec("\n".join(lines), {"quoted": _quoted, "number": _number}, made)
    return made["write"]


def _literal(body: type, *, careful: bool) -> str:
    """Return the source of a formatted string that is an event of a class as JSON."""
    time = "{number(event.time_s)}" if careful else "{event.time_s}"
    head = f'{{{{"sequence":{{event.sequence}},"time_s":{time},"type":"{body.__name__}",'
    return f"f'{head}{_template(body, 'event.body.', careful=careful)}}}}}'"


def _leaves(owner: type, prefix: str) -> Iterator[tuple[str, type]]:
    """Yield the dotted path and the type of every value, objects within objects included."""
    for name, kind in _field_types(owner).items():
        if is_dataclass(kind):
            yield from _leaves(kind, f"{prefix}{name}.")
        else:
            yield prefix + name, kind


def _template(owner: type, prefix: str, *, careful: bool) -> str:
    """Return the fields of a class as the inside of a formatted string."""
    parts = []
    for name, kind in _field_types(owner).items():
        path = prefix + name
        if is_dataclass(kind):
            parts.append(f'"{name}":{{{{{_template(kind, path + ".", careful=careful)}}}}}')
        elif kind is str:
            parts.append(f'"{name}":{{quoted({path})}}')
        elif kind is bool:
            parts.append(f'"{name}":{{"true" if {path} else "false"}}')
        elif kind is float and careful:
            parts.append(f'"{name}":{{number({path})}}')
        else:
            parts.append(f'"{name}":{{{path}}}')
    return ",".join(parts)


@lru_cache(maxsize=1024)
def _quoted(text: str) -> str:
    """Return a text as JSON; most texts of events come again and again."""
    return encode_basestring_ascii(text)


def _number(value: float) -> str:
    """Return a number as JSON, with JSON's usual names for what is not finite."""
    text = str(value)
    return _NOT_FINITE.get(text, text)


_NOT_FINITE = {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}
_WRITERS: dict[type, Writer] = {body: _writer_of(body) for body in _BODIES}
