"""Calibrations as text and as JSON."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Final

from console.calibrating import age_of, now, stated_accuracy
from console.output import Style, put, put_json, put_table, styled

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from pydantic import JsonValue

    from calibration.diffing import Difference
    from calibration.record import CalibrationRecord, Measurement
    from calibration.verdict import Grade

_WIDEST_VALUE = 100
_SAMPLES: Final = {
    "eye-in-hand": "samples (given: joints in deg; measured: px, of lines deg)",
    "homography": "samples (given: robot x, y in mm; measured: px; residual: mm)",
    "lens": "samples (measured: corners, and px RMS left out; residual: px RMS)",
    "mount": "samples (given: mm and deg of the hand; measured: corners; residual: px RMS)",
    "recognition": "samples (given: px; measured: mean R, G, B, area in px, circularity)",
    "servo-maps": "samples (given: joints in deg; measured: mm and deg of the hand; residual: mm)",
    "store-place": "samples (given: mm on the sheet; measured: robot mm; residual: mm)",
    "world": "samples (given: column, row; measured: robot x, y in mm; residual: mm)",
}
"""What the figures of a kind's samples are."""


def grade_style(grade: Grade) -> Style:
    """Return the colour of a grade."""
    styles: dict[str, Style] = {"OK": "green", "DEGRADED": "yellow", "BAD": "red"}
    return styles[grade.value]


def put_record(record: CalibrationRecord, *, is_in_force: bool, as_json: bool) -> None:
    """Write what came out of a procedure, in short."""
    if as_json:
        put_json({**_head(record), "is_in_force": is_in_force, **_verdict(record)})
        return
    put(_title(record))
    put("\n".join(verdict_lines(record)))


def put_whole(record: CalibrationRecord, *, is_in_force: bool, as_json: bool) -> None:
    """Write everything that a record holds."""
    if as_json:
        put_json({**_head(record), "is_in_force": is_in_force, **record.model_dump(mode="json")})
        return
    put(_title(record))
    put("\n".join(_provenance(record, is_in_force=is_in_force)))
    put("\n".join(verdict_lines(record)))
    for heading, rows in _looks(record):
        put(styled(heading, "bold"))
        put_table(rows[0], rows[1:])
    for heading, lines in (
        (_SAMPLES.get(record.kind, "samples"), _samples(record)),
        ("parameters", _parameters(record)),
        ("hang together", [
            f"{c.first} and {c.second}: {c.value:+.2f}" for c in record.correlations
        ]),
        ("sets in the profile", [
            f"{path} = {_short(value)}" for path, value in record.values.items()
        ]),
        ("details", [f"{name} = {_short(value)}" for name, value in record.details.items()]),
        ("answers", [f"{name} = {_short(value)}" for name, value in record.answers.items()]),
    ):  # fmt: skip
        if lines:
            put(styled(heading, "bold"))
            put("\n".join(f"  {line}" for line in lines))


def _looks(record: CalibrationRecord) -> list[tuple[str, list[tuple[str, ...]]]]:
    """Return what was learned of blocks beside the reference's tables, with the margins."""
    if record.kind != "recognition":
        return []
    tables: list[tuple[str, list[tuple[str, ...]]]] = []
    colours, kinds = record.details.get("colours"), record.details.get("kinds")
    if isinstance(colours, dict):
        rows: list[tuple[str, ...]] = [("colour", "learned R, G, B", "seen", "reference")]
        for name, one in colours.items():
            if isinstance(one, dict):
                seen = [list(pair) for pair in zip(
                    _list(one, "seen_from"), _list(one, "seen_to"), strict=True
                )]  # fmt: skip
                rows.append((name, _figures(_list(one, "learned_rgb")),
                             _ranges(seen),
                             _ranges(_list(one, "reference"))))  # fmt: skip
        tables.append(("colours", rows))
    if isinstance(kinds, dict):
        rows = [("kind", "area (px)", "reference", "circularity", "reference")]
        for name, one in kinds.items():
            if isinstance(one, dict):
                figures = [_range(_list(one, key)) for key in (
                    "area_px", "reference_area_px", "circularity", "reference_circularity"
                )]  # fmt: skip
                rows.append((name, *figures))
        tables.append(("kinds", rows))
    margins = [m for m in _list(record.details, "margins") if isinstance(m, list) and len(m) == 3]
    if margins:
        head = ("colours", "margin (Bhattacharyya distance)")
        tables.append(("margins", [head, *((f"{a} and {b}", f"{m}") for a, b, m in margins)]))
    return tables


