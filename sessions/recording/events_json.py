"""Events as JSON and the JSON schema that describes them, both made from `cell.events`."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from functools import lru_cache
from json.encoder import encode_basestring_ascii
from operator import attrgetter
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
    """Return a function that writes events of a class.

    The bytes around the values are made once; a call only fetches and formats values, all
    in one formatting. Python writes finite numbers as JSON does; whatever it may write in
    another way shows by its name in the result, which is then written again with care.
    """
    leaves = [("sequence", int), ("time_s", float), *_leaves(body, "body.")]
    fetch = attrgetter(*(path for path, _ in leaves))
    head = f'{{"sequence":%a,"time_s":%a,"type":"{body.__name__}",'
    plain = f"{head}{_template(body)}}}".encode("ascii")
    careful = plain.replace(b"%a", b"%b")
    texts = tuple(i for i, (_, kind) in enumerate(leaves) if kind is str)
    has_flags = any(kind is bool for _, kind in leaves)

    def write(event: Event) -> bytes:
        values = fetch(event)
        if texts:
            quoted = list(values)
            for i in texts:
                quoted[i] = _quoted(quoted[i])
            values = tuple(quoted)
        written: bytes = plain % values
        if has_flags or b"nan" in written or b"inf" in written or b"np." in written:
            return careful % tuple([_as_json(value) for value in values])
        return written

    return write


def _leaves(owner: type, prefix: str) -> Iterator[tuple[str, type]]:
    """Yield the dotted path and the type of every value, objects within objects included."""
    for name, kind in _field_types(owner).items():
        if is_dataclass(kind):
            yield from _leaves(kind, f"{prefix}{name}.")
        else:
            yield prefix + name, kind


def _template(owner: type) -> str:
    """Return the fields of a class as JSON with `%a` for each number and `%b` for each text."""
    return ",".join(
        f'"{name}":{{{_template(kind)}}}'
        if is_dataclass(kind)
        else f'"{name}":{"%b" if kind is str else "%a"}'
        for name, kind in _field_types(owner).items()
    )


@lru_cache(maxsize=1024)
def _quoted(text: str) -> bytes:
    """Return a text as JSON; most texts of events come again and again."""
    return encode_basestring_ascii(text).encode("ascii")


def _as_json(value: object) -> bytes:
    """Return a number or a flag as JSON, and what is written already as it is."""
    if isinstance(value, bytes):
        return value
    text = str(value)
    return _NAMED.get(text, text).encode("ascii")


_NAMED = {
    "True": "true",
    "False": "false",
    "nan": "NaN",
    "inf": "Infinity",
    "-inf": "-Infinity",
}
_WRITERS: dict[type, Writer] = {body: _writer_of(body) for body in _BODIES}
