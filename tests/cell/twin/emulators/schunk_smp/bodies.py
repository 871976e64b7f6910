"""Fingers without a world around them."""

from cell.twin.bodies import FingerMotion
from cell.twin.emulators.schunk_smp.motion import trapezoid_s


class BareFingers:
    """A `FingerBody` with at most one thing between the fingers, `width_mm` wide."""

    def __init__(self, opening_mm: float = 40.0) -> None:
        self.has_power = True
        self.width_mm: float | None = None
        self.halts: list[float] = []
        self._opening_mm = opening_mm
        self._begun: tuple[float, float, FingerMotion] | None = None

    def is_powered(self) -> bool:
        return self.has_power

    def opening_mm(self, now_s: float) -> float:
        if self._begun is None:
            return self._opening_mm
        start_s, start_mm, motion = self._begun
        if now_s >= motion.end_s:
            return motion.end_mm
        share = (now_s - start_s) / (motion.end_s - start_s)
        return start_mm + (motion.end_mm - start_mm) * share

    def begin(
        self, target_mm: float, speed_mm_s: float, acceleration_mm_s2: float, now_s: float
    ) -> FingerMotion:
        start_mm = self.opening_mm(now_s)
        is_blocked = self.width_mm is not None and target_mm < self.width_mm <= start_mm
        end_mm = self.width_mm if is_blocked and self.width_mm is not None else target_mm
        duration_s = trapezoid_s(end_mm - start_mm, speed_mm_s, acceleration_mm_s2)
        motion = FingerMotion(end_s=now_s + duration_s, end_mm=end_mm, is_blocked=is_blocked)
        self._begun = (now_s, start_mm, motion)
        return motion

    def halt(self, now_s: float) -> None:
        self.halts.append(now_s)
        self._opening_mm = self.opening_mm(now_s)
        self._begun = None
