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
from sessions.phase import TURNS, Phase, Turn
from sessions.script import TaskSpec
from sessions.seeds import derive_seed
from sessions.session_log import SessionLog
from sessions.task import TaskRun
from sessions.wire import commands as c
from sessions.wire import replies as r
from sessions.wire.dialects import Dialect, Teacher
from sessions.wire.writing import write_answer

_log = logging.getLogger(__name__)

BACKLOG_LINES = 4096
"""How many lines before taking the cell are kept for the journal."""

_FOR_EVERYBODY = (c.Status, c.Info, c.Done, c.ListGoals, c.ListEnvironments)
_STATES: dict[str, r.State] = {
    "running": "STATE_UPDATED",
    "finished": "FINISHED",
    "failed": "FAILED",
}


class Session:
    """The state of one connection. Used by one thread."""

    def __init__(self, desk: Desk, dialect: Dialect, peer: str) -> None:
        self._desk = desk
        self._dialect = dialect
        self._peer = peer
        self._is_late = desk.is_asleep
        self._max_line_bytes = desk.profile.server.max_line_bytes
        self._phase = Phase.NO_TASK
        self._log = SessionLog()
        self._backlog: deque[tuple[bytes, Reply]] = deque(maxlen=BACKLOG_LINES)
        self._journal: Journal | None = None
        self._leaving = ""
        self._global_seed: int | None = None
        self._seed = 0
        self._begun_seed: int | None = None
        self._tasks = 0
        self._spec: TaskSpec | None = None
        self._run: TaskRun | None = None
        self._is_teaching = False

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
            self._abandon_task()
        noted = attempt(lambda: self._note(line, reply))
        if isinstance(noted, Mishap):
            _log.error("%s: the session is not recorded on: %s", self._peer, noted.detail)
            self.end("recording failed")
        return reply

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

    def _answer(self, line: bytes) -> r.Answer | Reply:
        if len(line) > self._max_line_bytes:
            return r.Failure(f"The line is longer than {self._max_line_bytes} bytes")
        is_in_setup = self._phase is Phase.IN_SETUP
        command = c.parse_command(line, self._dialect, is_in_setup=is_in_setup)
        if isinstance(command, r.UnknownCommand | r.InvalidArguments):
            return command
        if isinstance(command, c.Action) and self._run is not None:
            return self._action(self._run, command.action)
        if self._is_busy() and not isinstance(command, _FOR_EVERYBODY):
            return r.Busy()
        return self._carry_out(line, command)

    def _is_busy(self) -> bool:
        return self._is_late or self._desk.is_taken_from(self)

    def _carry_out(self, line: bytes, command: c.Command) -> r.Answer | Reply:
        match command:
            case c.GetView(view=view):
                return self._get_view(view)
            case c.ResetTask():
                return self._reset_task()
            case c.InitializeTask(goal=goal, environment=environment):
                return self._initialize_task(line, goal, environment)
            case c.BeginTaskSetup():
                return self._begin_task_setup()
            case c.Setting(name=name):
                return r.Failure(f"unknown setting {name}")
            case c.EndTaskSetup():
                return self._end_task_setup()
            case c.Teaching(is_on=is_on):
                return self._teaching(is_on=is_on)
            case c.UseGlobalSeed(seed=seed):
                return self._use_global_seed(seed)
            case c.Reset():
                return self._reset()
            case c.Done():
                self._clean_up("done")
                return r.Goodbye()
            case _:
                return self._inform(command)

    def _inform(self, command: c.Command) -> r.Answer:
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
            case c.GetTrajectoryLength(index=index):
                return r.UnknownTrajectory(index)
            case c.GetTrajectoriesCount():
                return r.TrajectoriesCount(0)
            case _:
                return r.NoTaskSelected()

    # A task and its set-up

    def _initialize_task(self, line: bytes, goal: str, environment: str) -> r.Answer:
        script = self._desk.script
        if goal not in script.goals:
            return r.UnknownGoal(goal)
        if environment not in script.environments(goal):
            return r.UnknownEnvironment(environment)
        if not self.has_cell and not self._take_cell(line):
            return r.Busy()
        self._drop_run("another task")
        self._turn(Turn.INITIALIZED)
        spec = self._spec = script.task(goal, environment)
        self._is_teaching = False
        views = (r.OfferedView(v.name, v.width_px, v.height_px) for v in spec.views)
        mode: r.Mode = "TEACHER" if spec.is_teaching else "STANDARD"
        return r.TaskOffer(spec.actions, tuple(views), mode if self._dialect.has_mode else None)

    def _begin_task_setup(self) -> r.Answer:
        if self._phase is Phase.NO_TASK:
            return r.NoTaskSelected()
        if self._phase is Phase.IN_SETUP:
            return r.Failure("Task setup already started")
        self._drop_run("set up again")
        self._turn(Turn.SETUP_BEGUN)
        return r.Ok()

    def _end_task_setup(self) -> r.Answer:
        if self._spec is None or self._phase is not Phase.IN_SETUP:
            return r.Failure("Task setup not started")
        is_set_up = False
        try:
            run = self._run = self._new_run(self._spec)
            run.set_up()
            is_set_up = True
        finally:
            if not is_set_up:
                self._drop_run("set-up failed")
            self._turn(Turn.SETUP_ENDED if is_set_up else Turn.SETUP_FAILED)
        self._log.task(run.spec, run.seed)
        if self._dialect.setup_answers_state:
            return r.StateUpdated(self._suggestion(run))
        return r.Ok()

    def _new_run(self, spec: TaskSpec) -> TaskRun:
        seed = self._seed if self._global_seed is None else self._global_seed
        if seed != self._begun_seed:
            self._desk.cell.begin_session(seed)
            self._begun_seed = seed
            self._tasks = 0
        self._tasks += 1
        return TaskRun(self._desk, spec, derive_seed(seed, "task", self._tasks - 1))

    def _teaching(self, *, is_on: bool) -> r.Answer:
        if self._spec is None:
            return r.NoTaskSelected()
        if not self._spec.is_teaching:
            return r.NotSupported()
        self._is_teaching = is_on
        return r.Ok()

    # A task that is ready

    def _action(self, run: TaskRun, action: str) -> r.Answer:
        if action not in run.spec.actions:
            return r.UnknownAction(action)
        if run.status != "running":
            return r.Failure(f"The task has {run.status}: send RESET_TASK first")
        outcome = run.act(action)
        self._log.step(action, outcome)
        return r.ActionDone(
            outcome.reward, outcome.event or "", self._suggestion(run), _STATES[outcome.status]
        )

    def _suggestion(self, run: TaskRun) -> str:
        match self._dialect.teacher:
            case Teacher.ON_REQUEST if self._is_teaching:
                return run.suggest()
            case Teacher.BY_MODE if run.spec.is_teaching:
                return run.suggest()
            case _:
                return ""

    def _get_view(self, name: str) -> r.Answer | Reply:
        if self._run is None:
            return r.NoTaskSelected()
        view = self._run.view_spec(name)
        if view is None:
            return r.UnknownView(name)
        sent, encoded = self._run.look(view)
        text, data = write_answer(r.ViewData(name, view.mime, encoded), self._dialect)
        return Reply(text, data, view=sent)

    def _reset_task(self) -> r.Answer:
        if self._run is None:
            return r.NoTaskSelected()
        self._run.reset()
        self._log.reset()
        return r.StateUpdated(self._suggestion(self._run))

    # The session

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
        self._begun_seed = None
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
            backlog=tuple(self._backlog),
        )
        self._journal = desk.journal_factory(start)
        self._journal.received(line)
        if self._global_seed is None:
            self._log.seed(self._seed, "drawn by the server")
        _log.info("%s: session %s, seed %d", self._peer, start.session_id, self._seed)

    def _clean_up(self, reason: str) -> None:
        """End the task, bring the blocks home and switch the devices off."""
        if not self.has_cell:
            return
        self._drop_run(reason)
        closed = attempt(self._desk.cell.close)
        if isinstance(closed, Mishap):
            _log.error("%s: closing the cell: %s", self._peer, closed.detail)
        self._turn(Turn.SESSION_ENDED)
        self._spec = None
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

    def _abandon_task(self) -> None:
        """End the task after something that nobody foresaw."""
        self._drop_run("internal error")
        self._spec = None
        self._turn(Turn.TASK_DROPPED)

    def _drop_run(self, reason: str) -> None:
        """End the running task, if there is one, and bring its blocks home."""
        run, self._run = self._run, None
        if run is None:
            return
        self._log.ended(reason)
        ended = attempt(lambda: run.end(reason))
        if isinstance(ended, Mishap):
            _log.error("%s: cleaning up: %s", self._peer, ended.detail)

    def _turn(self, turn: Turn) -> None:
        self._phase = TURNS[self._phase, turn]


def _shown(line: bytes) -> str:
    return ascii(line[:80].decode("utf-8", "backslashreplace")) + ("..." if line[80:] else "")
