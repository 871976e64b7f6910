"""What a replay found, for people and for programs."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Exchange:
    """A line and its reply, to show around a difference."""

    step: int
    line: bytes
    reply: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """The first reply that is not as recorded.

    Attributes:
        step: Number of the line in the session.
        line: The client's line.
        what: `reply` when the text differs, `data` when the amount of data does,
            `view` when its bytes do.
        recorded: The recorded reply's text.
        replayed: The replayed reply's text.
        recorded_bytes: Size of the recorded data.
        replayed_bytes: Size of the replayed data.
        context: The lines before it.
    """

    step: int
    line: bytes
    what: str
    recorded: bytes
    replayed: bytes
    recorded_bytes: int
    replayed_bytes: int
    context: tuple[Exchange, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class VerifyReport:
    """The result of a replay.

    Attributes:
        lines: How many replies were the same.
        views: How many views were the same.
        views_unproven: How many views the recording has no hash of (it was cut short).
        lines_skipped: How many lines were left out, for they were answered `BUSY`.
        is_cut_short: Whether the recording was not finished.
        difference: The first difference, or None.
    """

    lines: int
    views: int
    views_unproven: int
    lines_skipped: int
    is_cut_short: bool
    difference: Difference | None

    @property
    def is_identical(self) -> bool:
        """Whether there is no difference."""
        return self.difference is None

    def describe(self) -> str:
        """Return the result in words, the verdict in the first line."""
        notes = "".join(f"\n  {note}" for note in self._notes())
        if self.difference is None:
            return f"identical: {self.lines} replies and {self.views} views are as recorded{notes}"
        return _describe(self.difference) + notes

    def as_json(self) -> dict[str, object]:
        """Return the result as values that JSON knows."""
        found = self.difference
        return {
            "identical": self.is_identical,
            "lines": self.lines,
            "views": self.views,
            "views_unproven": self.views_unproven,
            "lines_skipped": self.lines_skipped,
            "is_cut_short": self.is_cut_short,
            "difference": None
            if found is None
            else {
                "step": found.step,
                "line": _text(found.line),
                "what": found.what,
                "recorded": _text(found.recorded),
                "replayed": _text(found.replayed),
                "recorded_bytes": found.recorded_bytes,
                "replayed_bytes": found.replayed_bytes,
                "context": [
                    {"step": e.step, "line": _text(e.line), "reply": _text(e.reply)}
                    for e in found.context
                ],
            },
        }

    def _notes(self) -> list[str]:
        notes = []
        if self.is_cut_short:
            notes.append("the recording was not finished; it was compared as far as it goes")
        if self.views_unproven:
            notes.append(f"{self.views_unproven} views have no hash in the recording")
        if self.lines_skipped:
            notes.append(f"{self.lines_skipped} lines answered BUSY were left out")
        return notes


def _describe(found: Difference) -> str:
    lines = [f"different at step {found.step}: {_text(found.line)}"]
    for exchange in found.context:
        lines.append(f"  {exchange.step:5d}   > {_text(exchange.line)}")
        lines += [f"          < {_text(part)}" for part in exchange.reply.splitlines()]
    lines.append(f"  {found.step:5d}   > {_text(found.line)}")
    if found.what == "view":
        lines.append(f"          the picture's {found.recorded_bytes} bytes are not the recorded")
        return "\n".join(lines)
    lines += _reply("recorded", found.recorded, found.recorded_bytes)
    lines += _reply("replayed", found.replayed, found.replayed_bytes)
    return "\n".join(lines)


def _reply(who: str, text: bytes, size: int) -> list[str]:
    lines = [f"  {who} < {_text(part)}" for part in text.splitlines()]
    return [*lines, f"  {who} < ... {size} bytes ..."] if size else lines


def _text(data: bytes) -> str:
    """Return bytes as text in which nothing can steer a terminal."""
    text = data.decode("utf-8", "backslashreplace")
    return "".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in text)
