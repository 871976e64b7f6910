"""Answers from files and words, and what is said of wrong ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from calibration.answers import (
    Given,
    GivenAnswers,
    missing_answers,
    parse_point,
    parse_settings,
    parse_words,
    read_answers,
)
from calibration.errors import AnswerRefused, CalibrationError
from calibration.pictures import picture_of
from calibration.procedure import Procedure, ask_choice, ask_number, ask_numbers, capture
from calibration.record import Measurement
from calibration.requests import Answer, Ask, Point, Value

NUMBER = Ask(key="width", question="How wide?", kind="number", unit="mm")
PAIR = Ask(key="at", question="Where?", kind="numbers", count=2)
SURE = Ask(key="sure", question="Sure?", kind="yes", default=False)
DONE = Ask(key="laid", question="Lay it down.", kind="done")
WAY = Ask(key="way", question="Which way?", kind="choice", choices=("up", "down"))
NAME = Ask(key="name", question="Who?", kind="text")
SPOT = Point(
    key="spot", question="The hole", picture=picture_of("x", np.zeros((4, 6, 3), np.uint8))
)


@pytest.mark.parametrize(
    ("ask", "words", "value"),
    [
        (NUMBER, " 3.5 ", 3.5),
        (NUMBER, "-1e2", -100.0),
        (PAIR, "1, 2", (1.0, 2.0)),
        (PAIR, "[1 2]", (1.0, 2.0)),
        (SURE, "YES", True),
        (SURE, "off", False),
        (DONE, "done", True),
        (WAY, "down", "down"),
        (NAME, "Ada", "Ada"),
    ],
)
def test_words_are_read_as_what_was_asked_for(ask: Ask, words: str, value: Value) -> None:
    assert parse_words(ask, words) == value


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (NUMBER, ""), (NUMBER, "wide"), (NUMBER, "nan"), (NUMBER, "inf"), (NUMBER, "1,5"),
        (PAIR, "1"), (PAIR, "1 2 3"), (PAIR, "a b"), (SURE, "perhaps"), (DONE, "no"),
        (WAY, "left"),
    ],
)  # fmt: skip
def test_words_that_are_no_answer_are_refused_by_the_question_s_name(ask: Ask, words: str) -> None:
    with pytest.raises(AnswerRefused, match=f"^{ask.key}: "):
        parse_words(ask, words)


@pytest.mark.parametrize("words", ["7 1", "1", "1 2 3", "1 4.6", "-1 0", "a b"])
def test_a_point_lies_in_the_picture(words: str) -> None:
    assert parse_point(SPOT, "5 3") == (5.0, 3.0)
    with pytest.raises(AnswerRefused, match="^spot: "):
        parse_point(SPOT, words)


TOML = """width = 3
at = [1, 2.5]

