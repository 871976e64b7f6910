"""What a calibration leaves behind: what was measured, how, what came out, how good it is.

A procedure returns a `Measurement`. Whoever ran it adds when, in which cell, with which
versions and built on which other calibrations: a `CalibrationRecord`. Its identity is the
digest of its content.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from datetime import datetime

from pydantic import BaseModel, ConfigDict, Field, JsonValue

from calibration.verdict import Finding, Grade, worst

FORMAT = 1


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Sample(_Part):
    """One thing that was measured."""

    label: str
    """Its name, such as `pair 3`."""
    given: tuple[float, ...] = ()
    """What was known of it, such as robot x, y in mm."""
    measured: tuple[float, ...] = ()
    """What was measured, such as picture u, v in px."""
    residual: tuple[float, ...] = ()
    """Measured less fitted, in the unit of the fit."""
    residual_mm: float | None = None
    """How far it lies from the fit at the playground."""
    held_out_mm: float | None = None
    """How far it lies from a fit that was made without it."""
    is_used: bool = True
    """Whether it was fitted on."""
    picture: str = ""
    """Digest of the picture it was found in; empty without one."""


class Parameter(_Part):
    """One fitted number."""

    name: str
    value: float
    unit: str = ""
    deviation: float | None = None
    """Its standard deviation; None where it is not known."""


class Correlation(_Part):
    """Two parameters that the samples hardly tell apart."""

    first: str
    second: str
    value: float


class Accuracy(_Part):
    """How good it is, in millimetres at the playground unless said."""

    fit_rms: float | None = None
    """Of the samples that were fitted on; says little where they are few."""
    held_out_rms: float | None = None
    """Of points that were not fitted on; None where there are none."""
    held_out_max: float | None = None
    held_out_count: int = 0
    how: str = ""
    """Which points those are, such as `leave-one-out` or `3 fresh points`."""
    predicted_rms: float | None = None
    """What the covariance predicts over the region; None where it is not known."""
    predicted_max: float | None = None
    """The same at the region's worst place, 95 %."""
    map_rms: float | None = None
    """Of the map itself at the playground: held out, less the scatter that the points have of
    themselves (in quadrature), but no less than predicted; None where that is not known."""
    map_upper: float | None = None
    """What it stays below with 95 %, as few points leave it open."""
    unit: str = "mm"

    @property
    def stated(self) -> float | None:
        """The figure for demands: the map's own, else held out, else predicted."""
        known = (self.map_rms, self.held_out_rms, self.predicted_rms)
        return next((figure for figure in known if figure is not None), None)

    @property
    def stated_how(self) -> str:
        """Where that figure comes from, in two words."""
        if self.map_rms is not None:
            return "the map's"
        return "held out" if self.held_out_rms is not None else "predicted"


class Region(_Part):
    """Where it holds."""

    text: str
    """In words."""
    outline_mm: tuple[tuple[float, float], ...] = ()
    """Corners in the robot frame; empty where it is no region of the table."""


class Support(_Part):
    """A value of the profile that others were fitted with, and mean nothing without.

    Where a camera stands is such a value of others: it was fitted with a lens, and with
    another lens the same place puts points elsewhere.
    """

    path: str
    """Dotted path in the profile, such as `cameras.top.lens`."""
    value: JsonValue
    """What was there."""
    record: str = ""
    """Identity of the calibration that it came from; empty where the cell's file has it."""


class Measurement(_Part):
    """What a procedure found."""

    kind: str
    """What was calibrated, such as `homography`."""
    subject: str
    """Of what, such as the camera `top`; `cell` where there is one only."""
    method: str
    """How, in a sentence."""
    samples: tuple[Sample, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    covariance: tuple[tuple[float, ...], ...] = ()
    """Of the parameters, in their order; empty where it is not known."""
    correlations: tuple[Correlation, ...] = ()
    """Above 0.8."""
    accuracy: Accuracy = Accuracy()
    region: Region = Region(text="")
    findings: tuple[Finding, ...] = ()
    values: dict[str, JsonValue] = Field(default_factory=dict)
    """What it sets in the profile: dotted path, value."""
    details: dict[str, JsonValue] = Field(default_factory=dict)
    """Whatever else belongs to this kind, for `show` and `check`."""
    based_on: tuple[str, ...] = ()
    """Identities of the calibrations that went into it."""
    stands_on: tuple[Support, ...] = ()
    """Values that its own were fitted with: they hold only as long as those are in force."""
    not_known: tuple[str, ...] = ()
    """What it cannot say, a sentence each."""

    @property
    def grade(self) -> Grade:
        """Its verdict."""
        return worst(self.findings)


class CalibrationRecord(Measurement):
    """A measurement with its provenance."""

    format: int = FORMAT
    cell: str
    """Name of the cell."""
    measured_at: datetime
    """When, with the time zone."""
    versions: dict[str, str]
    """Of this program and the libraries that fitted."""
    answers: dict[str, JsonValue] = Field(default_factory=dict)
    """What was answered to the procedure's questions."""
    cameras: dict[str, str] = Field(default_factory=dict)
    """GUIDs of the cameras that it was measured with, by name."""

    @property
    def identity(self) -> str:
        """Digest of the content, 64 hexadecimal digits."""
        return hashlib.sha256(self.canonical()).hexdigest()

    def canonical(self) -> bytes:
        """Return the content in one fixed form.

        Only what was given: a record that was kept before there was a field keeps its identity.
        """
        data = self.model_dump(mode="json", exclude_unset=True)
        return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def make_record(
    measurement: Measurement,
    *,
    cell: str,
    measured_at: datetime,
    versions: Mapping[str, str],
    answers: Mapping[str, JsonValue],
    cameras: Mapping[str, str] | None = None,
) -> CalibrationRecord:
    """Return a measurement with its provenance.

    Args:
        measurement: What a procedure found.
        cell: Name of the cell.
        measured_at: When, with the time zone.
        versions: Of this program and the libraries that fitted.
        answers: What was answered to the procedure's questions.
        cameras: GUIDs of the cameras that it was measured with, by name.

    Raises:
        ValueError: The time has no zone.
    """
    if measured_at.tzinfo is None:
        raise ValueError("the time of a calibration needs its time zone")
    content = {name: getattr(measurement, name) for name in Measurement.model_fields}
    record = CalibrationRecord(
        **content,
        cell=cell,
        measured_at=measured_at,
        versions=dict(versions),
        answers=dict(answers),
        cameras=dict(cameras or {}),
    )
    # What has its default is told as well: the default may be another one later.
    return CalibrationRecord.model_validate(record.model_dump())
