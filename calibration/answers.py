"""Answers to a procedure's questions from a file, from words, or from defaults.

An answers file is TOML (or JSON): the keys of the questions and their answers. Keys in tables
are joined by dots. Points are `[u, v]` in px of the picture that is shown.
"""

from __future__ import annotations

import difflib
import json
import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from calibration.errors import AnswerRefused, CalibrationError
from calibration.player import Asker
from calibration.procedure import Procedure
from calibration.requests import Answer, Ask, Point, Tell, Value
from cell.errors import ProfileError
from cell.profile.toml_places import locate

_YES = ("yes", "y", "true", "on", "1")
_NO = ("no", "n", "false", "off", "0")
_DONE = (*_YES, "done", "ok")
_SIMILAR = 0.75


@dataclass(frozen=True, slots=True)
class Given:
    """An answer that was given beforehand.

    Attributes:
        value: The answer; words of the command line are text, whatever was asked.
        where: Where it stands, such as `answers.toml:3`.
        is_words: Whether it is text that is still to be read as what was asked for.
    """

    value: object
    where: str
    is_words: bool = False


def read_answers(path: Path) -> dict[str, Given]:
    """Read an answers file, TOML unless its name ends in `.json`.

    Raises:
        CalibrationError: It cannot be read, or holds something that is no answer.
    """
    try:
        # Editors of other systems begin a file with a byte order mark.
        text = path.read_text("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise CalibrationError(f"the answers file {path} cannot be read: {error}") from error
    is_json = path.suffix == ".json"
    try:
        data: object = json.loads(text) if is_json else tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        kind = "JSON" if is_json else "TOML"
        raise CalibrationError(f"the answers file {path} is not {kind}: {error}") from error
    if not isinstance(data, dict):
        raise CalibrationError(f"the answers file {path} holds no table of keys and answers")
    lines = _json_lines(text) if is_json else _toml_lines(text)
    return {key: Given(value, f"{path}:{lines.get(key, 1)}") for key, value in _flat(data).items()}


def parse_settings(settings: list[str]) -> dict[str, Given]:
    """Return the answers of `key=value` words.

    Raises:
        CalibrationError: One has no `=`.
    """
    found = {}
    for words in settings:
        key, equals, value = words.partition("=")
        if not equals or not key.strip():
            raise CalibrationError(f"--set {words}: key=value is expected")
        found[key.strip()] = Given(value.strip(), f"--set {key.strip()}", is_words=True)
    return found


def parse_words(ask: Ask, words: str) -> Value:
    """Return what a person's words mean as the answer to a question.

    Raises:
        AnswerRefused: They are no such answer.
    """
    words = words.strip()
    match ask.kind:
        case "text":
            return words
        case "yes":
            if words.lower() in _YES + _NO:
                return words.lower() in _YES
            raise AnswerRefused(ask.key, f"yes or no is expected, not {words!r}")
        case "done":
            if words.lower() in _DONE:
                return True
            raise AnswerRefused(ask.key, f"`done` is expected, not {words!r}")
        case "choice":
            if words in ask.choices:
                return words
            raise AnswerRefused(ask.key, f"one of {', '.join(ask.choices)} is expected, not "
                                f"{words!r}")  # fmt: skip
        case "number":
            return _number(ask.key, words)
        case "numbers":
            parts = [part for part in re.split(r"[,;\s]+", words.strip("[]() ")) if part]
            numbers = tuple(_number(ask.key, part) for part in parts)
            if ask.count and len(numbers) != ask.count:
                raise AnswerRefused(
                    ask.key, f"{ask.count} numbers are expected, not {len(numbers)}"
                )
            return numbers


def parse_point(point: Point, words: str) -> tuple[float, float]:
    """Return u, v in px of a person's words.

    Raises:
        AnswerRefused: They are no two numbers, or no point of the picture.
    """
    parts = [part for part in re.split(r"[,;\s]+", words.strip("[]() ")) if part]
    if len(parts) != 2:
        raise AnswerRefused(point.key, f"u and v in px are expected, not {words!r}")
    return _inside(point, (_number(point.key, parts[0]), _number(point.key, parts[1])))


class GivenAnswers:
    """Answers questions by what was given beforehand, then by their defaults.

    Args:
        given: The answers by key.
        otherwise: Asked for what is not given, before defaults are taken; None takes defaults.
    """

    def __init__(self, given: Mapping[str, Given], otherwise: Asker | None = None) -> None:
        self._given = dict(given)
        self._otherwise = otherwise
        self._asked: set[str] = set()

    def before(self, otherwise: Asker) -> GivenAnswers:
        """Return the same answers with somebody behind them who is asked for the others."""
        found = GivenAnswers(self._given, otherwise)
        found._asked = self._asked
        return found

    def note_asked(self, key: str) -> None:
        """Note that a question was asked, though it was answered elsewhere."""
        self._asked.add(key)

    def unused(self) -> list[str]:
        """Return a sentence for each answer that nothing asked for."""
        return [
            f"{given.where}: nothing asked for {key!r}"
            for key, given in self._given.items()
            if key not in self._asked
        ]

    def answer(self, ask: Ask) -> Answer:
        """Return the answer; see `Asker`.

        Raises:
            AnswerRefused: There is none, or it is not of the kind that is asked for.
        """
        self._asked.add(ask.key)
        given = self._given.get(ask.key)
        if given is not None:
            return _fitting(ask, given)
        self._refuse_slips(ask.key)
        if self._otherwise is not None:
            return self._otherwise.answer(ask)
        if ask.default is None:
            # What is to be done says so already.
            question = "" if ask.kind == "done" else f": {ask.question}"
            raise AnswerRefused(ask.key, f"no answer is given ({_wanted(ask)}){question}")
        return ask.default

    def point(self, point: Point) -> Answer:
        """Return u, v in px; see `Asker`.

        Raises:
            AnswerRefused: They are not given, or not in the picture.
        """
        self._asked.add(point.key)
        given = self._given.get(point.key)
        if given is None:
            self._refuse_slips(point.key)
            if self._otherwise is not None:
                return self._otherwise.point(point)
            raise AnswerRefused(point.key, f"no point is given ({point.question}: [u, v] in px)")
        if given.is_words:
            return parse_point(point, str(given.value))
        numbers = _numbers(given.value)
        if numbers is None or len(numbers) != 2:
            raise AnswerRefused(point.key, f"[u, v] in px is expected at {given.where}")
        return _inside(point, (numbers[0], numbers[1]))

    def _refuse_slips(self, key: str) -> None:
        """Refuse to go on by a default where the answer seems to stand under a slip's name.

        `touch 2` is no slip of `touch 1`, nor `point 1` of `points`: another number is another
        question.
        """
        numbers = re.findall(r"\d+", key)
        unasked = [
            name
            for name in self._given
            if name not in self._asked and re.findall(r"\d+", name) == numbers
        ]
        for name in difflib.get_close_matches(key, unasked, 1, _SIMILAR):
            raise AnswerRefused(
                key, f"{self._given[name].where} answers {name!r}; did you mean {key!r}?"
            )


def missing_answers(procedure: Procedure, asker: GivenAnswers) -> list[str]:
    """Return what is missing or wrong among the answers, as far as can be seen beforehand.

    Plays the procedure with stand-ins for what is missing, up to its first request to the
    cell; a procedure that cannot go on with a stand-in ends the search.

    Args:
        procedure: A fresh generator, which is used up.
        asker: What was given; nobody behind it.
    """
    problems: list[str] = []
    try:
        request = next(procedure)
        while isinstance(request, Ask | Tell):
            if isinstance(request, Tell):
                request = procedure.send(None)
                continue
            try:
                answer = asker.answer(request)
            except AnswerRefused as refused:
                problems.append(str(refused))
                answer = _stand_in(request)
            request = procedure.send(answer)
    except (StopIteration, CalibrationError, ValueError, ArithmeticError, LookupError):
        # What the stand-ins, or the answers themselves, lead to is told when it is played.
        return problems
    finally:
        procedure.close()
    return problems


def _stand_in(ask: Ask) -> Value:
    if ask.default is not None:
        return ask.default
    match ask.kind:
        case "number":
            return 1.0
        case "numbers":
            return tuple(float(i + 1) for i in range(ask.count or 1))
        case "yes" | "done":
            return True
        case "choice":
            return ask.choices[0] if ask.choices else ""
        case "text":
            return ""


def _fitting(ask: Ask, given: Given) -> Value:
    """Return a given answer as the question wants it."""
    value = given.value
    if given.is_words:
        return parse_words(ask, str(value))
    match ask.kind:
        case "number":
            number = _finite(value)
            if number is not None:
                return number
        case "text" if isinstance(value, str):
            return value
        case "yes" | "done" if isinstance(value, bool) and (value or ask.kind == "yes"):
            return value
        case "choice" if isinstance(value, str) and value in ask.choices:
            return value
        case "numbers":
            numbers = _numbers(value)
            if numbers is not None and (not ask.count or len(numbers) == ask.count):
                return numbers
    raise AnswerRefused(ask.key, f"{_wanted(ask)} is expected at {given.where}, not {value!r}")


def _wanted(ask: Ask) -> str:
    unit = f" in {ask.unit}" if ask.unit else ""
    match ask.kind:
        case "number":
            return f"a number{unit}"
        case "numbers":
            return f"a list of {ask.count or 'any'} numbers{unit}"
        case "yes":
            return "true or false"
        case "done":
            return f"true, as soon as this is done: {ask.question}"
        case "choice":
            return f"one of {', '.join(ask.choices)}"
        case "text":
            return "a text"


def _number(key: str, words: str) -> float:
    try:
        number = float(words)
    except ValueError as error:
        raise AnswerRefused(key, f"a number is expected, not {words!r}") from error
    if not math.isfinite(number):
        raise AnswerRefused(key, f"a number is expected, not {words!r}")
    return number


def _numbers(value: object) -> tuple[float, ...] | None:
    if not isinstance(value, list):
        return None
    numbers = [number for one in value if (number := _finite(one)) is not None]
    return tuple(numbers) if len(numbers) == len(value) else None


def _finite(value: object) -> float | None:
    """Return a number of a file; None for anything else, such as TOML's `nan`."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _inside(point: Point, found: tuple[float, float]) -> tuple[float, float]:
    height, width = point.picture.pixels.shape[:2]
    if -0.5 <= found[0] <= width - 0.5 and -0.5 <= found[1] <= height - 0.5:
        return found
    raise AnswerRefused(
        point.key, f"({found[0]:g}, {found[1]:g}) px is outside of the picture, {width} x {height}"
    )


def _flat(table: Mapping[str, object], prefix: str = "") -> dict[str, object]:
    found: dict[str, object] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            found |= _flat(value, f"{prefix}{key}.")
        else:
            found[prefix + key] = value
    return found


def _toml_lines(text: str) -> dict[str, int]:
    try:
        places = locate(text)
    except ProfileError:
        return {}
    return {".".join(str(part) for part in path): at.line for path, at in places.keys.items()}


def _json_lines(text: str) -> dict[str, int]:
    """Return the line of each key; of keys in tables, that of their last part."""
    lines: dict[str, int] = {}
    for found in re.finditer(r'"((?:[^"\\]|\\.)*)"\s*:', text):
        lines.setdefault(str(json.loads(f'"{found[1]}"')), text.count("\n", 0, found.start()) + 1)
    return lines
