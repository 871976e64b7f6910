"""What goes wrong and is put right, told twice: to the event bus and to the operator's log."""

from __future__ import annotations

import logging

from cell.events import (
    ArmHeld,
    Body,
    DeviceFailed,
    DeviceRecovered,
    DeviceSkipped,
    EventBus,
    RequestRepeated,
    ResumeChecked,
)

_log = logging.getLogger("cell.faults")


class FaultReporter:
    """One event and one line of the log for each thing that happens."""

    def __init__(self, events: EventBus) -> None:
        self._events = events

    def repeated(self, device: str, problem: str) -> None:
        """Tell that a request was sent again."""
        self._tell(RequestRepeated(device, problem), f"{device}: asked again: {problem}")

    def recovered(self, device: str, how: str) -> None:
        """Tell that a device that had failed is in service again."""
        self._tell(DeviceRecovered(device, how), f"{device}: recovered: {how}")

    def held(self, reason: str) -> None:
        """Tell that the arm stands still until a check."""
        self._tell(ArmHeld(reason), f"held: {reason}")

    def not_stopped(self, problem: str) -> None:
        """Tell that the arm could not be told to stop, and so may still be moving."""
        self._tell(
            DeviceFailed("arm", f"could not be stopped: {problem}"),
            "arm: could not be told to stop, it may still be on its way; use the emergency stop "
            f"if it must not be: {problem}",
        )

    def checked(self, *, is_clear: bool, detail: str, is_routine: bool = False) -> None:
        """Tell what the check before going on has found.

        Args:
            is_clear: Whether something may move.
            detail: What was found.
            is_routine: Whether nothing had happened: the cell was only opened.
        """
        verdict = "clear" if is_clear else "not clear"
        level = logging.INFO if is_routine else logging.WARNING
        line = f"resume check: {verdict}: {detail}"
        self._tell(ResumeChecked(is_clear, detail), line, level)

    def skipped(self, device: str, what: str) -> None:
        """Tell what is left out, or left to people, because a device is disabled."""
        self._tell(DeviceSkipped(device, what), f"{device}: skipped: {what}")

    def _tell(self, body: Body, line: str, level: int = logging.WARNING) -> None:
        self._events.emit(body)
        _log.log(level, "%s", line)
