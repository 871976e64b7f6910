"""Where the emulated arm is and how its controller is, as requests ask for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from cell.drivers.melfa_r3 import records, tables
from cell.twin.emulators.melfa_r3.editing import Editing
from cell.twin.emulators.melfa_r3.interpreter import Interpreter
from cell.twin.emulators.melfa_r3.mechanism import Mechanism
from cell.twin.emulators.melfa_r3.planner import Planner
from cell.twin.emulators.melfa_r3.program import ProgramRunner
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.state import ControllerState


class Reports:
    """The commands that only look.

    Attributes:
        handlers: What each command does.
    """

    def __init__(
        self,
        state: ControllerState,
        mechanism: Mechanism,
        planner: Planner,
        *,
        interpreter: Interpreter,
        runner: ProgramRunner,
        editing: Editing,
    ) -> None:
        self._state = state
        self._mechanism = mechanism
        self._planner = planner
        self._interpreter = interpreter
        self._runner = runner
        self._editing = editing
        self.handlers: Mapping[str, Callable[[str, float, float], str]] = {
            "PPOSF": self._pose, "JPOSF": self._joints,
            "PPOS": self._one_coordinate, "JPOS": self._one_joint,
            "STATE": self._full_state, "DSTATE": self._short_state, "STPSIG": self._stop_sources,
        }  # fmt: skip

    def _is_running(self, now_s: float) -> bool:
        return self._runner.is_running or self._mechanism.is_moving(now_s)

    def _pose(self, args: str, now_s: float, at_s: float) -> str:
        stand = self._mechanism.stand(now_s)
        pose = self._interpreter.tool.from_fitted(stand.reported_pose)
        values = (pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg)
        return self._axes(records.CARTESIAN, values, (stand.posture, stand.turns), now_s)

    def _joints(self, args: str, now_s: float, at_s: float) -> str:
        return self._axes(records.JOINTS, self._mechanism.joints_deg(now_s), None, now_s)

    def _one_coordinate(self, args: str, now_s: float, at_s: float) -> str:
        report = records.parse_axes(self._pose(args, now_s, at_s))
        return self._one(report, args)

    def _one_joint(self, args: str, now_s: float, at_s: float) -> str:
        report = records.parse_axes(self._joints(args, now_s, at_s))
        return self._one(report, f"J{args}")

    def _one(self, report: records.AxisReport, name: str) -> str:
        if name not in report.names:
            raise Refusal(tables.ARGUMENT_RANGE)
        value = report.values[report.names.index(name)]
        return records.print_axes(report._replace(names=(name,), values=(value,)))

    def _axes(
        self,
        names: tuple[str, ...],
        values: tuple[float, ...],
        flags: tuple[int, int] | None,
        now_s: float,
    ) -> str:
        mechanism = self._mechanism
        speed = mechanism.speed_mm_s(now_s)
        mask = self._planner.limit_mask(mechanism.joints_deg(now_s))
        return records.print_axes(
            records.AxisReport(names, values, flags, self._state.override_percent, speed, mask)
        )

    def _full_state(self, args: str, now_s: float, at_s: float) -> str:
        state = self._state
        is_running = self._is_running(now_s)
        return records.print_full_state(
            records.FullState(
                program=state.program,
                line=str(self._runner.line),
                override_percent=state.override_percent,
                edit=self._editing.status(is_running=is_running),
                run=state.run_status(now_s, is_running=is_running),
                stop=state.stop_status(is_running=is_running),
                error=state.alarm,
                step="1",
                mechanism_mask=1,
                slot_program=state.program,
                is_cyclic=state.is_cyclic,
                start="START",
                priority="1",
                mechanism="1" if is_running else "0",
            )
        )

    def _short_state(self, args: str, now_s: float, at_s: float) -> str:
        is_running = self._is_running(now_s)
        state = self._state
        run = state.run_status(now_s, is_running=is_running)
        stop = state.stop_status(is_running=is_running)
        return f"{run:02X}{stop:02X}{state.alarm};1;{int(is_running)}"

    def _stop_sources(self, args: str, now_s: float, at_s: float) -> str:
        return records.print_stop_sources(self._state.stop_sources())
