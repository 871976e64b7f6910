"""The check for drift that the watchdog makes between sessions, without questions.

A calibration by the screen knows where its cameras saw the dots. For other calibrations, and
for values typed into the profile, the first check notes where they are, and later ones tell
what moved since then.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

import numpy as np

from calibration.checks import (
    Baseline,
    CameraChecked,
    Checks,
    Kept,
    LastCheck,
    knowledge_of,
)
from calibration.drift import check
from calibration.drift.check import Blind, DotReference, Pixels
from calibration.drift.dots import dots
from calibration.drift.motion import Motion
from calibration.drift.plane_camera import camera_like
from calibration.errors import ArchiveError
from calibration.record import CalibrationRecord
from cell.errors import CellError, StateError, Stopped
from cell.geometry import PlaneView
from cell.profile import Profile
from cell.watchdog import CalibrationWord, Sight

_LEAST_SEEN: Final = 0.5
"""Share of the dots in view that a first check has to see to be compared with later."""

_HINT: Final = "fasten what is loose, and calibrate again: `cell calibrate screen`"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Shots:
    lit: Pixels
    dark: Pixels


class DriftCheck:
    """A `cell.watchdog.CalibrationCheck` by dots on the screen.

    Args:
        profile: The cell's profile, with the calibrations in force.
        records: The calibrations in force.
        checks: Where checks are kept.
        now: Tells the date, with its zone.
    """

    def __init__(
        self,
        profile: Profile,
        records: Sequence[CalibrationRecord],
        checks: Checks,
        now: Callable[[], datetime],
    ) -> None:
        self._profile = profile
        self._record = next((r for r in reversed(records) if r.kind == "screen"), None)
        self._checks = checks
        self._now = now
        self._knowledge = {
            name: knowledge_of(profile, name)
            for name, camera in profile.cameras.items()
            if camera.stands_still and camera.view(0.0) is not None
        }

    def is_due(self) -> bool:
        """Return whether any camera that stands still is known to look somewhere."""
        return bool(self._knowledge)

    def look(self, sight: Sight) -> CalibrationWord:
        """Show the dots, look with every camera, keep and tell what was seen.

        Raises:
            CellError: The screen fails, the cell is needed, or the check cannot be kept.
        """
        before = self._read()
        baselines = {
            name: baseline
            for name, baseline in before.baselines.items()
            if self._knowledge.get(name) == baseline.knowledge
        }
        rows = {name: baseline.rows for name, baseline in baselines.items()}
        known, _ = check.references(self._profile, self._record, rows)
        was = {one.camera: one for one in known}
        fresh = {name: self._first(name) for name in self._knowledge if name not in was}
        shots, failed = self._shots(sight)
        seen: list[Motion | Blind] = list(failed)
        for name, shot in shots.items():
            if name in was:
                told = check.motion_seen(was[name], shot.lit, shot.dark, self._profile)
                seen.append(told)
                holds = isinstance(told, Motion) and not check.has_moved(told)
                if holds and not was[name].is_measured:
                    self._note(baselines, was[name], shot)
            else:
                seen.append(self._begun(name, fresh[name], shot, baselines))
        last = LastCheck(at=self._now(), cameras={one.camera: self._checked(one) for one in seen})
        self._keep(Kept(last=last, baselines=baselines))
        return self._word(seen)

    def _shots(self, sight: Sight) -> tuple[Mapping[str, _Shots], list[Blind]]:
        """Return both pictures of each camera, and which cameras gave none."""
        panel = check.panel_of(self._profile, self._record)
        failed: dict[str, Blind] = {}

        def look(pixels: Pixels, name: str) -> dict[str, Pixels]:
            sight.show_pixels(pixels, name)
            found = {}
            for camera in self._knowledge:
                if camera in failed:
                    continue
                try:
                    found[camera] = sight.grab(camera).pixels
                except Stopped:
                    raise
                except CellError as error:
                    failed[camera] = Blind(camera=camera, reason=f"it gives no picture: {error}")
            return found

        lit = look(dots(panel), "drift dots")
        dark = look(panel.field(0), "drift black")
        shots = {name: _Shots(lit=lit[name], dark=dark[name]) for name in dark}
        return shots, list(failed.values())

    def _first(self, name: str) -> DotReference | None:
        """Return where a camera of which only a plane map is known should see the dots."""
        top_mm = self._profile.block_top_mm
        view = self._profile.cameras[name].view(top_mm)
        like = camera_like(view, top_mm) if isinstance(view, PlaneView) else None
        return None if like is None else check.dot_reference(name, like, self._profile, None)

    def _begun(
        self, name: str, first: DotReference | None, shot: _Shots, baselines: dict[str, Baseline]
    ) -> Blind:
        """Note where a camera sees the dots for the first time."""
        if first is None:
            return Blind(camera=name, reason="no camera over the table sees what its map says")
        if self._note(baselines, first, shot):
            reason = "it was looked at for the first time; from now on motions are noticed"
            return Blind(camera=name, reason=reason)
        return Blind(camera=name, reason="too few of the dots are seen to be compared with later")

    def _note(self, baselines: dict[str, Baseline], was: DotReference, shot: _Shots) -> bool:
        """Keep where a camera sees the dots, if it sees enough; return whether it does."""
        seen = check.measured_reference(was.camera, was.view, shot.lit, shot.dark, self._profile)
        in_view = int(was.known().sum())
        if int(np.sum(seen.known())) < _LEAST_SEEN * in_view:
            return False
        baselines[was.camera] = Baseline(
            at=self._now(), knowledge=self._knowledge[was.camera], rows=seen.rows()
        )
        return True

    def _checked(self, seen: Motion | Blind) -> CameraChecked:
        knowledge = self._knowledge[seen.camera]
        if isinstance(seen, Blind):
            return CameraChecked(grade=None, text=seen.reason, knowledge=knowledge)
        grade = check.grade_of(seen, self._stated_mm(seen.camera))
        return CameraChecked(
            grade=grade,
            text=_text(seen),
            hint=_HINT if check.has_moved(seen) else "",
            knowledge=knowledge,
        )

    def _word(self, seen: Sequence[Motion | Blind]) -> CalibrationWord:
        motions = [one for one in seen if isinstance(one, Motion)]
        blind = [one for one in seen if isinstance(one, Blind)]
        if any(check.has_moved(one) for one in motions):
            moved = check.judge(motions)[0]
            return CalibrationWord(verdict="moved", text=moved.text, hint=_HINT)
        holding = [_text(one) for one in motions]
        unknown = [f"camera {one.camera} cannot tell: {one.reason}" for one in blind]
        return CalibrationWord(
            verdict="cannot tell" if blind else "holds", text="; ".join(holding + unknown)
        )

    def _stated_mm(self, camera: str) -> float | None:
        record = self._record
        if record is None or f"cameras.{camera}.place" not in record.values:
            return None
        return record.accuracy.stated

    def _read(self) -> Kept:
        try:
            return self._checks.read()
        except ArchiveError as error:
            raise StateError(str(error)) from error

    def _keep(self, kept: Kept) -> None:
        try:
            self._checks.keep(kept)
        except ArchiveError as error:
            raise StateError(str(error)) from error


def _text(motion: Motion) -> str:
    return (
        f"what camera {motion.camera} tells of the playground is {motion.rms_mm:.2f} ± "
        f"{motion.deviation_mm:.2f} mm off ({motion.dots} dots)"
    )
