from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sessions.errors import LocalProtocolError, RemoteProtocolError
from sessions.wire.numbers import format_reward, parse_count, parse_reward
from tests.sessions.wire.tables import STEADY


@pytest.mark.parametrize(
    ("reward", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (-10.0, "-10"),
        (20.0, "20"),
        (100.0, "100"),
        (0.25, "0.25"),
        (-0.1, "-0.1"),
        (1e22, "10000000000000000000000"),
        (1e-7, "0.0000001"),
        (0.1 + 0.2, "0.30000000000000004"),
    ],
)
def test_rewards_are_the_shortest_decimals(reward: float, text: str) -> None:
    assert format_reward(reward) == text
    assert parse_reward(text) == reward


@STEADY
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_reward_reads_back_to_the_same_float(reward: float) -> None:
    text = format_reward(reward)

    assert "e" not in text.lower()
    assert parse_reward(text) == reward


@pytest.mark.parametrize("reward", [math.nan, math.inf, -math.inf])
def test_a_reward_that_is_no_number_is_refused(reward: float) -> None:
    with pytest.raises(LocalProtocolError, match="finite"):
        format_reward(reward)


@pytest.mark.parametrize("word", ["", "nan", "1_0", "0x1", " 1", "1e", "٣"])
def test_a_word_that_is_no_decimal_is_told(word: str) -> None:
    with pytest.raises(RemoteProtocolError):
        parse_reward(word)


@pytest.mark.parametrize("word", ["", "-1", "+1", "1.0", "4294967296", "99999999999", "٣"])
def test_a_word_that_is_no_count_is_told(word: str) -> None:
    with pytest.raises(RemoteProtocolError):
        parse_count(word)
