"""Whether a lens still is as it was measured, on fresh views of a board."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from calibration.catalogue import Site
from calibration.errors import CalibrationError, FitFailed
from calibration.lens.fit import BoardView, pose_of
from calibration.record import Accuracy, CalibrationRecord, Measurement, Sample
from calibration.verdict import Finding, Grade
from cell.profile import LensProfile
from cell.vision.boards import Board

_DEGRADED, _BAD = 2.0, 4.0
_LEAST_PX = 0.3


def checked(
    site: Site,
    record: CalibrationRecord,
    board: Board,
    views: Sequence[BoardView],
    findings: Sequence[Finding],
    size_px: tuple[int, int] | None,
) -> Measurement:
    """Return how far fresh views miss what a record's lens tells.

    Raises:
        CalibrationError: The record holds no lens.
    """
    found = grouped(findings)
    value = record.values.get(f"cameras.{record.subject}.lens")
    if value is None or size_px is None:
        raise CalibrationError(f"calibration {record.identity[:8]} holds no lens to check")
    lens = LensProfile.model_validate(value).model().resized(size_px[0])
    guid = site.profile.cameras[record.subject].guid
    if record.details.get("guid") != guid:
        found.append(wrong_camera(record, guid))
    samples, squares = [], []
    for view in views:
        try:
            _, miss = pose_of(board, view, lens)
        except FitFailed as error:
            found.append(Finding(code="undetermined", grade=Grade.DEGRADED, text=str(error)))
            continue
        off = float(np.sqrt((miss**2).sum(axis=1).mean()))
        squares.append(off**2)
        samples.append(Sample(label=view.label, measured=(float(len(view.ids)), off)))
    rms = float(np.sqrt(np.mean(squares))) if squares else None
    usual = max(record.accuracy.stated or _LEAST_PX, _LEAST_PX)
    if rms is None:
        found.append(Finding(code="too-few-views", grade=Grade.BAD, text="no view shows the board"))
    elif rms > _DEGRADED * usual:
        found.append(
            Finding(
                code="lens-changed",
                grade=Grade.BAD if rms > _BAD * usual else Grade.DEGRADED,
                text=f"fresh views miss by {rms:.2f} px, {usual:.2f} px when it was calibrated",
                hint="was the lens turned or exchanged? calibrate it again",
            )
        )
    return Measurement(
        kind=record.kind,
        subject=record.subject,
        method=f"the lens of {record.identity[:8]} held against {len(samples)} fresh views",
        samples=tuple(samples),
        accuracy=Accuracy(
            held_out_rms=rms,
            held_out_max=max((float(np.sqrt(s)) for s in squares), default=None),
            held_out_count=len(squares),
            how="fresh views",
            unit="px",
        ),
        findings=tuple(found),
        based_on=(record.identity,),
    )


def grouped(findings: Sequence[Finding]) -> list[Finding]:
    """Return findings with those of one code and grade told once."""
    kinds: dict[tuple[str, Grade], list[Finding]] = {}
    for finding in findings:
        kinds.setdefault((finding.code, finding.grade), []).append(finding)
    return [
        same[0] if len(same) == 1
        else same[0].model_copy(
            update={
                "text": f"{len(same)} times; the first: {same[0].text}",
                "samples": tuple(dict.fromkeys(label for one in same for label in one.samples)),
            }
        )
        for same in kinds.values()
    ]  # fmt: skip


def unchecked(site: Site, record: CalibrationRecord) -> Measurement:
    """Return that a lens cannot be checked as nobody holds a board into view."""
    guid = site.profile.cameras[record.subject].guid
    is_other = record.details.get("guid") != guid
    note = Finding(
        code="no-board",
        grade=Grade.OK,
        text="the lens cannot be checked without a board: whether it changed is not told",
        hint="hold the board into view, or take pictures of it, and answer has_board=yes",
    )
    return Measurement(
        kind=record.kind,
        subject=record.subject,
        method=f"the lens of {record.identity[:8]} was not looked at: no board",
        findings=(wrong_camera(record, guid),) if is_other else (note,),
        based_on=(record.identity,),
        not_known=("whether the lens changed: nobody held a board",),
    )


def wrong_camera(record: CalibrationRecord, guid: str) -> Finding:
    """Return the finding that a record was made with another camera body."""
    return Finding(
        code="wrong-camera",
        grade=Grade.BAD,
        text=f"it was measured with the camera {record.details.get('guid')}, the profile has "
        f"{guid} as {record.subject} now",
        hint="put the cameras back where they were, or calibrate again",
    )
