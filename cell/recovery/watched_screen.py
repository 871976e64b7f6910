"""The picture on the television kept in service: sent once more when it was painted late."""

from __future__ import annotations

from cell.devices.display import Screen
from cell.errors import DeviceTimeout
from cell.reporting import FaultReporter


class ScreenKeeper:
    """Shows pictures, and sends one again that was not painted in time.

    Whatever else is wrong with a page (none is connected, it is hidden, it has a wrong size)
    only a person can mend.

    Args:
        screen: The screen.
        reporter: Told when a picture had to be sent again.
    """

    def __init__(self, screen: Screen, reporter: FaultReporter) -> None:
        self._screen = screen
        self._reporter = reporter

    def show(self, picture: str) -> None:
        """Show a picture; it is on when this returns.

        Raises:
            DeviceError: There is no such picture, or it cannot be shown.
        """
        try:
            self._screen.show(picture)
            return
        except DeviceTimeout as error:
            late = error
        self._screen.show(picture)
        self._reporter.recovered("screen", f"shown again after: {late.problem}")

    def shown(self) -> str:
        """Return the name of the picture that was shown last."""
        return self._screen.shown()
