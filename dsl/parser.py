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

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from functools import cache
from importlib import resources
from itertools import pairwise
from typing import TYPE_CHECKING, cast

from dsl.spans import NOWHERE
from dsl.syntax_errors import (
    DECLARATION_TERMINALS,
    STATEMENT_TERMINALS,
    Refusal,
    explain,
    token_span,
)
from dsl.words import printable

if TYPE_CHECKING:
    from lark import Lark, Token, Tree

    from dsl.diagnostics import Report

    Child = Token | Tree[Token]

MAX_CHARACTERS = 500_000
"""Largest script that is read."""

_SYNC_TERMINALS = DECLARATION_TERMINALS | STATEMENT_TERMINALS | {"RBRACE"}


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
    tokens = _drop_bad_tokens(_tokens(text), report)
    mentioned = frozenset(
        (str(word), str(name))
        for word, name in pairwise(tokens)
        if word.type in DECLARATION_TERMINALS and name.type == "NAME"
    )
    return Parsed(_Parsing(tokens, report).run(), mentioned)


def _tokens(text: str) -> Iterator[Token]:
    """Return the tokens of a text, by way of the lexer that the parser has already."""
    parser = grammar().parse_interactive(text)
    tokens = parser.lexer_thread.lex(parser.parser_state)  # type: ignore[no-untyped-call]
    return cast("Iterator[Token]", tokens)


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
    """Report what is no token of the language; make the best of it."""
    read = list(tokens)
    if not any(token.type.startswith("BAD") for token in read):
        return read
    kept: list[Token] = []
    is_glued = False
    for token in read:
        if token.type == "BAD_TEXT":
            span = token_span(token)
            report.add("E103", span, "the text is not closed", 'put a `"` at its end')
            token = token.update(type="TEXT", value=f'{token.rstrip(chr(92))}"')
        elif token.type == "BAD_CHARACTERS":
            shown = printable(token[:20])
            is_letter = any(character.isalpha() for character in token)
            hint = "names have ASCII letters, digits and `_`" if is_letter else ""
            report.add("E102", token_span(token), f"`{shown}` is not used here", hint)
            if not is_letter:
                continue
            token = token.update(type="NAME")
            is_glued = True
        if token.type == "NAME" and is_glued and _touches(kept, token):
            kept[-1] = _glued(kept[-1], token)
            continue
        is_glued = token.type == "NAME" and is_glued
        kept.append(token)
    return kept


def _touches(kept: list[Token], token: Token) -> bool:
    """Whether a name goes on where the one before it ended, at a letter that is not ASCII."""
    return bool(kept) and kept[-1].type == "NAME" and kept[-1].end_pos == token.start_pos


def _glued(first: Token, second: Token) -> Token:
    """Return two halves of a name as one."""
    whole = first.update(value=f"{first}{second}")
    whole.end_pos, whole.end_line, whole.end_column = (
        second.end_pos, second.end_line, second.end_column,
    )  # fmt: skip
    return whole


class _Parsing:
    """One pass over the tokens of a script."""

    def __init__(self, tokens: list[Token], report: Report) -> None:
        from lark import Token

        self._tokens = tokens
        self._report = report
        self._parser = grammar().parse_interactive("")
        self._has_run_out = False
        self._end = Token("$END", "", 0, 1, 1, 1, 1, 0)
        if tokens:
            self._end = Token.new_borrow_pos("$END", "", tokens[-1])

    def run(self) -> Tree[Token] | None:
        from lark import UnexpectedToken

        feed = self._parser.parser_state.feed_token
        tokens = self._tokens
        index, count = 0, len(tokens)
        while index < count:
            try:
                feed(tokens[index])
            except UnexpectedToken:
                place = self._place(index)
                explain(place, self._report)
                if self._report.is_full:
                    self._report.leave_rest(token_span(place.token))
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
            if not self._has_run_out:
                explain(place, self._report)
            if not self._close_block():
                self._rewind_to("$END")
        try:
            result = self._parser.feed_token(self._end)
        except UnexpectedToken:
            return None
        return result if isinstance(result, Tree) else None

    # ------------------------------------------------------------ recovery

    def _recover(self, place: Refusal) -> int:
        """Bring parser and tokens to a point where they fit; return the next index."""
        tokens = self._tokens
        refused: set[str] = set()
        for index in range(place.index, len(tokens)):
            token = tokens[index]
            if token.type not in _SYNC_TERMINALS or not self._may_begin(index, place.index):
                continue
            if token.type in refused:
                continue
            if token.type in DECLARATION_TERMINALS and self._close_block():
                return index
            if self._rewind_to(token.type):
                return index
            refused.add(token.type)
        self._has_run_out = True
        return len(tokens)

    def _may_begin(self, index: int, refused: int) -> bool:
        """Whether the token at `index` can begin something new, going by its surroundings."""
        token = self._tokens[index]
        if token.type == "RBRACE":
            return True
        before = self._tokens[index - 1] if index else None
        begins_line = before is None or (token.line or 0) > (before.end_line or 0)
        if token.type in DECLARATION_TERMINALS:
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
        stack = self._parser.parser_state.value_stack
        closed = [i for i, value in enumerate(stack) if _is_token(value, "RBRACE")]
        # A block that is closed stays closed: only what came after it may go.
        floor = closed[-1] + 1 if closed else 0
        for depth in range(self._depth, floor, -1):
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

    def _place(self, index: int) -> Refusal:
        tokens = self._tokens
        token = tokens[index] if index < len(tokens) else self._end
        previous = tokens[index - 1] if index else None
        return Refusal(index, token, previous, self._accepted(), self._open_block(index))

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
            if token.type in DECLARATION_TERMINALS and self._looks_like_declaration(position):
                return token
        return None


def _is_token(value: Child, terminal: str) -> bool:
    return isinstance(value, str) and value.type == terminal
