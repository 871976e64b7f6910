"""The commands of a session that are about its task, from its choice to its end."""

from __future__ import annotations

import logging

from sessions.desk import Desk
from sessions.journal import Reply
from sessions.mishaps import Mishap, attempt
from sessions.phase import TURNS, Phase, Turn
from sessions.quality import refusal, shortcomings
from sessions.script import TaskSpec
from sessions.seeds import derive_seed
from sessions.session_log import SessionLog
from sessions.task import TaskRun
from sessions.wire import replies as r
from sessions.wire.dialects import Dialect, Teacher
from sessions.wire.writing import write_answer

_log = logging.getLogger(__name__)

_STATES: dict[str, r.State] = {
    "running": "STATE_UPDATED",
    "finished": "FINISHED",
    "failed": "FAILED",
}


class TaskDialogue:
    """Where a session's task stands, and what its commands do and answer.

    Whoever uses it has the cell. Failures of the cell are raised, after the task
    was left in a state from which it can go on.
    """

    def __init__(self, desk: Desk, dialect: Dialect, peer: str, log: SessionLog) -> None:
        self._desk = desk
        self._dialect = dialect
        self._peer = peer
        self._log = log
        self._phase = Phase.NO_TASK
        self._spec: TaskSpec | None = None
        self._run: TaskRun | None = None
        self._is_teaching = False
        self._begun_seed: int | None = None
        self._tasks = 0

    @property
    def is_in_setup(self) -> bool:
        """Whether lines that are no commands are settings."""
        return self._phase is Phase.IN_SETUP

    # Choice and set-up

    def choose(self, goal: str, environment: str) -> r.Answer:
        """Choose another task; the one that is running ends. Both names are known."""
        self._drop_run("another task")
        self._turn(Turn.INITIALIZED)
        spec = self._spec = self._desk.script.task(goal, environment)
        self._is_teaching = False
        views = (r.OfferedView(v.name, v.width_px, v.height_px) for v in spec.views)
        mode: r.Mode = "TEACHER" if spec.is_teaching else "STANDARD"
        return r.TaskOffer(spec.actions, tuple(views), mode if self._dialect.has_mode else None)

    def begin_setup(self) -> r.Answer:
        """Let settings follow; a task that is running ends."""
        if self._phase is Phase.NO_TASK:
            return r.NoTaskSelected()
        if self._phase is Phase.IN_SETUP:
            return r.Failure("Task setup already started")
        self._drop_run("set up again")
        self._turn(Turn.SETUP_BEGUN)
        return r.Ok()

    def end_setup(self, seed: int) -> r.Answer:
        """Bring the devices up, lay the blocks out, go to the start.

        A cell that is not known as well as is demanded is not brought up.

        Args:
            seed: The session's seed.

        Raises:
            CellError: The cell cannot do it; what lay out is home again.
            DslError: The script has no layout for this seed.
        """
        if self._spec is None or self._phase is not Phase.IN_SETUP:
            return r.Failure("Task setup not started")
        desk = self._desk
        problems = shortcomings(desk.profile, desk.calibrations, self._spec, desk.checks)
        if problems:
            self._turn(Turn.SETUP_FAILED)
            return r.Failure(refusal(problems))
        is_set_up = False
        try:
            run = self._run = self._new_run(self._spec, seed)
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

    def _new_run(self, spec: TaskSpec, seed: int) -> TaskRun:
        if seed != self._begun_seed:
            self._desk.cell.begin_session(seed)
            self._begun_seed = seed
            self._tasks = 0
        self._tasks += 1
        return TaskRun(self._desk, spec, derive_seed(seed, "task", self._tasks - 1))

    def teach(self, *, is_on: bool) -> r.Answer:
        """Suggest actions from now on, or do not."""
        if self._spec is None:
            return r.NoTaskSelected()
        if not self._spec.is_teaching:
            return r.NotSupported()
        self._is_teaching = is_on
        return r.Ok()

    # A task that is ready

    def act(self, action: str) -> r.Answer:
        """Carry out an action.

        Raises:
            CellError: The cell cannot do it; the task is as it was.
        """
        run = self._run
        if run is None:
            return r.NoTaskSelected()
        if action not in run.spec.actions:
            return r.UnknownAction(action)
        if run.status != "running":
            return r.Failure(f"The task has {run.status}: send RESET_TASK first")
        outcome = run.act(action)
        self._log.step(action, outcome)
        event, state = outcome.event or "", _STATES[outcome.status]
        return r.ActionDone(outcome.reward, event, self._suggestion(run), state)

    def look(self, name: str) -> r.Answer | Reply:
        """Return a view as it is now.

        Raises:
            CellError: The camera gives no picture.
        """
        if self._run is None:
            return r.NoTaskSelected()
        view = self._run.view_spec(name)
        if view is None:
            return r.UnknownView(name)
        sent, encoded = self._run.look(view)
        text, data = write_answer(r.ViewData(name, view.mime, encoded), self._dialect)
        return Reply(text, data, view=sent)

    def reset(self) -> r.Answer:
        """Go back to the start.

        Raises:
            CellError: The cell cannot do it.
        """
        if self._run is None:
            return r.NoTaskSelected()
        self._run.reset()
        self._log.reset()
        return r.StateUpdated(self._suggestion(self._run))

    def _suggestion(self, run: TaskRun) -> str:
        match self._dialect.teacher:
            case Teacher.ON_REQUEST if self._is_teaching:
                return run.suggest()
            case Teacher.BY_MODE if run.spec.is_teaching:
                return run.suggest()
            case _:
                return ""

    # The end

    def abandon(self, reason: str) -> None:
        """End the task after a stop, or something that nobody foresaw; never raises."""
        self._drop_run(reason)
        self._spec = None
        self._turn(Turn.TASK_DROPPED)

    def end_session(self, reason: str) -> None:
        """Bring the blocks home and switch the devices off; never raises."""
        self._drop_run(reason)
        closed = attempt(self._desk.cell.close)
        if isinstance(closed, Mishap):
            _log.error("%s: closing the cell: %s", self._peer, closed.detail)
        self._spec = None
        self._begun_seed = None
        self._turn(Turn.SESSION_ENDED)

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
