"""The course of a bring-up, without a cell: looked at, repeated, confirmed, skipped, resumed."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from cell.bringup import BringUp, Looked, ProgressFile, Step

NOW = datetime(2026, 11, 22, 7, 0, tzinfo=UTC)
DONE = Looked(verdict="done", evidence=("seen",))
MISSING = Looked(verdict="not done", problem="the key stands at TEACH", fix="turn it", link="x#y")
UNSEEN = Looked(verdict="cannot tell", problem="nobody can see that", fix="look")


def step(name: str, *looks: Looked) -> Step:
    left = list(looks)

    def look() -> Looked:
        return left.pop(0) if len(left) > 1 else left[0]

    return Step(id=name, title=name, instruction="do it", look=look)


def test_a_step_that_is_done_leads_to_the_next() -> None:
    play = BringUp((step("a", DONE), step("b", DONE)))
    assert play.position == (1, 2)
    assert play.look().outcome == "done"
    assert play.current is not None
    assert play.current.id == "b"
    play.look()
    assert play.current is None
    assert play.report().is_ready


def test_a_step_that_is_not_done_stays_until_it_is() -> None:
    play = BringUp((step("a", MISSING, MISSING, DONE),))
    assert play.look().outcome == "failed"
    assert play.look().fix == "turn it"
    assert play.current is not None
    assert play.look().outcome == "done"
    assert play.report().is_ready


def test_what_cannot_be_measured_is_taken_from_the_person() -> None:
    play = BringUp((step("a", UNSEEN),))
    assert play.look().outcome == "open"
    assert not play.report().is_ready
    assert play.confirm().outcome == "confirmed"
    assert play.report().is_ready


def test_a_skipped_step_keeps_its_reason_and_the_cell_from_being_ready() -> None:
    play = BringUp((step("a", MISSING), step("b", DONE)))
    play.look()
    play.skip("  the camera is at the maker's ")
    play.look()
    report = play.report()
    assert not report.is_ready
    assert [one.reason for one in report.missing] == ["the camera is at the maker's"]


def test_a_step_is_not_skipped_without_a_reason() -> None:
    with pytest.raises(ValueError, match="reason"):
        BringUp((step("a", MISSING),)).skip("  ")


def test_a_step_given_up_is_missing_with_its_problem() -> None:
    play = BringUp((step("a", MISSING), step("b", DONE)))
    play.look()
    play.give_up()
    play.look()
    (missing,) = play.report().missing
    assert missing.problem == "the key stands at TEACH"
    assert missing.link == "x#y"


@pytest.mark.parametrize("verb", ["look", "confirm", "give_up"])
def test_after_the_last_step_there_is_nothing_to_do(verb: str) -> None:
    play = BringUp((step("a", DONE),))
    play.look()
    act: Callable[[], object] = getattr(play, verb)
    with pytest.raises(LookupError):
        act()


def test_a_resumed_run_keeps_what_was_told_and_measures_the_rest_again(tmp_path: Path) -> None:
    file = ProgressFile(tmp_path / "cell" / "bringup.json")
    first = BringUp((step("a", UNSEEN), step("b", DONE), step("c", MISSING), step("d", DONE)))
    first.look()
    first.confirm()
    first.look()
    first.look()
    first.skip("no key")
    file.save(first.report(), NOW)
    again = BringUp(
        (step("a", MISSING), step("b", MISSING), step("c", DONE), step("d", DONE)),
        file.load(NOW + timedelta(hours=1)),
    )
    assert again.current is not None
    assert again.current.id == "b"
    assert again.look().outcome == "failed"
    again.give_up()
    assert again.current.id == "d"
    outcomes = [one.outcome for one in again.report().results]
    assert outcomes == ["confirmed", "failed", "skipped", "open"]


@pytest.mark.parametrize("hours", [-1, 13, 24 * 400])
def test_what_was_told_long_ago_or_tomorrow_counts_no_more(tmp_path: Path, hours: int) -> None:
    file = ProgressFile(tmp_path / "bringup.json")
    play = BringUp((step("a", UNSEEN),))
    play.look()
    play.confirm()
    file.save(play.report(), NOW)
    assert file.load(NOW + timedelta(hours=hours)) == {}


@pytest.mark.parametrize("text", ["", "{", '{"written": 1}', '{"written": "2026-11-22T07:00:00"}'])
def test_a_damaged_file_of_progress_counts_as_none(tmp_path: Path, text: str) -> None:
    path = tmp_path / "bringup.json"
    path.write_text(text)
    assert ProgressFile(path).load(NOW) == {}
    ProgressFile(path).clear()
    assert not path.exists()
