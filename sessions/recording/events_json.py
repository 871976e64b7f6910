"""Events as JSON and the JSON schema that describes them, both made from `cell.events`."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from json.encoder import encode_basestring_ascii
from typing import SupportsFloat, SupportsInt, get_args, get_type_hints

from cell.events import Body, Event

_BODIES: tuple[type, ...] = get_args(Body)
_JSON_TYPES = {int: "integer", float: "number", str: "string", bool: "boolean"}

Writer = Callable[..., str]


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
    """Return a function that writes an object of a class as the rest of a JSON object."""
    parts = [(name, _value_writer(kind)) for name, kind in _field_types(body).items()]
    opening = f'"{body.__name__}"'
    keyed = tuple((f',"{name}":', name, write) for name, write in parts)

    def write(value: object) -> str:
        text = opening
        for key, name, write_value in keyed:
            text += key + write_value(getattr(value, name))
        return text + "}"

    return write


def _value_writer(kind: type) -> Writer:
    if is_dataclass(kind):
        parts = tuple((name, _value_writer(inner)) for name, inner in _field_types(kind).items())

        def write(value: object) -> str:
            inside = ",".join([f'"{name}":{inner(getattr(value, name))}' for name, inner in parts])
            return f"{{{inside}}}"

        return write
    return _SCALAR_WRITERS[kind]


def _write_bool(value: object) -> str:
    return "true" if value else "false"


def _write_float(value: SupportsFloat) -> str:
    # Going through float gives numpy's scalars the same text as Python's.
    text = repr(float(value))
    return _NOT_FINITE.get(text, text)


def _write_int(value: SupportsInt) -> str:
    return repr(int(value))


_NOT_FINITE = {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}
_SCALAR_WRITERS: dict[type, Callable[..., str]] = {
    str: encode_basestring_ascii,
    bool: _write_bool,
    float: _write_float,
    int: _write_int,
}
_WRITERS: dict[type, Writer] = {body: _writer_of(body) for body in _BODIES}
