r"""Words of a line: how they are split, quoted and escaped.

Words are separated by single spaces. A word that holds a space, a quote or a
line break stands in single quotes; inside, `\'` is a quote and `\n` a line
break, and a backslash before anything else is a backslash. So quoted text
cannot say a backslash that comes last or before the letter n: `quote` refuses
it, and `quote_text`, for text that only people read, writes a slash instead.
"""

from __future__ import annotations

import re

from sessions.errors import LocalProtocolError, RemoteProtocolError

_QUOTED = re.compile(r"'((?:[^'\\]|\\'|\\(?!'))*)'(?: |\Z)")
_ESCAPE = re.compile(r"\\(['n])")
_NEEDS_QUOTES = re.compile(r"[ '\n\r]")
_UNSPEAKABLE = re.compile(r"\\(?=n|\Z)")


def split_words(text: str) -> tuple[str, ...]:
    """Return the words of a line, unquoted; an empty line has none.

    Raises:
        RemoteProtocolError: A space too many, a quote that does not end, or a quote
            in the middle of a word.
    """
    if not text:
        return ()
    if "'" not in text:
        words = text.split(" ")
        if "" in words:
            raise RemoteProtocolError("words must be separated by single spaces")
        return tuple(words)
    return _split_quoted(text)


def _split_quoted(text: str) -> tuple[str, ...]:
    words: list[str] = []
    position = 0
    while position <= len(text):
        if text.startswith("'", position):
            match = _QUOTED.match(text, position)
            if match is None:
                raise RemoteProtocolError("a quoted word must end with a quote")
            words.append(_unescape(match.group(1)))
            if not match.group(0).endswith(" "):
                break
            position = match.end()
        else:
            end = text.find(" ", position)
            word = text[position:] if end < 0 else text[position:end]
            if not word or "'" in word:
                raise RemoteProtocolError("a quote or a space stands where it cannot")
            words.append(word)
            if end < 0:
                break
            position = end + 1
    return tuple(words)


def _unescape(quoted: str) -> str:
    if "\\" not in quoted:
        return quoted
    return _ESCAPE.sub(lambda match: "\n" if match.group(1) == "n" else "'", quoted)


def quote(word: str) -> str:
    """Return a word as it stands in a line.

    Raises:
        LocalProtocolError: The word needs quotes and holds a backslash that the
            protocol cannot say there (last, or before the letter n).
    """
    if word and not _NEEDS_QUOTES.search(word):
        return word
    if _UNSPEAKABLE.search(word):
        raise LocalProtocolError(
            f"{word!r} cannot be sent: a quoted word cannot hold a backslash at its end "
            "or before the letter n"
        )
    return "'" + word.replace("'", "\\'").replace("\n", "\\n") + "'"


def quote_text(text: str) -> str:
    """Return text for people as a word; a backslash that cannot be said becomes a slash."""
    if text and not _NEEDS_QUOTES.search(text):
        return text
    return quote(_UNSPEAKABLE.sub("/", text))


def bare_text(text: str) -> str:
    """Return text for people as the unquoted rest of a line; line breaks become spaces."""
    return text.replace("\r", " ").replace("\n", " ")