def _list(table: Mapping[str, JsonValue], key: str) -> list[JsonValue]:
    value = table.get(key)
    return value if isinstance(value, list) else []


def _figures(values: Sequence[JsonValue]) -> str:
    return ", ".join(f"{value:.0f}" for value in values if isinstance(value, int | float))


def _range(pair: Sequence[JsonValue]) -> str:
    figures = [
        f"{value:.0f}" if abs(value) >= 10 else f"{value:.3g}"
        for value in pair
        if isinstance(value, int | float)
    ]
    return " to ".join(figures) or "-"


def _ranges(pairs: Sequence[JsonValue] | Sequence[list[JsonValue]]) -> str:
    return ", ".join(_range(pair) for pair in pairs if isinstance(pair, list)) or "-"


def put_difference(
    first: CalibrationRecord, second: CalibrationRecord, found: Difference, *, as_json: bool
) -> None:
    """Write what differs between two records."""
    if as_json:
        put_json(_difference_json(first, second, found))
        return
    put(f"{_title(first)}\n{_title(second)}")
    if not (found.values or any(p.first != p.second for p in found.parameters)):
        put("they set the same values")
    for path, (one, other) in found.values.items():
        put(f"{path}\n  - {_short(one)}\n  + {_short(other)}")
    for camera, corners in found.corners.items():
        put(styled(f"camera {camera} at the playground's corners, block tops", "bold"))
        for corner in corners:
            x, y = corner.corner_mm
            put(
                f"  ({x:4.0f}, {y:4.0f}) mm  {corner.shift_mm[0]:+8.3f} {corner.shift_mm[1]:+8.3f}"
                f"  = {corner.distance_mm:.3f} mm"
            )
    if found.parameters:
        put(styled("parameters", "bold"))
    for shift in found.parameters:
        sigmas = "" if shift.sigmas is None else f"  {shift.sigmas:.1f} sigma"
        unit = f" {shift.unit}" if shift.unit else ""
        put(f"  {shift.name}: {shift.first:.6g} -> {shift.second:.6g}{unit}{sigmas}")


def verdict_lines(measured: Measurement) -> list[str]:
    """Return grade, figures, findings and what is not known, a line each."""
    accuracy = measured.accuracy
    # A share, such as `% wrong`, is no root mean square.
    unit = accuracy.unit if accuracy.unit.startswith("%") else f"{accuracy.unit} RMS"
    lines = [styled(f"{measured.grade}", grade_style(measured.grade)) + f"  {measured.method}"]
    if accuracy.held_out_rms is not None:
        worst = "" if accuracy.held_out_max is None else f", {accuracy.held_out_max:.3g} at most"
        how = f" ({accuracy.held_out_count} points: {accuracy.how})" if accuracy.how else ""
        lines.append(f"  held out   {accuracy.held_out_rms:.3g} {unit}{worst}{how}")
    if accuracy.predicted_rms is not None:
        worst = (
            ""
            if accuracy.predicted_max is None
            else f", {accuracy.predicted_max:.3g} at the worst place, taken by itself (95 %)"
        )
        lines.append(f"  predicted  {accuracy.predicted_rms:.3g} {unit}{worst}")
    if accuracy.map_rms is not None:
        upper = "" if accuracy.map_upper is None else f", below {accuracy.map_upper:.3g} with 95 %"
        lines.append(f"  the map's  {accuracy.map_rms:.3g} {unit} without scatter{upper}")
    if accuracy.fit_rms is not None:
        lines.append(f"  fitted on  {accuracy.fit_rms:.3g} {unit}, which says little alone")
    if accuracy.stated is None:
        lines.append("  accuracy   not known")
    if measured.region.text:
        lines.append(f"  holds      {measured.region.text}")
    for finding in measured.findings:
        mark = styled(finding.grade.value, grade_style(finding.grade))
        lines.append(f"  {mark} {finding.code}: {finding.text}")
        if finding.hint:
            lines.append(f"    to do: {finding.hint}")
    lines += [f"  not known: {sentence}" for sentence in measured.not_known]
    return lines


