"""Watches over work with any device: when the device fails, the arm is held."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from cell.errors import DeviceError, LedgerError, LinkError
from cell.motion.guarded import GuardedArm
from cell.recovery.faults import DeviceName


class FaultWatch:
    """Holds an arm as soon as what is done under watch fails.

    Args:
        arm: The arm that is held.
    """

    def __init__(self, arm: GuardedArm) -> None:
        self._arm = arm

    @contextmanager
    def over(self, device: DeviceName) -> Iterator[None]:
        """Hold the arm when a device fails, or the ledger cannot be written.

        A fault that already holds the arm is passed on as it is.
        """
        try:
            yield
        except LedgerError as error:
            raise self._arm.fail("ledger", error) from error
        except (DeviceError, LinkError) as error:
            if self._arm.is_held:
                raise
            raise self._arm.fail(device, error) from error
