import pytest

from cell.errors import CellError, Stopped
from cell.stop import Bell, StopToken
from tests.cell.at_every_line import ends_although_interrupted


def test_work_goes_on_until_somebody_asks_for_a_stop() -> None:
    token = StopToken()
    token.check()
    assert not token.is_set
    token.stop("the door was opened")
    assert token.is_set
    with pytest.raises(Stopped, match="the door was opened"):
        token.check()


def test_a_stop_stays_until_it_is_cleared() -> None:
    token = StopToken()
    token.stop("enough")
    for _ in range(2):
        with pytest.raises(Stopped):
            token.check()
    token.clear()
    assert not token.is_set
    token.check()


def test_the_first_reason_is_kept() -> None:
    token = StopToken()
    token.stop("first")
    token.stop("second")
    with pytest.raises(Stopped, match="first"):
        token.check()
    token.clear()
    token.stop("third")
    with pytest.raises(Stopped, match="third"):
        token.check()


def test_a_stop_without_a_reason_is_one_all_the_same() -> None:
    token = StopToken()
    token.stop("")
    with pytest.raises(Stopped):
        token.check()


def test_a_stop_is_an_error_of_the_cell() -> None:
    assert issubclass(Stopped, CellError)


def test_a_token_may_be_stopped_within_any_moment_of_its_use() -> None:
    token = StopToken()

    def use() -> None:
        token.stop("by the work")
        token.clear()
        token.stop("by the work")

    assert ends_although_interrupted(use, lambda: token.stop("by a signal"))
    assert token.is_set


def test_a_bell_may_be_rung_within_any_moment_of_its_ringing_and_waiting() -> None:
    bell = Bell()
    assert not bell.wait(0.0)

    def use() -> None:
        bell.ring()
        bell.wait()

    assert ends_although_interrupted(use, bell.ring)
    assert bell.wait()


def test_a_rung_bell_wakes_everybody_who_comes_later() -> None:
    bell = Bell()
    bell.ring()
    assert bell.wait(0.0)
    assert bell.wait(0.0)
