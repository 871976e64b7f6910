"""From text to a syntax tree, past every syntax error.

Theory of operation: lark's lexer never fails (see grammar.lark), so the whole text
becomes a list of tokens first. They are fed to lark's LALR parser one by one. Where
it refuses one, the problem is reported and the parser recovers in panic mode: it looks
for the next token that begins a statement or a declaration or closes a block, takes
as many half-done things off its stack as it must to accept that token, and goes on
there. A brace that is plainly missing is put in. So each mistake is reported once, and
the rest of the file is still read.

Nothing beyond `dsl.lower` sees lark's trees.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass
from functools import cache
from importlib import resources
from itertools import pairwise
from typing import TYPE_CHECKING

from dsl.spans import NOWHERE, Span
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
    from lark import Lark, Token, Tree

    from dsl.diagnostics import Report

MAX_CHARACTERS = 500_000
"""Largest script that is read."""

_DECLARATION_TERMINALS = frozenset(word.upper() for word in DECLARATIONS)
_STATEMENT_TERMINALS = frozenset(word.upper() for word in STATEMENT_WORDS)
_SYNC_TERMINALS = _DECLARATION_TERMINALS | _STATEMENT_TERMINALS | {"RBRACE"}


@dataclass(frozen=True, slots=True)
class Parsed:
    """What the parser made of a text.

    Attributes:
        tree: Everything that could be read, or None when nothing could.
        mentioned: Sort and name of each declaration, also of those that are not in the
            tree, so that one wrong declaration does not make every use of it wrong.
    """

    tree: Tree[Token] | None
    mentioned: frozenset[tuple[str, str]]


def parse(text: str, report: Report) -> Parsed:
    """Parse a script as far as it can be understood.

    Args:
        text: The script.
        report: Takes every syntax problem.
    """
    if len(text) > MAX_CHARACTERS:
        message = f"the file has {len(text)} characters, more than {MAX_CHARACTERS}"
        report.add("E107", NOWHERE, message, "split it into several scripts")
        return Parsed(None, frozenset())
    tokens = _drop_bad_tokens(grammar().lex(text), report)
    mentioned = frozenset(
        (str(word), str(name))
        for word, name in pairwise(tokens)
        if word.type in _DECLARATION_TERMINALS and name.type == "NAME"
    )
    return Parsed(_Parsing(tokens, report).run(), mentioned)


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


class _KeepEveryTerminal:
    """Keeps lark from dropping the terminals that no rule uses."""

    always_accept = ("BAD_TEXT", "BAD_CHARACTERS")

    def process(self, stream: Iterator[Token]) -> Iterator[Token]:
        return stream


def grammar_text() -> str:
    """Return the source of the grammar."""
    return (resources.files("dsl") / "grammar.lark").read_text("utf-8")


@cache
def grammar(*, is_strict: bool = False) -> Lark:
    """Return the parser, built when it is first needed.

    Args:
        is_strict: Whether colliding terminals and conflicts of rules are errors, which
            takes longer to find out; for tests.
    """
    from lark import Lark

    return Lark(
        grammar_text(),
        parser="lalr",
        lexer="basic",
        postlex=_KeepEveryTerminal(),
        maybe_placeholders=False,
        strict=is_strict,
    )


def _drop_bad_tokens(tokens: Iterator[Token], report: Report) -> list[Token]:
    """Report what is no token of the language; close unclosed texts."""
    kept: list[Token] = []
    for token in tokens:
        if token.type == "BAD_TEXT":
            span = token_span(token)
            report.add("E103", span, "the text is not closed", 'put a `"` at its end')
            kept.append(token.update(type="TEXT", value=f'{token.rstrip(chr(92))}"'))
        elif token.type == "BAD_CHARACTERS":
            shown = printable(token[:20])
            hint = "names have ASCII letters, digits and `_`" if token[0].isalpha() else ""
            report.add("E102", token_span(token), f"`{shown}` is not used here", hint)
        else:
            kept.append(token)
    return kept


@dataclass(slots=True)
class _Place:
    """Where the parser was when it refused a token."""

    index: int
    token: Token
    previous: Token | None
    accepted: set[str]
    block: Token | None

    @property
    def starts_line(self) -> bool:
        return self.previous is None or (self.token.line or 0) > (self.previous.end_line or 0)

    @property
    def is_statement_place(self) -> bool:
        """Whether a statement or declaration could begin here."""
        begins = self.starts_line or (
            self.previous is not None and self.previous.type in ("LBRACE", "RBRACE")
        )
        wanted = _DECLARATION_TERMINALS | _STATEMENT_TERMINALS
        return begins and len(self.accepted & wanted) > 0 and "NAME" not in self.accepted

    @property
    def sort(self) -> str | None:
        """The declaration it is in, such as `goal`."""
        return None if self.block is None else str(self.block)


class _Parsing:
    """One pass over the tokens of a script."""

    def __init__(self, tokens: list[Token], report: Report) -> None:
        from lark import Token

        self._tokens = tokens
        self._report = report
        self._parser = grammar().parse_interactive("")
        self._end = Token("$END", "", 0, 1, 1, 1, 1, 0)
        if tokens:
            self._end = Token.new_borrow_pos("$END", "", tokens[-1])

    def run(self) -> Tree[Token] | None:
        from lark import UnexpectedToken

        feed = self._parser.feed_token
        tokens = self._tokens
        index, count = 0, len(tokens)
        while index < count:
            try:
                feed(tokens[index])
            except UnexpectedToken:
                place = self._place(index)
                _explain(place, self._report)
                if self._report.is_full:
                    return None
                index = self._recover(place)
            else:
                index += 1
        return self._finish()

    def _finish(self) -> Tree[Token] | None:
        """Feed the end of the file, closing what is open."""
        from lark import Tree, UnexpectedToken

        if not self._accepts(self._depth, "$END"):
            place = self._place(len(self._tokens))
            _explain(place, self._report)
            if not self._close_block():
                self._rewind_to("$END")
        try:
            result = self._parser.feed_token(self._end)
        except UnexpectedToken:
            return None
        return result if isinstance(result, Tree) else None

    # ------------------------------------------------------------ recovery

    def _recover(self, place: _Place) -> int:
        """Bring parser and tokens to a point where they fit; return the next index."""
        tokens = self._tokens
        refused: set[str] = set()
        for index in range(place.index, len(tokens)):
            token = tokens[index]
            if token.type not in _SYNC_TERMINALS or not self._may_begin(index, place.index):
                continue
            if token.type in refused:
                continue
            if token.type in _DECLARATION_TERMINALS and self._close_block():
                return index
            if self._rewind_to(token.type):
                return index
            refused.add(token.type)
        self._rewind_to("RBRACE")
        return len(tokens)

    def _may_begin(self, index: int, refused: int) -> bool:
        """Whether the token at `index` can begin something new, going by its surroundings."""
        token = self._tokens[index]
        if token.type == "RBRACE":
            return True
        before = self._tokens[index - 1] if index else None
        begins_line = before is None or (token.line or 0) > (before.end_line or 0)
        if token.type in _DECLARATION_TERMINALS:
            return self._looks_like_declaration(index)
        return begins_line or (index > refused and before is not None and before.type == "LBRACE")

    def _looks_like_declaration(self, index: int) -> bool:
        following = [t.type for t in self._tokens[index + 1 : index + 3]]
        if len(following) == 2 and following[0] == "NAME" and following[1] in ("LBRACE", "EXTENDS"):
            return True
        return self._tokens[index].column == 1

    def _close_block(self) -> bool:
        """Put in the brace that closes the block the parser is in, if it is in one."""
        from lark import Token

        if not self._rewind_to("RBRACE"):
            return False
        self._parser.feed_token(Token.new_borrow_pos("RBRACE", "}", self._end))
        return True

    @property
    def _depth(self) -> int:
        return len(self._parser.parser_state.state_stack)

    def _rewind_to(self, terminal: str) -> bool:
        """Take off the stack what keeps the parser from accepting a terminal, if that helps."""
        for depth in range(self._depth, 0, -1):
            if self._accepts(depth, terminal):
                state = self._parser.parser_state
                del state.state_stack[depth:]
                del state.value_stack[depth - 1 :]
                return True
        return False

    def _accepts(self, depth: int, terminal: str) -> bool:
        """Whether a terminal would be accepted with only `depth` states on the stack."""
        from lark import Token, UnexpectedToken

        state = self._parser.parser_state.copy(deepcopy_values=False)
        state.parse_conf = copy(state.parse_conf)
        state.parse_conf.callbacks = {}
        del state.state_stack[depth:]
        del state.value_stack[depth - 1 :]
        try:
            state.feed_token(Token(terminal, ""), terminal == "$END")
        except UnexpectedToken:
            return False
        return True

    # ------------------------------------------------------------ where we are

    def _place(self, index: int) -> _Place:
        tokens = self._tokens
        token = tokens[index] if index < len(tokens) else self._end
        previous = tokens[index - 1] if index else None
        return _Place(index, token, previous, self._accepted(), self._open_block(index))

    def _accepted(self) -> set[str]:
        """Return the terminals that may come next."""
        state = self._parser.parser_state
        choices = state.parse_conf.parse_table.states[state.position]
        return {t for t in choices if t.isupper() and self._accepts(self._depth, t)}

    def _open_block(self, index: int) -> Token | None:
        """Return the word of the declaration whose block is open, going by the braces."""
        for position in range(index - 1, -1, -1):
            token = self._tokens[position]
            if token.type == "RBRACE":
                return None
            if token.type in _DECLARATION_TERMINALS and self._looks_like_declaration(position):
                return token
        return None


def _explain(place: _Place, report: Report) -> None:
    """Report why a token does not fit, by the first explanation that applies."""
    explanations: tuple[Callable[[_Place, Report], bool], ...] = (
        _missing_brace,
        _reserved_word,
        _misplaced_statement,
        _unknown_statement,
    )
    for explanation in explanations:
        if explanation(place, report):
            return
    _unexpected(place, report)


def _missing_brace(place: _Place, report: Report) -> bool:
    ends = place.token.type == "$END"
    begins = place.token.type in _DECLARATION_TERMINALS and place.token.column == 1
    if not (ends or begins) or "RBRACE" not in place.accepted or place.block is None:
        return False
    what = "the file ends" if ends else f"`{place.token}` begins"
    message = f"{what} before the {place.block} of line {place.block.line} is closed"
    previous = place.previous or place.token
    report.add("E106", token_span(previous).after(), message, "put a `}` here")
    return True


def _reserved_word(place: _Place, report: Report) -> bool:
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


def _misplaced_statement(place: _Place, report: Report) -> bool:
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


def _unknown_statement(place: _Place, report: Report) -> bool:
    word = str(place.token)
    is_slip = place.token.type == "NAME" or (
        place.token.type in _DECLARATION_TERMINALS and place.sort is not None
    )
    if not is_slip or not place.is_statement_place:
        return False
    known = DECLARATIONS if place.sort is None else STATEMENTS[place.sort]
    what = "declaration" if place.sort is None else f"statement of {_article(place.sort)}"
    hint = did_you_mean(word, known)
    report.add("E104", token_span(place.token), f"`{printable(word[:40])}` begins no {what}", hint)
    return True


def _unexpected(place: _Place, report: Report) -> None:
    found = describe_token(place.token.type, str(place.token))
    starters = _DECLARATION_TERMINALS | _STATEMENT_TERMINALS
    expected = sorted(describe_terminal(t) for t in place.accepted - starters)
    begins = place.accepted & starters
    if len(begins) > 3:
        expected.append("a declaration" if "STORE" in begins else "a statement")
    else:
        expected += sorted(describe_terminal(t) for t in begins)
    wanted = enumerate_words(expected) or "nothing more"
    if place.previous is not None and (place.starts_line or place.token.type == "$END"):
        after = describe_token("", str(place.previous))
        message = f"expected {wanted} after {after}, found {found}"
        report.add("E101", token_span(place.previous).after(), message)
    else:
        report.add("E101", token_span(place.token), f"expected {wanted}, found {found}")


def _article(sort: str) -> str:
    return f"an {sort}" if sort[0] in "ae" else f"a {sort}"
