"""The words of the language, and how its terminals are called in messages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches

WORDS = frozenset(
    """above accuracy action actions after any as at background block distance environment event
    extends fail finish gap goal hit in inside left lower move nothing of off on otherwise
    outside place random require reward right slot start steps store target teaching to
    travel turned upper views wall when world""".split()  # noqa: SIM905
)
"""Every word with a meaning; none of them can be a name."""

LATER_WORDS = frozenset("and do expect not or play seed setting test".split())  # noqa: SIM905
"""Words kept free for what the language will say later."""

DECLARATIONS = ("store", "action", "environment", "goal")

STATEMENTS: dict[str, tuple[str, ...]] = {
    "store": ("slot",),
    "action": ("move",),
    "environment": (
        "world",
        "background",
        "travel",
        "accuracy",
        "views",
        "actions",
        "teaching",
        "place",
        "require",
    ),
    "goal": ("in", "start", "target", "accuracy", "when", "after", "otherwise", "require"),
}
"""Words that begin a statement, by the declaration that may hold it."""

STATEMENT_WORDS = frozenset(word for words in STATEMENTS.values() for word in words)

_SIGNS = {"LBRACE": "`{`", "RBRACE": "`}`", "LPAR": "`(`", "RPAR": "`)`", "COMMA": "`,`"}
_SORTS = {
    "NAME": "a name",
    "NUMBER": "a number",
    "SIZE": "a size such as 12 x 12",
    "TEXT": 'a text in "quotes"',
    "RELATION": "`>=`, `<=`, `>`, `<` or `=`",
    "$END": "the end of the file",
}


def describe_terminal(terminal: str) -> str:
    """Say in words what a terminal of the grammar stands for."""
    return _SIGNS.get(terminal) or _SORTS.get(terminal) or f"`{terminal.lower()}`"


def describe_token(terminal: str, text: str) -> str:
    """Say in words what was found in the source."""
    if terminal == "$END":
        return "the end of the file"
    shown = text if len(text) <= 40 else text[:37] + "..."
    sort = {"NAME": "the name ", "NUMBER": "the number ", "SIZE": "the size ", "TEXT": "the text "}
    return f"{sort.get(terminal, '')}`{printable(shown)}`"


def printable(text: str) -> str:
    """Return text with everything that could not be shown written as U+XXXX."""
    return "".join(c if c.isprintable() else f"U+{ord(c):04X}" for c in text)


def enumerate_words(words: Sequence[str], last: str = "or") -> str:
    """Join words to `a, b or c`."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def suggestion(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that was probably meant."""
    by_folded = {name.casefold(): name for name in known}
    close = get_close_matches(word.casefold()[:80], list(by_folded), n=1, cutoff=0.6)
    return by_folded[close[0]] if close else None


def did_you_mean(word: str, known: Iterable[str], *, otherwise: str = "") -> str:
    """Return a hint that names the probable word, else all of them if they are few."""
    names = list(known)
    close = suggestion(word, names)
    if close is not None:
        return f"did you mean `{close}`?"
    if otherwise or not names or len(names) > 8:
        return otherwise
    return f"there is {enumerate_words([f'`{n}`' for n in names], 'and')}"
