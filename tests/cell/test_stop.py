import pytest

from cell.errors import CellError, Stopped
from cell.stop import StopToken


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
