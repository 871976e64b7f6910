"""The controller's grip on the arm's mechanics: start, brake, halt, look."""

from __future__ import annotations

from collections.abc import Callable

from cell.twin.bodies import ArmBody, JointTuple
from cell.twin.emulators.melfa_r3.paths import PlannedPath
from cell.twin.emulators.melfa_r3.planner import Planner
from cell.twin.emulators.melfa_r3.stand import Stand


class Mechanism:
    """Knows the path under way and where the arm stands.

    Args:
        body: The arm's mechanics in the twin.
        planner: Makes stands of joint angles.
        is_barred: Whether something keeps the arm from moving: a motion is over at once.
    """

    def __init__(
        self, body: ArmBody, planner: Planner, is_barred: Callable[[], bool] = lambda: False
    ) -> None:
        self._is_barred = is_barred
        self._body = body
        self._planner = planner
        self._path: PlannedPath | None = None
        self._stand: Stand | None = None

    def stand(self, now_s: float) -> Stand:
        """Return where the arm stands."""
        joints_deg = self._body.joints_deg(now_s)
        stand = self._stand
        if stand is None or stand.joints_deg != joints_deg:
            stand = self._stand = self._planner.stand(joints_deg)
        return stand

    def is_moving(self, now_s: float) -> bool:
        """Return whether a motion is under way."""
        path = self._path
        return path is not None and now_s < path.end_s and self._body.is_moving(now_s)

    def speed_mm_s(self, now_s: float) -> float:
        """Return the tool point's speed on a straight move."""
        path = self._path
        if path is None or not self._body.is_moving(now_s):
            return 0.0
        return path.speed_mm_s(now_s)

    def follow(self, path: PlannedPath, end: Stand) -> None:
        """Start a motion that ends at a stand; an arm that is barred stays where it is."""
        if self._is_barred():
            return
        self._path = path
        self._stand = end
        self._body.follow(path)

    def brake(self, now_s: float) -> None:
        """Slow down to rest on the path under way."""
        path = self._path
        if path is not None and self.is_moving(now_s):
            self._path = path.braked(now_s)
            self._body.follow(self._path)

    def halt(self, now_s: float) -> None:
        """Stand still at once: the brakes fall in."""
        if self.is_moving(now_s):
            self._body.halt(now_s)
        self._path = None

    def joints_deg(self, now_s: float) -> JointTuple:
        """Return the joint angles."""
        return self._body.joints_deg(now_s)

    def switch_output(self, bit: int, now_s: float, *, is_on: bool) -> None:
        """Switch what hangs on an output."""
        self._body.set_output(bit, is_on=is_on, now_s=now_s)
