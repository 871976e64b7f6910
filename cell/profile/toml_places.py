"""Where each key and value of a TOML text stands.

The standard library reads TOML but keeps no places. `locate` walks the same text once more
and notes where keys, values and table headers begin and end. What the values are is none of
its business: `tomllib` reads them. It takes valid TOML; of other text it locates what comes
before the mistake, so that a key given twice can be shown at both places.
"""

from __future__ import annotations

import tomllib
from bisect import bisect_right
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

from cell.errors import ProfileError

KeyPath = tuple[str | int, ...]
"""Keys from the outermost table inwards; a number counts within an array, from 0."""

_BLANK: Final = " \t"
_SPACE: Final = " \t\r\n"
_ENDS_BARE_VALUE: Final = ",]}\n#"
_ENDS_BARE_KEY: Final = " \t\r\n.=]}#,[{\"'"


@dataclass(frozen=True, slots=True)
class Place:
    """A stretch of a text.

    Attributes:
        start: Offset of its first character, from 0.
        end: Offset after its last character.
        line: Line of its first character, from 1.
        column: Column of its first character, from 1.
    """

    start: int
    end: int
    line: int
    column: int


@dataclass(slots=True)
class TomlPlaces:
    """The places of a TOML text.

    Attributes:
        keys: Where the key of each path is written (its last part, if it is dotted).
        values: Where the value of each path is written.
        tables: Where the header of each table is written, brackets included.
        repeated: Paths whose key is given again, with the place where it is.
    """

    keys: dict[KeyPath, Place] = field(default_factory=dict)
    values: dict[KeyPath, Place] = field(default_factory=dict)
    tables: dict[KeyPath, Place] = field(default_factory=dict)
    repeated: list[tuple[KeyPath, Place]] = field(default_factory=list)

    def of_value(self, path: KeyPath) -> Place | None:
        """Return where the value of a path stands, or the header of the table that it is."""
        return self.values.get(path) or self.tables.get(path) or self._first_within(path)

    def of_key(self, path: KeyPath) -> Place | None:
        """Return where the key of a path stands, or whatever else begins it."""
        return self.keys.get(path) or self.of_value(path)

    def enclosing(self, path: KeyPath) -> Place | None:
        """Return where the nearest table around a path begins that is in the text."""
        for length in range(len(path) - 1, 0, -1):
            place = self.tables.get(path[:length]) or self.keys.get(path[:length])
            place = place or self.of_value(path[:length])
            if place is not None:
                return place
        return None

    def _first_within(self, path: KeyPath) -> Place | None:
        """Return where a table without a header of its own first appears."""
        inner = [p for known, p in self._all() if known[: len(path)] == path]
        return min(inner, key=lambda place: place.start, default=None)

    def _all(self) -> list[tuple[KeyPath, Place]]:
        return [*self.tables.items(), *self.keys.items()]


def locate(text: str) -> TomlPlaces:
    """Return the places of a TOML text, as far as it can be read."""
    scanner = _Scanner(text)
    # What was found before a mistake stays; the reader of the values names the mistake.
    with suppress(_Unreadable, RecursionError):
        scanner.document()
    return scanner.found


def place_at(text: str, line: int, column: int) -> Place:
    """Return the one character at a line and column, both from 1."""
    lines = text.split("\n")
    line = min(max(line, 1), len(lines))
    column = min(max(column, 1), len(lines[line - 1]) + 1)
    start = sum(len(one) + 1 for one in lines[: line - 1]) + column - 1
    return Place(start, start + 1, line, column)


class _Unreadable(ProfileError):
    """The text is no TOML from here on."""


