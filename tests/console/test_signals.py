"""Signals that come in each other's midst."""

from __future__ import annotations

import signal

from console.signals import signals_handled


def test_a_signal_within_the_handler_of_another_is_ignored() -> None:
    received: list[int] = []

    def stop(number: int, frame: object) -> None:
        received.append(number)
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGTERM)

    with signals_handled(stop):
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGINT)
    assert received == [signal.SIGTERM]


def test_handlers_are_as_before_afterwards() -> None:
    before = [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)]
    with signals_handled(lambda number, frame: None):
        pass
    assert [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)] == before
