"""Events as JSON and the JSON schema that describes them, both made from `cell.events`."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from json.encoder import encode_basestring_ascii
from operator import attrgetter
from typing import get_args, get_type_hints

from cell.events import Body, Event

_BODIES: tuple[type, ...] = get_args(Body)
_JSON_TYPES = {int: "integer", float: "number", str: "string", bool: "boolean"}

Writer = Callable[[object], str]


def encode_event(event: Event) -> bytes:
    """Return an event as one JSON object: `sequence`, `time_s`, `type`, then its fields."""
    body = event.body
    head = f'{{"sequence":{event.sequence},"time_s":{event.time_s!r},"type":'
    return (head + _WRITERS[type(body)](body)).encode("ascii")


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
    """Return a function that writes an object of a class as the rest of a JSON object.

    The text around the values is made once; a call only fetches and formats values.
    """
    leaves = list(_leaves(body, ""))
    template = f'"{body.__name__}",{_template(body)}}}'
    paths = [path for path, _ in leaves]
    quoted = tuple(i for i, (_, kind) in enumerate(leaves) if kind is str)
    has_floats = any(kind is float for _, kind in leaves)
    has_flags = any(kind is bool for _, kind in leaves)
    fetch = attrgetter(*paths)
    quote: Callable[..., str] = encode_basestring_ascii

    def write(value: object) -> str:
        fetched = fetch(value)
        values = list(fetched) if len(paths) > 1 else [fetched]
        for i in quoted:
            values[i] = quote(values[i])
        if has_flags:
            values = [_FLAGS.get(one, one) if isinstance(one, bool) else one for one in values]
        text = template % tuple(values)
        if has_floats and ("nan" in text or "inf" in text):
            return template % tuple([_finite_or_named(one) for one in values])
        return text

    return write


def _leaves(owner: type, prefix: str) -> Iterator[tuple[str, type]]:
    """Yield the dotted path and the type of every value, objects within objects included."""
    for name, kind in _field_types(owner).items():
        if is_dataclass(kind):
            yield from _leaves(kind, f"{prefix}{name}.")
        else:
            yield prefix + name, kind


def _template(owner: type) -> str:
    """Return the fields of a class as JSON with `%s` for each value."""
    return ",".join(
        f'"{name}":{{{_template(kind)}}}' if is_dataclass(kind) else f'"{name}":%s'
        for name, kind in _field_types(owner).items()
    )


def _finite_or_named(value: object) -> object:
    """Return JSON's usual names for what is not finite, and anything else as it is."""
    return _NOT_FINITE.get(str(value), value) if isinstance(value, float) else value


_FLAGS = {True: "true", False: "false"}
_NOT_FINITE = {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}
_WRITERS: dict[type, Writer] = {body: _writer_of(body) for body in _BODIES}
