"""Plays a procedure: each request goes to whoever can answer it.

Whatever is answered is noted in a journal before the procedure hears it. A journal of an
interrupted run answers first, so that the procedure comes to where it was; the last state
of screen, lights and blocks is then brought about again by the hands.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from calibration.errors import AnswerRefused
from calibration.procedure import Procedure
from calibration.record import Measurement
from calibration.requests import Answer, Ask, Point, Request, Tell
from calibration.standing import Standing
from cell.stop import StopToken


class Asker(Protocol):
    """Answers questions: a person, an answers file, a test."""

    def answer(self, ask: Ask) -> Answer:
        """Return the answer.

        Raises:
            AnswerRefused: There is none.
        """

    def point(self, point: Point) -> Answer:
        """Return u, v in px of what is asked for.

        Raises:
            AnswerRefused: There is none.
        """


class Hands(Protocol):
    """Does what a procedure asks of the cell."""

    def perform(self, request: Request) -> Answer:
        """Do it and return the answer.

        Raises:
            CellError: A device fails, or the guard turns a motion down.
        """


class Journal(Protocol):
    """Notes answers, and gives them again to a run that goes on."""

    def recall(self, request: Request) -> tuple[Answer] | None:
        """Return the noted answer in a tuple of one, None where the notes end.

        Raises:
            CalibrationError: Something else was asked at this place.
        """

    def note(self, request: Request, answer: Answer) -> None:
        """Note an answer."""


class NoJournal:
    """Notes nothing."""

    def recall(self, request: Request) -> tuple[Answer] | None:
        """Return None: there are no notes."""
        return None

    def note(self, request: Request, answer: Answer) -> None:
        """Note nothing."""


def _nothing_seen(request: Request, answer: Answer) -> None:
    pass


def _nothing_restored(standing: Standing) -> None:
    pass


def play(
    procedure: Procedure,
    *,
    hands: Hands,
    asker: Asker,
    stop: StopToken,
    journal: Journal | None = None,
    on_tell: Callable[[Tell], None] = lambda told: None,
    on_answer: Callable[[Request, Answer], None] = _nothing_seen,
    restore: Callable[[Standing], None] = _nothing_restored,
) -> Measurement:
    """Play a procedure to its end and return what it found.

    Args:
        procedure: A fresh generator.
        hands: Do what is asked of the cell.
        asker: Answers questions.
        stop: Looked at before every request.
        journal: Notes every answer; nothing is noted without one.
        on_tell: Told what the procedure says.
        on_answer: Told every request with its answer, noted ones included.
        restore: Brings about again what an interrupted run had brought about, before the first
            request that its notes do not answer.

    Raises:
        Stopped: Somebody stopped it.
        CalibrationError: An answer is missing, or the procedure cannot come to an end.
        CellError: A device fails.
    """
    notes = journal or NoJournal()
    standing = Standing()
    is_live, recalled = False, 0
    try:
        request = next(procedure)
        while True:
            stop.check()
            if isinstance(request, Tell):
                on_tell(request)
                request = procedure.send(None)
                continue
            known = None if is_live else notes.recall(request)
            if known is not None:
                recalled += 1
                answer = known[0]
            else:
                if recalled and not is_live:
                    restore(standing)
                is_live = True
                answer = _ask(request, hands, asker)
                notes.note(request, answer)
            standing.follow(request)
            on_answer(request, answer)
            request = procedure.send(answer)
    except StopIteration as end:
        if not isinstance(end.value, Measurement):
            raise TypeError("a procedure must return a Measurement") from end
        return end.value
    finally:
        procedure.close()


def _ask(request: Request, hands: Hands, asker: Asker) -> Answer:
    if isinstance(request, Ask):
        return _checked(request, asker.answer(request))
    if isinstance(request, Point):
        return asker.point(request)
    return hands.perform(request)


def _checked(ask: Ask, answer: Answer) -> Answer:
    """Return an answer if it is of the kind that was asked for."""
    fits = {
        "number": isinstance(answer, int | float) and not isinstance(answer, bool),
        "text": isinstance(answer, str),
        "yes": isinstance(answer, bool),
        "done": answer is True,
        "choice": answer in ask.choices,
        "numbers": isinstance(answer, tuple) and (not ask.count or len(answer) == ask.count),
    }[ask.kind]
    if fits:
        return answer
    wanted = {
        "number": "a number",
        "text": "a text",
        "yes": "yes or no",
        "done": "that it is done",
        "choice": f"one of {', '.join(ask.choices)}",
        "numbers": f"{ask.count or 'some'} numbers",
    }[ask.kind]
    raise AnswerRefused(ask.key, f"{wanted} is expected, not {answer!r}")
