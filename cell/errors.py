"""The errors of `cell`: one tree, each carrying the data its message is made of.

CellError
├── ProfileError        the profile is wrong
├── LinkError           bytes do not travel
├── DeviceError         a device refused, failed or did not answer
│   ├── DeviceTimeout   it did not answer in time
│   ├── OutOfRange      it has no such value; nothing was sent
│   ├── DeviceRestarted it has forgotten its session: it was off in between
│   └── MotionInterrupted a motion ended early without an alarm
├── MotionRefused       the guard turned a motion down
├── UnreachablePose     no joint angles give the pose
├── GripFailed          the fingers closed and hold nothing
├── StoreError          the store has no such slot or block
├── LedgerError         the ledger cannot be read or written
├── VisionError         a picture cannot be read as expected
├── Stopped             somebody asked the operation to stop
├── ResumeRefused       after a stop, the check says that nothing may move yet
├── SafeStop            a fault after which the task is over and nothing moves
├── StateError          what is kept of a cell between programs cannot be read or written
└── StillHeld           another process has the cell
"""

from __future__ import annotations


class CellError(Exception):
    """Base of every error raised by `cell`; its text is fit for a technician."""


class ProfileError(CellError):
    """The profile cannot be used; the text says which field and what is allowed."""


class LinkError(CellError):
    """Bytes cannot be sent or received over a link."""


class DeviceError(CellError):
    """A device refused a request, reported a fault or answered nonsense.

    Attributes:
        device: Name of the device in the profile, such as `arm`.
        problem: What happened, without the device's name.
        code: The device's own error number, or None.
        hint: What to do about it, or an empty string.
    """

    def __init__(
        self, device: str, problem: str, *, code: int | None = None, hint: str = ""
    ) -> None:
        self.device = device
        self.problem = problem
        self.code = code
        self.hint = hint
        number = "" if code is None else f" (error {code})"
        advice = f"; {hint}" if hint else ""
        super().__init__(f"{device}: {problem}{number}{advice}")


class DeviceTimeout(DeviceError):
    """A device did not answer or did not finish in time."""


class OutOfRange(DeviceError):
    """A value was asked for that the device cannot take; nothing was sent to it."""


class DeviceRestarted(DeviceError):
    """A device has forgotten its session: it was switched off and on in between."""


class MotionInterrupted(DeviceError):
    """A motion ended before its target without an alarm: somebody pressed a stop."""


class UnreachablePose(CellError):
    """No joint angles within the limits bring the arm to the pose.

    Attributes:
        what: The joint that is in the way, such as `J5`, or `reach`.
        value: The value the pose asks for.
        limit: The limit it violates.
        unit: Unit of the two figures, `deg` or `mm`.
    """

    def __init__(
        self,
        problem: str,
        *,
        what: str = "",
        value: float = 0.0,
        limit: float = 0.0,
        unit: str = "",
    ) -> None:
        self.what = what
        self.value = value
        self.limit = limit
        self.unit = unit
        super().__init__(problem)


def _figure(value: float) -> str:
    """Return a figure with one decimal, or one with many digits in short."""
    return f"{value:.1f}" if abs(value) < 1e7 else f"{value:g}"


class MotionRefused(CellError):
    """The guard turned a motion down; nothing was sent to the arm.

    Attributes:
        what: The joint, plane, box or figure that is violated, such as `J5`.
        value: The value asked for.
        limit: The limit it violates.
        nearest: The nearest allowed value.
        unit: Unit of the three figures, such as `deg` or `mm`.
        nearest_point_mm: Where the tool point may still go on its way to the target,
            None where the path does not matter (a speed).
    """

    def __init__(
        self,
        what: str,
        *,
        value: float,
        limit: float,
        nearest: float,
        unit: str,
        why: str,
        nearest_point_mm: tuple[float, float, float] | None = None,
    ) -> None:
        self.what = what
        self.value = value
        self.limit = limit
        self.nearest = nearest
        self.unit = unit
        self.nearest_point_mm = nearest_point_mm
        way = (
            ""
            if nearest_point_mm is None
            else "; the way is free up to ({:.1f}, {:.1f}, {:.1f}) mm".format(*nearest_point_mm)
        )
        super().__init__(
            f"{what} {why}: {_figure(value)} {unit} asked, limit {limit:.1f} {unit}, "
            f"nearest allowed {nearest:.1f} {unit}{way}"
        )


class GripFailed(CellError):
    """The fingers closed and hold nothing, or not what was expected."""


class StoreError(CellError):
    """The store has no such slot, or no block of that kind and colour left."""


class LedgerError(CellError):
    """The ledger of blocks cannot be read or written."""


class VisionError(CellError):
    """A picture cannot be read as expected."""


class Stopped(CellError):
    """The operation ended early because somebody asked it to."""


class ResumeRefused(CellError):
    """Nothing may move yet after a stop; the text says what is wrong and what to do."""


class SafeStop(CellError):
    """A fault after which the arm stands still and the task is over.

    Attributes:
        cause: The fault itself.
    """

    def __init__(self, cause: CellError) -> None:
        self.cause = cause
        super().__init__(str(cause))


class StateError(CellError):
    """The state folder, or a file in it, cannot be read or written."""


class StillHeld(CellError):
    """Another process has this cell."""
