"""Records for tests."""

from __future__ import annotations

from datetime import UTC, datetime

from pydantic import JsonValue

from calibration.record import Accuracy, CalibrationRecord, Measurement, Sample, make_record
from calibration.verdict import Finding, Grade

WHEN = datetime(2026, 11, 10, 9, 30, tzinfo=UTC)
MAP: JsonValue = [[0.00656, 0.58748, 222.028], [0.58116, -0.00504, -375.536], [0.0, 1e-5, 1.0]]


def a_record(
    *,
    kind: str = "homography",
    subject: str = "top",
    held_out_mm: float | None = 0.7,
    unit: str = "mm",
    values: dict[str, JsonValue] | None = None,
    grade: Grade = Grade.OK,
    picture: str = "",
    measured_at: datetime = WHEN,
    cell: str = "mash",
    cameras: dict[str, str] | None = None,
) -> CalibrationRecord:
    found = () if grade is Grade.OK else (Finding(code="x", grade=grade, text="something"),)
    measured = Measurement(
        kind=kind,
        subject=subject,
        method="for a test",
        samples=(Sample(label="one", given=(1.0, 2.0), measured=(3.0, 4.0), picture=picture),),
        accuracy=Accuracy(held_out_rms=held_out_mm, held_out_count=4, unit=unit),
        findings=found,
        values={"cameras.top.plane_map": MAP} if values is None else values,
    )
    return make_record(
        measured,
        cell=cell,
        measured_at=measured_at,
        versions={"robocell": "1"},
        answers={},
        cameras=cameras,
    )
