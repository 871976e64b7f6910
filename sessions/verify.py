"""Proves that a recorded session repeats: the same lines bring the same replies.

The recorded lines are fed to a fresh session on a fresh twin, at full speed and
without sockets. Replies are compared byte by byte, views by the hash of their
bytes, which a second thread computes while the next frame is rendered.

Lines that were answered `BUSY` are left out: that answer came from what other
clients did, and the line had no effect.
"""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Protocol

from sessions.journal import Reply
from sessions.recording.reader import RecordedStep, SessionRecording
from sessions.verify_report import Difference, Exchange, VerifyReport

_BUSY = b"BUSY\n"
_CONTEXT = 4
_HASHES_AHEAD = 6

Progress = Callable[[int, int], None]


class Replayed(Protocol):
    """A session that is fed with lines."""

    def handle(self, line: bytes) -> Reply:
        """Carry out one line and return the reply."""

    def end(self, reason: str) -> None:
        """Give back whatever the session has."""


def _no_progress(done: int, total: int) -> None:
    pass


def verify(
    recording: SessionRecording,
    *,
    script_text: str | None = None,
    progress: Progress = _no_progress,
) -> VerifyReport:
    """Replay a recording on a fresh twin and compare every reply.

    Args:
        recording: The recording; one that was cut short is compared as far as it goes.
        script_text: Replay with this script instead of the recorded one.
        progress: Told after every line how many of how many are done.

    Returns:
        What was compared, and the first difference, if there is one.

    Raises:
        SessionsError: The recorded script or profile cannot be used by this program.
        CellError: The recorded world cannot be restored.
    """
    from sessions.verify_twin import fresh_session

    with fresh_session(recording.start, script_text) as session:
        return compare(recording, session, progress)


def compare(
    recording: SessionRecording, session: Replayed, progress: Progress = _no_progress
) -> VerifyReport:
    """Feed the recorded lines to a session and compare its replies with the recorded ones."""
    steps = [step for step in recording.steps() if step.reply is not None]
    with ThreadPoolExecutor(1, "view-hash") as pool:
        comparison = _Comparison(recording.view_hashes(), pool)
        for done, step in enumerate(steps, 1):
            if comparison.take(step, session):
                break
            progress(done, len(steps))
        comparison.settle()
        session.end("replayed")
    return comparison.report(is_cut_short=not recording.is_finished)


@dataclass(frozen=True, slots=True)
class _Hashing:
    """A view whose hash is being computed, and what to say if it is wrong."""

    expected: str
    future: Future[str]
    step: RecordedStep
    reply: Reply
    context: tuple[Exchange, ...]


@dataclass(slots=True)
class _Comparison:
    recorded: dict[int, str]
    pool: ThreadPoolExecutor
    compared: int = 0
    views: int = 0
    unproven: int = 0
    skipped: int = 0
    difference: Difference | None = None
    context: deque[Exchange] = field(default_factory=lambda: deque(maxlen=_CONTEXT))
    hashing: deque[_Hashing] = field(default_factory=deque)
    last_data: bytes | memoryview = b""
    last_future: Future[str] | None = None

    def take(self, step: RecordedStep, session: Replayed) -> bool:
        """Replay a step; return whether the comparison is over."""
        if step.reply == _BUSY:
            self.skipped += 1
            return False
        reply = session.handle(step.line)
        if reply.text != step.reply or reply.closes != step.closes:
            # A view of an earlier step may differ, too, and that would be the first difference.
            self.settle()
            self._differ(step, reply, "reply", tuple(self.context))
        elif len(reply.data) != step.data_size or (reply.view is None) != (step.view is None):
            self.settle()
            self._differ(step, reply, "data", tuple(self.context))
        else:
            self.compared += 1
            self._take_view(step, reply)
        self.context.append(Exchange(step.number, step.line, step.reply or b""))
        while len(self.hashing) > _HASHES_AHEAD:
            self._settle_one()
        return self.difference is not None

    def settle(self) -> None:
        """Wait for all hashes."""
        while self.hashing:
            self._settle_one()

    def report(self, *, is_cut_short: bool) -> VerifyReport:
        """Return the result."""
        return VerifyReport(
            lines=self.compared,
            views=self.views,
            views_unproven=self.unproven,
            lines_skipped=self.skipped,
            is_cut_short=is_cut_short,
            difference=self.difference,
        )

    def _take_view(self, step: RecordedStep, reply: Reply) -> None:
        if step.view is None:
            return
        expected = self.recorded.get(step.view.view)
        if expected is None:
            self.unproven += 1
            return
        context = tuple(self.context)
        self.hashing.append(_Hashing(expected, self._hash(reply.data), step, reply, context))

    def _hash(self, data: bytes | memoryview) -> Future[str]:
        """Return the hash to come; bytes shared with the view before are hashed once."""
        if self.last_future is None or data is not self.last_data:
            self.last_data = data
            self.last_future = self.pool.submit(_sha256, data)
        return self.last_future

    def _settle_one(self) -> None:
        one = self.hashing.popleft()
        if one.future.result(timeout=60.0) == one.expected:
            self.views += 1
        else:
            self._differ(one.step, one.reply, "view", one.context)

    def _differ(
        self, step: RecordedStep, reply: Reply, what: str, context: tuple[Exchange, ...]
    ) -> None:
        if self.difference is None:
            self.difference = Difference(
                step=step.number,
                line=step.line,
                what=what,
                recorded=step.reply or b"",
                replayed=reply.text,
                recorded_bytes=step.data_size,
                replayed_bytes=len(reply.data),
                context=context,
            )


def _sha256(data: bytes | memoryview) -> str:
    return hashlib.sha256(data).hexdigest()
