"""Sending moves in step with the clock, watching them, and seeing them end."""

from __future__ import annotations

from collections.abc import Callable

from cell.clock import Clock
from cell.drivers.ssc32.joints import ServoJoints
from cell.drivers.ssc32.panel import ServoPanel
from cell.drivers.ssc32.settings import Ssc32Settings
from cell.drivers.ssc32.tables import GREATEST_TIME_MS
from cell.errors import CellError, DeviceError, DeviceTimeout
from cell.geometry import JointPositions

Segment = tuple[tuple[int, ...], float]
"""Pulse widths of all joints, and the time to get there."""


class MoveSender:
    """Plays moves of all joints on the controller.

    Args:
        panel: The controller.
        joints: The servos.
        clock: What segments are sent by and deadlines are measured with.
        device: Name of the device in messages.
        settings: Beat and patience.
        speeds_deg_s: Greatest speed of each joint.
        check: Called often; raises to end a motion.
        on_warning: Told when an arm cannot be told to stop.
    """

    def __init__(
        self,
        panel: ServoPanel,
        joints: ServoJoints,
        clock: Clock,
        device: str,
        settings: Ssc32Settings,
        speeds_deg_s: tuple[float, ...],
        *,
        check: Callable[[], None],
        on_warning: Callable[[str], None],
    ) -> None:
        self._panel = panel
        self._joints = joints
        self._clock = clock
        self._device = device
        self._settings = settings
        self._speeds_deg_s = speeds_deg_s
        self._check = check
        self._on_warning = on_warning

    def go(self, start: JointPositions, target: JointPositions, share: float) -> None:
        """Move all joints together, the slowest at a share of its full speed."""
        self._run([self._segment(start, target, share)], 0)

    def stream(self, start: JointPositions, stances: list[JointPositions]) -> None:
        """Move through many stances, each a short joint move."""
        segments, here = [], start
        for there in stances:
            segments.append(self._segment(here, there, 1.0))
            here = there
        self._run(segments, max(1, round(self._settings.watch_s / self._settings.segment_s)))

    def _segment(self, here: JointPositions, there: JointPositions, share: float) -> Segment:
        slowest_s = max(
            abs(b - a) / (speed * share)
            for a, b, speed in zip(here.values, there.values, self._speeds_deg_s, strict=True)
        )
        return self._joints.pulses(there), max(slowest_s, self._settings.segment_s)

    def _run(self, segments: list[Segment], every: int) -> None:
        """Send moves; after so many, or by time if 0, see that the servos have pulses."""
        for _, duration_s in segments:
            self._require_time(duration_s)
        due_s = self._clock.now_s()
        try:
            for number, (pulses_us, duration_s) in enumerate(segments, 1):
                self._check()
                self._joints.send(pulses_us, duration_s)
                now_s = self._clock.now_s()
                # Whoever is late starts a new beat: the servos waited where they were.
                due_s = max(due_s, now_s - self._settings.segment_s) + duration_s
                if not every:
                    self._watch(duration_s)
                elif number % every == 0:
                    self._joints.require_pulses(self._joints.told_on_the_way_us())
                self._clock.sleep(due_s - self._clock.now_s())
            self._await_end(segments[-1][0])
        except CellError:
            self._stop_after_failure()
            raise

    def _watch(self, duration_s: float) -> None:
        """Look at the pulses now and then for as long as a move lasts."""
        for _ in range(int(duration_s / self._settings.watch_s)):
            self._clock.sleep(self._settings.watch_s)
            self._check()
            self._joints.require_pulses(self._joints.told_on_the_way_us())

    def _await_end(self, pulses_us: tuple[int, ...]) -> None:
        deadline_s = self._clock.now_s() + self._settings.margin_s
        while self._panel.is_moving():
            self._check()
            if self._clock.now_s() >= deadline_s:
                raise DeviceTimeout(
                    self._device,
                    f"the move did not end within {self._settings.margin_s:g} s after its time",
                    hint="check that nobody else sends to the controller",
                )
            self._clock.sleep(self._settings.segment_s)
        self._clock.sleep(self._settings.settle_s)
        self._joints.require_at(pulses_us)

    def _stop_after_failure(self) -> None:
        """Stop without hiding the failure that led here."""
        try:
            self._joints.stop()
        except CellError as error:
            self._on_warning(f"{error}; the arm could not be told to stop")

    def _require_time(self, duration_s: float) -> None:
        if duration_s * 1000.0 > GREATEST_TIME_MS:
            raise DeviceError(
                self._device,
                f"the move would take {duration_s:.0f} s, longer than the controller can count",
                hint=f"allowed are {GREATEST_TIME_MS / 1000.0:.1f} s; set a higher speed",
            )