class _Scanner:
    """Reads a TOML text from front to back."""

    def __init__(self, text: str) -> None:
        self.found = TomlPlaces()
        self._text = text
        self._at = 0
        self._line_starts = [0, *(i + 1 for i, c in enumerate(text) if c == "\n")]
        self._elements: dict[KeyPath, int] = {}

    def document(self) -> None:
        """Read everything."""
        table: KeyPath = ()
        while True:
            self._skip(_SPACE)
            if self._at >= len(self._text):
                return
            if self._peek() == "#":
                self._comment()
            elif self._peek() == "[":
                table = self._header()
            else:
                self._pair(table)

    # Lines

    def _header(self) -> KeyPath:
        start = self._at
        brackets = 2 if self._text.startswith("[[", start) else 1
        self._at += brackets
        parts = [name for name, _ in self._dotted_key()]
        self._expect("]" * brackets)
        path = self._resolve(parts, is_element=brackets == 2)
        place = self._place(start, self._at)
        if path in self.found.tables:
            self.found.repeated.append((path, place))
        self.found.tables.setdefault(path, place)
        return path

    def _resolve(self, parts: Sequence[str], *, is_element: bool) -> KeyPath:
        """Return the path that a header means: within an array of tables the last element."""
        path: KeyPath = ()
        for number, part in enumerate(parts, 1):
            path = (*path, part)
            if is_element and number == len(parts):
                self._elements[path] = self._elements.get(path, 0) + 1
            if path in self._elements:
                path = (*path, self._elements[path] - 1)
        return path

    def _pair(self, table: KeyPath) -> None:
        path = table
        parts = self._dotted_key()
        for name, place in parts:
            path = (*path, name)
            self.found.keys.setdefault(path, place)
        self._expect("=")
        self._skip(_BLANK)
        if path in self.found.values:
            self.found.repeated.append((path, parts[-1][1]))
        self._value(path)

    def _dotted_key(self) -> list[tuple[str, Place]]:
        parts = [self._key()]
        while True:
            self._skip(_BLANK)
            if self._peek() != ".":
                return parts
            self._at += 1
            parts.append(self._key())

    def _key(self) -> tuple[str, Place]:
        self._skip(_BLANK)
        start = self._at
        if self._peek() in ("'", '"'):
            self._string()
            raw = self._text[start : self._at]
            try:
                name = next(iter(tomllib.loads(f"{raw} = 0")))
            except tomllib.TOMLDecodeError as error:
                raise _Unreadable from error
            return name, self._place(start, self._at)
        while self._at < len(self._text) and self._peek() not in _ENDS_BARE_KEY:
            self._at += 1
        if self._at == start:
            raise _Unreadable
        return self._text[start : self._at], self._place(start, self._at)

    # Values

    def _value(self, path: KeyPath) -> None:
        start = self._at
        opening = self._peek()
        if opening in ("'", '"'):
            self._string()
        elif opening == "[":
            self._array(path)
        elif opening == "{":
            self._inline_table(path)
        else:
            self._bare()
        self.found.values.setdefault(path, self._place(start, self._at))

    def _bare(self) -> None:
        start = self._at
        while self._at < len(self._text) and self._peek() not in _ENDS_BARE_VALUE:
            self._at += 1
        self._at = start + len(self._text[start : self._at].rstrip())
        if self._at == start:
            raise _Unreadable

    def _array(self, path: KeyPath) -> None:
        self._at += 1
        number = 0
        while True:
            self._skip_lines()
            if self._peek() == "]":
                break
            self._value((*path, number))
            number += 1
            self._skip_lines()
            if self._peek() == ",":
                self._at += 1
            elif self._peek() != "]":
                raise _Unreadable
        self._at += 1

    def _inline_table(self, path: KeyPath) -> None:
        self._at += 1
        while True:
            self._skip_lines()
            if self._peek() == "}":
                break
            self._pair(path)
            self._skip_lines()
            if self._peek() == ",":
                self._at += 1
            elif self._peek() != "}":
                raise _Unreadable
        self._at += 1

    def _string(self) -> None:
        """Pass over a string of any of the four kinds."""
        quote = self._peek()
        if self._text.startswith(quote * 3, self._at):
            self._at += 3
            self._through(quote, 3)
            # A string may end in up to two quotation marks of its own.
            for _ in range(2):
                if self._peek() == quote:
                    self._at += 1
        else:
            self._at += 1
            self._through(quote, 1)

    def _through(self, quote: str, count: int) -> None:
        closing = quote * count
        while not self._text.startswith(closing, self._at):
            if self._at >= len(self._text) or (count == 1 and self._peek() == "\n"):
                raise _Unreadable
            self._at += 2 if quote == '"' and self._peek() == "\\" else 1
        self._at += count

    # Characters

    def _peek(self) -> str:
        return self._text[self._at] if self._at < len(self._text) else "\0"

    def _expect(self, mark: str) -> None:
        self._skip(_BLANK)
        if not self._text.startswith(mark, self._at):
            raise _Unreadable
        self._at += len(mark)

    def _skip(self, characters: str) -> None:
        while self._at < len(self._text) and self._text[self._at] in characters:
            self._at += 1

    def _skip_lines(self) -> None:
        self._skip(_SPACE)
        while self._peek() == "#":
            self._comment()
            self._skip(_SPACE)

    def _comment(self) -> None:
        end = self._text.find("\n", self._at)
        self._at = len(self._text) if end < 0 else end

    def _place(self, start: int, end: int) -> Place:
        line = bisect_right(self._line_starts, start)
        return Place(start, end, line, start - self._line_starts[line - 1] + 1)
