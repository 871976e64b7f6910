"""One task at the cell, from set-up to clean-up."""

from __future__ import annotations

from cell.events import StepTaken, TaskEnded, TaskStarted
from sessions.binding import CellHost, camera_of
from sessions.desk import Desk
from sessions.journal import SentView
from sessions.script import Outcome, Status, TaskSpec, ViewSpec
from sessions.views import Encoded


class TaskRun:
    """Carries a task out at the cell and tells the event bus what happens."""

    def __init__(self, desk: Desk, spec: TaskSpec, seed: int) -> None:
        self.spec = spec
        self.seed = seed
        self._desk = desk
        self._host = CellHost(desk.cell, desk.profile)
        self._task = desk.script.start(spec.goal, spec.environment, seed=seed, host=self._host)
        self._views = {view.name: view for view in spec.views}
        self._status: Status = "running"
        self._is_begun = False

    @property
    def status(self) -> Status:
        """Whether the task goes on, is solved, or can no longer be solved."""
        return self._status

    def set_up(self) -> None:
        """Bring the devices up, lay the blocks out, go to the start.

        Raises:
            CellError: The cell cannot do it.
            DslError: The script has no layout for this seed.
        """
        self._desk.cell.open()
        self._is_begun = True
        self._task.set_up()
        self._desk.events.emit(
            TaskStarted(self.spec.goal, self.spec.environment, self.seed, self._host.blocks_out)
        )

    def act(self, action: str) -> Outcome:
        """Carry out one action of the task.

        Raises:
            CellError: The cell cannot do it.
        """
        outcome = self._task.act(action)
        self._status = outcome.status
        host = self._host
        self._desk.events.emit(
            StepTaken(
                outcome.step,
                action,
                host.x,
                host.y,
                outcome.reward,
                outcome.event or "",
                outcome.status,
            )
        )
        return outcome

    def reset(self) -> None:
        """Go back to the start.

        Raises:
            CellError: The cell cannot do it.
        """
        self._task.reset()
        self._status = "running"

    def suggest(self) -> str:
        """Return a good next action, or an empty text if there is none."""
        if self._status != "running":
            return ""
        return self._task.suggest() or ""

    def view_spec(self, name: str) -> ViewSpec | None:
        """Return a view of the task, or None if it has none of that name."""
        return self._views.get(name)

    def look(self, view: ViewSpec) -> tuple[SentView, Encoded]:
        """Return what a view shows now, and its bytes.

        Raises:
            CellError: The camera gives no picture.
        """
        frame = self._desk.cell.grab(camera_of(view.name), view.width_px, view.height_px)
        return SentView(frame, view.mime), self._desk.views.encode(frame, view.mime)

    def end(self, reason: str) -> None:
        """Bring the blocks home, if the devices came up to lay any out.

        Raises:
            CellError: A block could not be brought home; the ledger knows where it is.
        """
        try:
            if self._is_begun:
                self._desk.cell.clean()
        finally:
            self._desk.events.emit(TaskEnded(reason))
