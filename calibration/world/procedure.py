"""World calibration: the lattice's angle, step and origin; touched, seen or typed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibration.catalogue import Site
from calibration.errors import AnswerRefused, CalibrationError, FitFailed
from calibration.homography.knowledge import fixed_cameras, knowledge_of, playground_profile
from calibration.procedure import (
    Procedure,
    Steps,
    ask_choice,
    ask_done,
    ask_number,
    ask_numbers,
    ask_whole,
    ask_within,
    ask_yes,
    capture,
    point_at,
    read_tool,
)
from calibration.record import (
    Accuracy,
    CalibrationRecord,
    Correlation,
    Measurement,
    Parameter,
    Region,
    Sample,
)
from calibration.statistics import strong_correlations
from calibration.verdict import Finding, Grade, worst
from calibration.world.fit import NAMES, UNITS, LatticeFit, fit_lattice, mapped
from calibration.world.judging import judge_world
from cell.geometry import LatticeMap
from cell.profile import Profile

Points = NDArray[np.float64]

KIND = "world"
_CELLS = ((0.0, 0.0), (11.0, 0.0), (11.0, 11.0), (0.0, 11.0))
_USUAL_MM = 5.0
_MOST_POINTS = 50
_LARGEST_WORLD = 1000
_STEPS_MM = (1.0, 200.0)
"""Below, the step is finer than blocks are laid; above, the playground holds no second one."""


def calibrate_world(site: Site) -> Procedure:
    """Calibrate where the lattice lies in the robot frame."""
    profile = playground_profile(site)
    way = yield from ask_choice(
        "way",
        "Are lattice points touched with the tool, seen by a camera, or is the lattice typed?",
        ("touched", "seen", "typed"),
        default="touched",
    )
    columns, rows = yield from _world_size()
    cameras = fixed_cameras(profile)
    camera = cameras[0] if cameras else ""
    if way == "typed":
        lattice = yield from _typed(profile)
        implausible = _implausible_step(lattice.step_mm)
        findings = implausible or judge_world(profile, lattice, columns, rows, camera)
        return _measurement(lattice, None, (), (), findings, "typed by a person")
    is_fixed = yield from ask_yes("fixed_step", "Is the step known?", default=True)
    step_mm = None
    if is_fixed:
        step_mm = yield from ask_number(
            "step", "How large is a step?", unit="mm", default=profile.lattice.step_mm
        )
    if way == "touched":
        cells, points = yield from _touched()
    else:
        camera = yield from ask_choice("camera", "Which camera?", cameras, default=camera)
        cells, points = yield from _seen(site, camera)
    return judged(profile, cells, points, step_mm, size=(columns, rows), camera=camera, way=way)


def judged(
    profile: Profile,
    cells: Points,
    points_mm: Points,
    step_mm: float | None,
    *,
    size: tuple[int, int],
    camera: str,
    way: str,
) -> Measurement:
    """Return the calibration that lattice points with their robot places give."""
    if step_mm is not None and (implausible := _implausible_step(step_mm)):
        return _measurement(None, None, cells, points_mm, implausible, way)
    try:
        fit = fit_lattice(cells, points_mm, step_mm=step_mm)
    except FitFailed as error:
        reason = Finding(code="undetermined", grade=Grade.BAD, text=str(error))
        named = _misorder(cells, points_mm) or (reason,)
        return _measurement(None, None, cells, points_mm, named, way)
    findings = [*_mistakes(cells, points_mm, fit, profile.lattice.step_mm)]
    findings += judge_world(profile, fit.lattice, *size, camera)
    return _measurement(fit.lattice, fit, cells, points_mm, findings, way, step_mm)


def _world_size() -> Steps[tuple[int, int]]:
    columns, rows = yield from ask_numbers(
        "world", "How many lattice points across and up has the largest world?", count=2,
        default=(12.0, 12.0),
    )  # fmt: skip
    for number in (columns, rows):
        if not number.is_integer() or not 1 <= number <= _LARGEST_WORLD:
            raise AnswerRefused(
                "world", f"whole numbers from 1 to {_LARGEST_WORLD} are expected, not {number:g}"
            )
    return int(columns), int(rows)


def _implausible_step(step_mm: float) -> tuple[Finding, ...]:
    least, most = _STEPS_MM
    if least <= step_mm <= most:
        return ()
    return (
        _bad("implausible-step", f"a step of {step_mm:g} mm is none that blocks can be set by: "
             f"{least:g} to {most:g} mm are", "give the step in millimetres"),
    )  # fmt: skip


def _mistakes(
    cells: Points, points_mm: Points, fit: LatticeFit, usual_step_mm: float
) -> tuple[Finding, ...]:
    """Name points that do not fit, an exchange of two, the other way of counting, other units."""
    miss = np.hypot(*fit.residuals_mm.T)
    if float(miss.max()) <= _USUAL_MM:
        ratio = fit.lattice.step_mm / usual_step_mm
        if abs(ratio - 1.0) > 0.2:
            is_cm = abs(ratio * 10.0 - 1.0) < 0.2
            return (
                Finding(
                    code="cm-for-mm" if is_cm else "implausible-step",
                    grade=Grade.BAD if is_cm else Grade.DEGRADED,
                    text=f"the points are {fit.lattice.step_mm:.2f} mm a step apart, "
                    f"{usual_step_mm:g} mm is usual",
                    hint="give robot points in millimetres, and check the lattice points",
                ),
            )
        return ()
    named = _misorder(cells, points_mm)
    if named:
        return named
    for i in range(len(cells)):
        if len(cells) < 4:
            break
        rest = fit_lattice(np.delete(cells, i, axis=0), np.delete(points_mm, i, axis=0))
        if float(np.hypot(*rest.residuals_mm.T).max()) <= _USUAL_MM:
            off = float(np.hypot(*(mapped(rest.lattice, cells[[i]])[0] - points_mm[i])))
            return (
                _bad("misplaced-pair", f"point {i + 1} lies {off:.1f} mm from where the others "
                     "put it", "take it again", f"point {i + 1}"),
            )  # fmt: skip
    return (
        _bad("inconsistent-pairs", f"the points do not lie on a lattice: they are up to "
             f"{float(miss.max()):.1f} mm off", "take them again, one by one"),
    )  # fmt: skip


def _misorder(cells: Points, points_mm: Points) -> tuple[Finding, ...]:
    """Name an order of the points in which they fit, if that is not the given one."""
    if _fits(cells[:, ::-1], points_mm):
        return (
            _bad("mirrored-order", "the points fit with lattice x and y exchanged",
                 "UP is +y: give the points as (x, y), in the order they are touched"),
        )  # fmt: skip
    for i in range(len(cells)):
        for j in range(i):
            order = np.arange(len(cells))
            order[i], order[j] = j, i
            if len(cells) > 2 and _fits(cells[order], points_mm):
                return (
                    _bad("swapped-pairs", f"point {j + 1} and point {i + 1} are exchanged",
                         "exchange them", f"point {j + 1}", f"point {i + 1}"),
                )  # fmt: skip
    return ()


def _fits(cells: Points, points_mm: Points) -> bool:
    try:
        fit = fit_lattice(cells, points_mm, noise_mm=1.0)
    except FitFailed:
        return False
    return float(np.hypot(*fit.residuals_mm.T).max()) <= _USUAL_MM


def _touched() -> Steps[tuple[Points, Points]]:
    count = yield from _count()
    cells, points = [], []
    for number in range(1, count + 1):
        cell = yield from _cell(number)
        yield from ask_done(
            f"touch {number}",
            f"Bring the tool point over lattice ({cell[0]:g}, {cell[1]:g}), by hand or from the "
            "pendant",
        )
        reading = yield from read_tool()
        cells.append(cell)
        points.append((reading.pose.x_mm, reading.pose.y_mm))
    return np.array(cells), np.array(points)


def _seen(site: Site, camera: str) -> Steps[tuple[Points, Points]]:
    known = knowledge_of(site, camera)
    if known.before is None:
        raise CalibrationError(f"camera {camera} is not calibrated; calibrate its homography first")
    height_mm = yield from ask_number(
        "height", "How high above the base plane are the marks?", unit="mm",
        default=known.height_mm,
    )  # fmt: skip
    count = yield from _count()
    picture = yield from capture(camera, "marks on lattice points")
    cells, points = [], []
    for number in range(1, count + 1):
        cell = yield from _cell(number)
        pixel = yield from point_at(
            f"pixel {number}", f"Where is lattice ({cell[0]:g}, {cell[1]:g})?", picture
        )
        try:
            x, y = known.before.to_robot(np.array([pixel]), height_mm)[0]
        except ValueError as error:
            raise CalibrationError(f"camera {camera}: {error}") from error
        cells.append(cell)
        points.append((float(x), float(y)))
    return np.array(cells), np.array(points)


def _count() -> Steps[int]:
    return (
        yield from ask_whole(
            "points", "How many lattice points?", low=2, high=_MOST_POINTS, default=4
        )
    )


def _cell(number: int) -> Steps[tuple[float, float]]:
    default = _CELLS[number - 1] if number <= len(_CELLS) else None
    x, y = yield from ask_numbers(
        f"cell {number}", f"Lattice x, y of point {number}?", count=2, default=default
    )
    return x, y


def _typed(profile: Profile) -> Steps[LatticeMap]:
    own = profile.lattice
    step_mm = yield from ask_number("step", "Step?", unit="mm", default=own.step_mm)
    angle_deg = yield from ask_number(
        "angle", "Angle from robot x to lattice x?", unit="deg", default=own.angle_deg
    )
    x_mm, y_mm = yield from ask_numbers(
        "origin", "Robot x, y of lattice (0, 0)?", count=2, unit="mm", default=own.origin_mm
    )
    if step_mm <= 0.0:
        raise AnswerRefused("step", f"a length above 0 is expected, not {step_mm:g} mm")
    return LatticeMap(step_mm=step_mm, angle_deg=angle_deg, origin_x_mm=x_mm, origin_y_mm=y_mm)


def _measurement(
    lattice: LatticeMap | None,
    fit: LatticeFit | None,
    cells: Points | Sequence[tuple[float, float]],
    points_mm: Points | Sequence[tuple[float, float]],
    findings: Sequence[Finding],
    way: str,
    step_mm: float | None = None,
) -> Measurement:
    at, places = np.asarray(cells, np.float64), np.asarray(points_mm, np.float64)
    held = _left_out(at, places, step_mm) if fit is not None else []
    samples = tuple(
        Sample(
            label=f"point {i + 1}",
            given=(float(at[i, 0]), float(at[i, 1])),
            measured=(float(places[i, 0]), float(places[i, 1])),
            residual=() if fit is None else tuple(float(v) for v in fit.residuals_mm[i]),
            residual_mm=None if fit is None else float(np.hypot(*fit.residuals_mm[i])),
            held_out_mm=held[i] if held else None,
        )
        for i in range(len(at))
    )
    values = (
        () if lattice is None
        else (lattice.step_mm, lattice.angle_deg, lattice.origin_x_mm, lattice.origin_y_mm)
    )  # fmt: skip
    deviations = (None,) * 4 if fit is None else tuple(np.sqrt(np.diag(fit.covariance)).tolist())
    strong = () if fit is None else strong_correlations(fit.covariance, NAMES)
    is_good = lattice is not None and worst(findings) is not Grade.BAD
    return Measurement(
        kind=KIND,
        subject="cell",
        method=f"lattice {way}" + (", step fixed" if step_mm is not None else ""),
        samples=samples,
        parameters=tuple(
            Parameter(name=n, value=float(v), unit=u, deviation=d)
            for n, v, u, d in zip(NAMES, values, UNITS, deviations, strict=True)
        ) if values else (),
        covariance=() if fit is None
        else tuple(tuple(float(v) for v in row) for row in fit.covariance),
        correlations=tuple(Correlation(first=a, second=b, value=c) for a, b, c in strong),
        accuracy=_accuracy(fit, held),
        region=Region(text="the lattice between the points that were taken"),
        findings=tuple(findings),
        values={
            "lattice.step_mm": lattice.step_mm,
            "lattice.angle_deg": lattice.angle_deg,
            "lattice.origin_mm": [lattice.origin_x_mm, lattice.origin_y_mm],
        } if lattice is not None and is_good else {},
        not_known=() if fit is not None else ("how exact it is: nothing was measured",),
    )  # fmt: skip


def _accuracy(fit: LatticeFit | None, held: Sequence[float]) -> Accuracy:
    if fit is None:
        return Accuracy()
    covariances = fit.covariance_at(np.array(_CELLS))
    return Accuracy(
        fit_rms=float(np.sqrt((fit.residuals_mm**2).sum(axis=1).mean())),
        held_out_rms=float(np.sqrt(np.mean(np.square(held)))) if held else None,
        held_out_max=max(held, default=None),
        held_out_count=len(held),
        how="leave-one-out" if held else "",
        predicted_rms=float(np.sqrt(np.trace(covariances, axis1=1, axis2=2).mean())),
        predicted_max=float(np.sqrt(np.linalg.eigvalsh(covariances).max() * fit.region_factor(2))),
    )


def _left_out(cells: Points, points_mm: Points, step_mm: float | None) -> list[float]:
    if len(cells) < 3:
        return []
    held = []
    for index in range(len(cells)):
        rest, places = np.delete(cells, index, axis=0), np.delete(points_mm, index, axis=0)
        try:
            fit = fit_lattice(rest, places, step_mm=step_mm, noise_mm=1.0)
        except FitFailed:
            return []
        held.append(float(np.hypot(*(mapped(fit.lattice, cells[[index]])[0] - points_mm[index]))))
    return held


def check_world(site: Site, record: CalibrationRecord) -> Procedure:
    """Check a lattice at freshly touched points."""
    profile = playground_profile(site)
    own = profile.lattice
    lattice = LatticeMap(
        step_mm=own.step_mm, angle_deg=own.angle_deg, origin_x_mm=own.origin_mm[0],
        origin_y_mm=own.origin_mm[1],
    )  # fmt: skip
    limit_mm = yield from ask_within(
        "quality", "Most that is good?", low=0.0, high=100.0, unit="mm", default=2.0
    )
    cells, points = yield from _touched()
    off = np.hypot(*(mapped(lattice, cells) - points).T)
    findings = [*judge_world(profile, lattice, 12, 12, "")]
    largest = float(off.max())
    if largest > limit_mm:
        findings.append(
            Finding(
                code="lattice-moved",
                grade=Grade.BAD if largest > 2.5 * limit_mm else Grade.DEGRADED,
                text=f"touched points lie up to {largest:.1f} mm from the lattice, {limit_mm:g} mm "
                "are good",
                hint="was the table or the arm moved? calibrate the world again",
            )
        )
    return Measurement(
        kind=record.kind,
        subject=record.subject,
        method=f"the lattice of {record.identity[:8]} held against {len(off)} touched points",
        samples=tuple(
            Sample(
                label=f"point {i + 1}",
                given=(float(cells[i, 0]), float(cells[i, 1])),
                measured=(float(points[i, 0]), float(points[i, 1])),
                held_out_mm=float(off[i]),
                is_used=False,
            )
            for i in range(len(off))
        ),
        accuracy=Accuracy(
            held_out_rms=float(np.sqrt((off**2).mean())), held_out_max=largest,
            held_out_count=len(off), how="freshly touched points",
        ),
        findings=tuple(findings),
        based_on=(record.identity,),
    )  # fmt: skip


def _bad(code: str, text: str, hint: str, *samples: str) -> Finding:
    return Finding(code=code, grade=Grade.BAD, text=text, hint=hint, samples=samples)