def _title(record: CalibrationRecord) -> str:
    name = styled(f"{record.kind} of {record.subject}", "bold", sys.stdout)
    return f"{name}  {record.identity[:12]}"


def _provenance(record: CalibrationRecord, *, is_in_force: bool) -> list[str]:
    state = "in force" if is_in_force else "not in force"
    versions = ", ".join(f"{name} {version}" for name, version in record.versions.items())
    lines = [
        f"  {state}, cell {record.cell}, measured {record.measured_at:%Y-%m-%d %H:%M:%S %Z}"
        f" ({age_of(record, now())})",
        f"  identity   {record.identity}",
        f"  made with  {versions}",
    ]
    if record.cameras:
        cameras = ", ".join(f"{name} {guid}" for name, guid in record.cameras.items())
        lines.append(f"  cameras    {cameras}")
    if record.based_on:
        lines.append(f"  based on   {', '.join(identity[:12] for identity in record.based_on)}")
    for support in record.stands_on:
        source = support.record[:12] or "the cell's file"
        lines.append(f"  holds with {support.path} of {source}")
    return lines


def _samples(record: CalibrationRecord) -> list[str]:
    lines = []
    for sample in record.samples:
        parts = [sample.label]
        if sample.given:
            parts.append(f"given {_numbers(sample.given)}")
        if sample.measured:
            parts.append(f"measured {_numbers(sample.measured)}")
        if sample.residual:
            parts.append(f"residual {_numbers(sample.residual)}")
        if sample.residual_mm is not None:
            parts.append(f"{sample.residual_mm:.3g} mm")
        if sample.held_out_mm is not None:
            parts.append(f"held out {sample.held_out_mm:.3g} mm")
        if not sample.is_used:
            parts.append("not fitted on")
        lines.append("  ".join(parts))
    return lines


def _parameters(record: CalibrationRecord) -> list[str]:
    lines = []
    for p in record.parameters:
        # People read angles in degrees.
        factor, unit = (math.degrees(1.0), "deg") if p.unit == "rad" else (1.0, p.unit)
        deviation = "" if p.deviation is None else f" ± {p.deviation * factor:.2g}"
        lines.append(f"{p.name} = {p.value * factor:.6g}{deviation}" + (f" {unit}" if unit else ""))
    return lines


def _numbers(values: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{value:.2f}" for value in values) + ")"


def _short(value: object) -> str:
    text = str(_rounded(value))
    return text if len(text) <= _WIDEST_VALUE else text[: _WIDEST_VALUE - 1] + "…"


def _rounded(value: object) -> object:
    """Return a value with its figures to six digits."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, list | tuple):
        return [_rounded(one) for one in value]
    if isinstance(value, dict):
        return {name: _rounded(one) for name, one in value.items()}
    return value


def _head(record: CalibrationRecord) -> dict[str, object]:
    return {
        "identity": record.identity,
        "kind": record.kind,
        "subject": record.subject,
        "grade": record.grade.value,
        "stated": stated_accuracy(record),
    }


def _verdict(record: CalibrationRecord) -> dict[str, object]:
    data = record.model_dump(mode="json")
    return {
        name: data[name]
        for name in ("cell", "measured_at", "method", "accuracy", "region", "findings", "values",
                     "not_known", "based_on", "stands_on")
    }  # fmt: skip


def _difference_json(
    first: CalibrationRecord, second: CalibrationRecord, found: Difference
) -> dict[str, object]:
    return {
        "first": _head(first),
        "second": _head(second),
        "values": {path: list(pair) for path, pair in found.values.items()},
        "parameters": [
            {"name": p.name, "unit": p.unit, "first": p.first, "second": p.second,
             "sigmas": p.sigmas}
            for p in found.parameters
        ],
        "corners": {
            camera: [
                {"corner_mm": c.corner_mm, "shift_mm": c.shift_mm, "distance_mm": c.distance_mm}
                for c in corners
            ]
            for camera, corners in found.corners.items()
        },
    }  # fmt: skip