[board]
rows = 7
name = "a b"
"""
JSON = '{\n "width": 3,\n "at": [1, 2.5],\n "board": {\n  "rows": 7}}'


def test_keys_in_tables_are_joined_and_every_answer_knows_its_line(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(TOML)
    found = read_answers(path)
    assert {key: given.value for key, given in found.items()} == {
        "width": 3, "at": [1, 2.5], "board.rows": 7, "board.name": "a b",
    }  # fmt: skip
    assert found["board.rows"].where == f"{path}:5"
    (tmp_path / "a.json").write_text(JSON)
    assert read_answers(tmp_path / "a.json")["at"].where.endswith("a.json:3")


@pytest.mark.parametrize(
    ("name", "data", "told"),
    [
        ("a.toml", b"width =", "is not TOML"),
        ("a.json", b"{", "is not JSON"),
        ("a.json", b"[1]", "no table"),
        ("a.toml", b"\xff", "cannot be read"),
        ("a.json", b"[" * 100_000, "is not JSON"),
    ],
)
def test_a_file_that_is_no_answers_file_is_told(
    tmp_path: Path, name: str, data: bytes, told: str
) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(CalibrationError, match=told):
        read_answers(tmp_path / name)


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(CalibrationError, match="cannot be read"):
        read_answers(tmp_path / "none.toml")


@pytest.mark.parametrize("words", ["width", "=3", " = 3"])
def test_a_setting_needs_a_key_and_a_value(words: str) -> None:
    with pytest.raises(CalibrationError, match="key=value is expected"):
        parse_settings([words])


@pytest.mark.parametrize(
    ("ask", "value"),
    [(NUMBER, True), (NUMBER, "3"), (PAIR, [1]), (PAIR, [1, True]), (PAIR, 3), (SURE, 1),
     (DONE, False), (WAY, "left"), (NAME, 3), (NUMBER, float("nan")), (NUMBER, float("inf")),
     (NUMBER, 10**400), (PAIR, [1, float("nan")]), (PAIR, [1, 10**400])],
)  # fmt: skip
def test_a_value_of_the_wrong_type_is_refused_with_its_line(ask: Ask, value: object) -> None:
    asker = GivenAnswers({ask.key: Given(value, "answers.toml:4")})
    with pytest.raises(AnswerRefused, match=r"answers\.toml:4"):
        asker.answer(ask)


def test_a_slip_in_a_key_is_not_passed_over_by_a_default() -> None:
    asker = GivenAnswers({"shure": Given(True, "answers.toml:2")})
    with pytest.raises(AnswerRefused, match="did you mean 'sure'"):
        asker.answer(SURE)


@pytest.mark.parametrize("name", ["width 2", "width2", "12 width"])
def test_another_number_in_a_key_is_no_slip(name: str) -> None:
    ask = Ask(key="width 1", question="How wide?", kind="number", default=4.0)
    assert GivenAnswers({name: Given(3, "a.toml:1")}).answer(ask) == 4.0


def test_a_byte_order_mark_does_no_harm(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_bytes(b"\xef\xbb\xbfwidth = 3\n")
    assert read_answers(tmp_path / "a.toml")["width"].value == 3


def test_what_nobody_asked_for_is_named_with_its_line() -> None:
    asker = GivenAnswers({"width": Given(3, "a.toml:1"), "unheard": Given(1, "a.toml:9")})
    assert asker.answer(NUMBER) == 3.0
    assert asker.unused() == ["a.toml:9: nothing asked for 'unheard'"]


def test_what_is_given_goes_before_a_person_and_a_person_before_the_default() -> None:
    class Person:
        def answer(self, ask: Ask) -> Answer:
            return 7.0

        def point(self, point: Point) -> Answer:
            return (1.0, 1.0)

    given = GivenAnswers({"width": Given(3, "a.toml:1")})
    asker = given.before(Person())
    assert asker.answer(NUMBER) == 3.0
    assert asker.answer(SURE) == 7.0
    assert asker.point(SPOT) == (1.0, 1.0)
    assert given.unused() == []


def questions() -> Procedure:
    """Ask four things, then for a picture, then for one more."""
    yield from ask_number("width", "How wide?", unit="mm")
    yield from ask_choice("way", "Which way?", ("up", "down"))
    yield from ask_numbers("at", "Where?", count=2)
    yield from ask_number("thick", "How thick?", default=1.0)
    yield from capture("top", "the board")
    yield from ask_number("late", "And then?")
    return Measurement(kind="x", subject="x", method="x")


def test_all_that_is_missing_or_wrong_is_told_at_once() -> None:
    asker = GivenAnswers({"way": Given("left", "a.toml:2")})
    problems = missing_answers(questions(), asker)
    assert [problem.partition(":")[0] for problem in problems] == ["width", "way", "at"]
    assert "a.toml:2" in problems[1]
    assert problems[0].endswith("(a number in mm): How wide?")


def test_what_is_to_be_done_is_told_once() -> None:
    with pytest.raises(AnswerRefused) as refused:
        GivenAnswers({}).answer(DONE)
    assert str(refused.value).count("Lay it down.") == 1


def test_nothing_is_missing_where_everything_before_the_first_picture_is_answered() -> None:
    given = {"width": Given(1, ""), "way": Given("up", ""), "at": Given([1, 2], "")}
    assert missing_answers(questions(), GivenAnswers(given)) == []
