"""What to say where the text does not continue as the language does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dsl.spans import Span
from dsl.words import (
    DECLARATIONS,
    LATER_WORDS,
    STATEMENT_WORDS,
    STATEMENTS,
    WORDS,
    describe_terminal,
    describe_token,
    did_you_mean,
    enumerate_words,
    printable,
)

if TYPE_CHECKING:
    from lark import Token

    from dsl.diagnostics import Report

DECLARATION_TERMINALS = frozenset(word.upper() for word in DECLARATIONS)
"""Terminals that begin a declaration."""

STATEMENT_TERMINALS = frozenset(word.upper() for word in STATEMENT_WORDS)
"""Terminals that begin a statement."""


def token_span(token: Token) -> Span:
    """Return where a token stands."""
    return Span(
        token.start_pos or 0,
        token.end_pos or 0,
        token.line or 1,
        token.column or 1,
        token.end_line or 1,
        token.end_column or 1,
    )


@dataclass(frozen=True, slots=True)
class Refusal:
    """Where the parser was when it refused a token.

    Attributes:
        index: Number of the token.
        token: The token.
        previous: The one before it.
        accepted: The terminals that could have come instead.
        block: The word that begins the declaration it is in.
    """

    index: int
    token: Token
    previous: Token | None
    accepted: set[str]
    block: Token | None

    @property
    def starts_line(self) -> bool:
        """Whether it is the first in its line."""
        return self.previous is None or (self.token.line or 0) > (self.previous.end_line or 0)

    @property
    def is_statement_place(self) -> bool:
        """Whether a statement or declaration could begin here."""
        begins = self.starts_line or (
            self.previous is not None and self.previous.type in ("LBRACE", "RBRACE")
        )
        wanted = DECLARATION_TERMINALS | STATEMENT_TERMINALS
        return begins and len(self.accepted & wanted) > 0 and "NAME" not in self.accepted

    @property
    def sort(self) -> str | None:
        """The declaration it is in, such as `goal`."""
        return None if self.block is None else str(self.block)


def explain(place: Refusal, report: Report) -> None:
    """Report why a token does not fit, by the first explanation that applies."""
    explanations: tuple[Callable[[Refusal, Report], bool], ...] = (
        _missing_brace,
        _reserved_word,
        _misplaced_statement,
        _unknown_statement,
    )
    for explanation in explanations:
        if explanation(place, report):
            return
    _unexpected(place, report)


def _missing_brace(place: Refusal, report: Report) -> bool:
    ends = place.token.type == "$END"
    begins = place.token.type in DECLARATION_TERMINALS and place.token.column == 1
    if not (ends or begins) or "RBRACE" not in place.accepted or place.block is None:
        return False
    what = "the file ends" if ends else f"`{place.token}` begins"
    message = f"{what} before the {place.block} of line {place.block.line} is closed"
    previous = place.previous or place.token
    report.add("E106", token_span(previous).after(), message, "put a `}` here")
    return True


def _reserved_word(place: Refusal, report: Report) -> bool:
    word = str(place.token)
    span = token_span(place.token)
    if word in LATER_WORDS and place.is_statement_place:
        message = f"`{word}` is kept for a later version of the language"
        report.add("E105", span, message, "leave this part out")
        return True
    is_word = place.token.type not in ("NAME", "TEXT") and word in WORDS
    if (
        not is_word
        or "NAME" not in place.accepted
        or (place.starts_line and word in STATEMENT_WORDS)
    ):
        return False  # fmt: skip
    message = f"`{word}` is a word of the language and cannot be a name"
    report.add("E105", span, message, f"use another name, such as `{word.upper()}`")
    return True


def _misplaced_statement(place: Refusal, report: Report) -> bool:
    word = str(place.token)
    if word not in STATEMENT_WORDS or place.token.type == "TEXT" or not place.is_statement_place:
        return False
    if place.sort is not None and word in STATEMENTS[place.sort]:
        return False
    where = [f"{sort} {{ }}" for sort, words in STATEMENTS.items() if word in words]
    here = "outside of a declaration" if place.sort is None else f"in {_article(place.sort)}"
    hint = f"it belongs in {enumerate_words(where)}"
    report.add("E108", token_span(place.token), f"`{word}` cannot stand {here}", hint)
    return True


def _unknown_statement(place: Refusal, report: Report) -> bool:
    word = str(place.token)
    is_slip = place.token.type == "NAME" or (
        place.token.type in DECLARATION_TERMINALS and place.sort is not None
    )
    if not is_slip or not place.is_statement_place:
        return False
    known = DECLARATIONS if place.sort is None else STATEMENTS[place.sort]
    what = "declaration" if place.sort is None else f"statement of {_article(place.sort)}"
    hint = did_you_mean(word, known)
    report.add("E104", token_span(place.token), f"`{printable(word[:40])}` begins no {what}", hint)
    return True


def _unexpected(place: Refusal, report: Report) -> None:
    found = describe_token(place.token.type, str(place.token))
    starters = DECLARATION_TERMINALS | STATEMENT_TERMINALS
    expected = sorted(describe_terminal(t) for t in place.accepted - starters)
    begins = place.accepted & starters
    if len(begins) > 3:
        expected.append("a declaration" if "STORE" in begins else "a statement")
    else:
        expected += sorted(describe_terminal(t) for t in begins)
    wanted = enumerate_words(expected) or "nothing more"
    is_cut_short = place.starts_line or place.token.type == "$END"
    if place.previous is not None and is_cut_short and not begins:
        after = describe_token("", str(place.previous))
        message = f"expected {wanted} after {after}, found {found}"
        report.add("E101", token_span(place.previous).after(), message)
    else:
        report.add("E101", token_span(place.token), f"expected {wanted}, found {found}")


def _article(sort: str) -> str:
    return f"an {sort}" if sort[0] in "ae" else f"a {sort}"
