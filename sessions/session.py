"""One connection's conversation: lines in, replies out, no sockets.

Theory of operation. `handle` reads a line, judges it (is it a command, are its
arguments right, is the cell taken, is there a task), carries it out and writes
the reply. From the moment a session takes the cell a journal is told every line
before it is carried out and every reply before it leaves; what was said before
is handed to the journal as its backlog. The cell is free again when it is clean
and the journal is closed, in this order, so that nothing of the next session
can get into this one's journal.
"""

from __future__ import annotations

import logging
from collections import deque

from sessions.desk import Desk
from sessions.journal import Journal, Reply, SessionStart
from sessions.mishaps import Mishap, attempt
from sessions.session_log import SessionLog
from sessions.task_dialogue import TaskDialogue
from sessions.wire import commands as c
from sessions.wire import replies as r
from sessions.wire.dialects import Dialect
from sessions.wire.writing import write_answer

_log = logging.getLogger(__name__)

BACKLOG_LINES = 4096
"""How many lines before taking the cell are kept for the journal."""

_FOR_EVERYBODY = (c.Status, c.Info, c.Done, c.ListGoals, c.ListEnvironments)


class Session:
    """The state of one connection. Used by one thread."""

    def __init__(self, desk: Desk, dialect: Dialect, peer: str) -> None:
        self._desk = desk
        self._dialect = dialect
        self._peer = peer
        self._is_late = desk.is_asleep
        self._max_line_bytes = desk.profile.server.max_line_bytes
        self._log = SessionLog()
        self._task = TaskDialogue(desk, dialect, peer, self._log)
        self._backlog: deque[tuple[bytes, Reply]] = deque(maxlen=BACKLOG_LINES)
        self._journal: Journal | None = None
        self._leaving = ""
        self._seed = 0
        self._global_seed: int | None = None

    @property
    def has_cell(self) -> bool:
        """Whether this session has the cell."""
        return self._journal is not None

    def handle(self, line: bytes) -> Reply:
        """Carry out one line (without its ending) and return the reply; never raises."""
        outcome = attempt(lambda: self._handle(line))
        if not isinstance(outcome, Mishap):
            return outcome
        reply = self._written(r.Failure(outcome.sentence))
        _log.warning("%s: %s: %s", self._peer, _shown(line), outcome.detail)
        if not outcome.is_expected:
            self._task.abandon("internal error")
        elif outcome.ends_task:
            self._task.abandon("stopped")
        noted = attempt(lambda: self._note(line, reply))
        if isinstance(noted, Mishap):
            _log.error("%s: the session is not recorded on: %s", self._peer, noted.detail)
            self.end("recording failed")
        return reply

    def settle(self) -> None:
        """Let the journal write what could wait for the reply to leave; never raises."""
        journal = self._journal
        if journal is not None:
            outcome = attempt(journal.settled)
            if isinstance(outcome, Mishap):
                _log.error("%s: the recording has a gap: %s", self._peer, outcome.detail)

    def end(self, reason: str) -> None:
        """Give the cell back, clean, if this session has it; never raises."""
        if self.has_cell:
            self._clean_up(reason)
            self._leave_cell(reason)

    # Lines and replies

    def _handle(self, line: bytes) -> Reply:
        if self._journal is not None:
            self._journal.received(line)
        answer = self._answer(line)
        reply = answer if isinstance(answer, Reply) else self._written(answer)
        if isinstance(answer, r.REFUSALS):
            text = reply.text.decode("utf-8", "backslashreplace").rstrip("\n")
            _log.warning("%s: %s: %s", self._peer, _shown(line), text)
        self._note(line, reply)
        return reply

    def _note(self, line: bytes, reply: Reply) -> None:
        """Tell the journal the reply, and let the cell go if it is time."""
        if self._journal is None:
            self._backlog.append((line, reply))
            return
        self._journal.replied(reply)
        if self._leaving:
            self._leave_cell(self._leaving)

    def _written(self, answer: r.Answer) -> Reply:
        text, data = write_answer(answer, self._dialect)
        return Reply(text, data, closes=isinstance(answer, r.Goodbye))

    # Commands

    def _answer(self, line: bytes) -> r.Answer | Reply:
        if len(line) > self._max_line_bytes:
            return r.Failure(f"The line is longer than {self._max_line_bytes} bytes")
        command = c.parse_command(line, self._dialect, is_in_setup=self._task.is_in_setup)
        if isinstance(command, r.UnknownCommand | r.InvalidArguments):
            return command
        if self._is_busy() and not isinstance(command, _FOR_EVERYBODY):
            return r.Busy()
        return self._carry_out(line, command)

    def _is_busy(self) -> bool:
        return self._is_late or self._desk.is_taken_from(self)

    def _carry_out(self, line: bytes, command: c.Command) -> r.Answer | Reply:
        task = self._task
        match command:
            case c.Action(action=action):
                return task.act(action)
            case c.GetView(view=view):
                return task.look(view)
            case c.ResetTask():
                return task.reset()
            case c.InitializeTask(goal=goal, environment=environment):
                return self._initialize_task(line, goal, environment)
            case c.BeginTaskSetup():
                return task.begin_setup()
            case c.Setting(name=name):
                return r.Failure(f"unknown setting {name}")
            case c.EndTaskSetup():
                return task.end_setup(
                    self._seed if self._global_seed is None else self._global_seed
                )
            case c.Teaching(is_on=is_on):
                return task.teach(is_on=is_on)
            case c.UseGlobalSeed(seed=seed):
                return self._use_global_seed(seed)
            case c.Reset():
                return self._reset()
            case c.Done():
                self._clean_up("done")
                return r.Goodbye()
            case _:
                return self._inform(command)

    def _inform(
        self,
        command: c.Status
        | c.Info
        | c.ListGoals
        | c.ListEnvironments
        | c.Sleep
        | c.Logs
        | c.GetTrajectoriesCount
        | c.GetTrajectoryLength,
    ) -> r.Answer:
        """Answer what changes no task."""
        match command:
            case c.Status():
                return r.Busy() if self._is_busy() or self._desk.is_asleep else r.Ready()
            case c.Info():
                return r.ServerInfo("ApplicationServer", "Interactive", self._dialect.version)
            case c.ListGoals():
                return r.Goals(self._desk.script.goals)
            case c.ListEnvironments(goal=goal):
                if goal not in self._desk.script.goals:
                    return r.UnknownGoal(goal)
                return r.Environments(self._desk.script.environments(goal))
            case c.Sleep():
                self._desk.sleep()
                return r.Ok()
            case c.Logs():
                return self._log.files()
            case c.GetTrajectoriesCount():
                return r.TrajectoriesCount(0)
            case c.GetTrajectoryLength(index=index):
                return r.UnknownTrajectory(index)

    def _initialize_task(self, line: bytes, goal: str, environment: str) -> r.Answer:
        script = self._desk.script
        if goal not in script.goals:
            return r.UnknownGoal(goal)
        if environment not in script.environments(goal):
            return r.UnknownEnvironment(environment)
        if not self.has_cell and not self._take_cell(line):
            return r.Busy()
        return self._task.choose(goal, environment)

    def _use_global_seed(self, seed: int) -> r.Answer:
        if self._global_seed is not None:
            return r.GlobalSeedAlreadySet()
        self._global_seed = seed
        self._log.seed(seed, "chosen by the client")
        _log.info("%s: seed %d chosen by the client", self._peer, seed)
        return r.Ok()

    def _reset(self) -> r.Answer:
        self._clean_up("reset")
        self._global_seed = None
        self._log.clear()
        self._backlog.clear()
        return r.Ok()

    # The cell

    def _take_cell(self, line: bytes) -> bool:
        """Take the cell and open the journal; return whether the cell was free.

        Raises:
            SessionsError: The session cannot be recorded.
        """
        if not self._desk.take(self):
            return False
        is_open = False
        try:
            self._open_journal(line)
            is_open = True
        finally:
            if not is_open:
                self._leave_cell("recording failed")
        self._backlog.clear()
        return True

    def _open_journal(self, line: bytes) -> None:
        desk = self._desk
        self._seed = desk.next_seed()
        start = SessionStart(
            session_id=desk.new_session_id(),
            script_name=desk.script.name,
            script_text=desk.script.text,
            profile_text=desk.profile_text,
            dialect=self._dialect.version,
            seed=self._seed,
            world_json=desk.cell.world_json(),
            peer=self._peer,
            versions=desk.versions,
            calibrations=desk.calibrations,
            backlog=tuple(self._backlog),
        )
        self._journal = desk.journal_factory(start)
        self._journal.received(line)
        if self._global_seed is None:
            self._log.seed(self._seed, "drawn by the server")
        _log.info("%s: session %s, seed %d", self._peer, start.session_id, self._seed)

    def _clean_up(self, reason: str) -> None:
        """End the task, bring the blocks home and switch the devices off."""
        if self.has_cell:
            self._task.end_session(reason)
            self._leaving = reason

    def _leave_cell(self, reason: str) -> None:
        """Close the journal and free the cell."""
        journal, self._journal, self._leaving = self._journal, None, ""
        if journal is not None:
            closed = attempt(lambda: journal.close(reason))
            if isinstance(closed, Mishap):
                _log.error("%s: closing the recording: %s", self._peer, closed.detail)
        self._desk.views.forget()
        self._desk.give_back(self)


def _shown(line: bytes) -> str:
    return ascii(line[:80].decode("utf-8", "backslashreplace")) + ("..." if line[80:] else "")
