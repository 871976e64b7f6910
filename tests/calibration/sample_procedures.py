"""Small procedures that ask for everything once, for tests of what plays procedures."""

from __future__ import annotations

from calibration import catalogue
from calibration.catalogue import Entry, Site
from calibration.errors import FitFailed
from calibration.procedure import (
    Procedure,
    ask_choice,
    ask_number,
    ask_numbers,
    capture,
    light,
    put_block,
    read_picture,
    return_block,
    show,
    stand_aside,
    tell,
)
from calibration.record import Accuracy, CalibrationRecord, Measurement, Parameter, Region, Sample
from calibration.verdict import Finding, Grade
from cell.store import TablePlace

_HERE = "tests.calibration.sample_procedures"
PLACES = ((400.0, -100.0), (500.0, 0.0), (600.0, 100.0))
CYLINDER = 15

ENTRIES = (
    Entry("laid", "homography", f"{_HERE}:laid", f"{_HERE}:look_again", "Lay a block three times."),
    Entry("typed", "lattice", f"{_HERE}:typed", "", "The lattice's origin, typed."),
    Entry("filed", "lens", f"{_HERE}:filed", "", "A picture from a file."),
    Entry("failing", "homography", f"{_HERE}:failing", "", "Fetches a block, then fails."),
)


def install() -> None:
    """Have the command line know these procedures, in a process of its own."""
    catalogue.CATALOGUE = ENTRIES  # type: ignore[misc]


def typed(site: Site) -> Procedure:
    """Ask for the origin and take it; `error_mm` says how good it is."""
    name = yield from ask_choice("how", "How was it measured?", ("ruler", "arm"), default="ruler")
    origin = yield from ask_numbers("origin", "Where is lattice (0, 0)?", count=2, unit="mm")
    error_mm = yield from ask_number("error", "How far off may it be?", unit="mm", default=0.5)
    findings: tuple[Finding, ...] = ()
    if error_mm > 5:
        findings = (
            Finding(code="far-off", grade=Grade.BAD, text=f"{error_mm:g} mm off", hint="measure"),
        )
    return Measurement(
        kind="lattice",
        subject="cell",
        method=f"typed, measured by {name}",
        parameters=(
            Parameter(name="origin x", value=origin[0], unit="mm", deviation=error_mm),
            Parameter(name="origin y", value=origin[1], unit="mm", deviation=error_mm),
        ),
        accuracy=Accuracy(held_out_rms=error_mm, held_out_count=1, how="what was typed"),
        region=Region(text="the lattice"),
        findings=findings,
        values={"lattice.origin_mm": list(origin)},
        not_known=("whether it was read off rightly",),
    )


def laid(site: Site) -> Procedure:
    """Lay a block at three places, take a picture each time, and return what was seen."""
    shift_mm = yield from ask_number("shift", "By how much to shift the map?", default=0.0)
    yield from light(is_on=True)
    yield from show("white")
    samples = []
    for done, (x_mm, y_mm) in enumerate(PLACES):
        yield from tell(f"to ({x_mm:g}, {y_mm:g}) mm", done, len(PLACES))
        yield from put_block(CYLINDER, TablePlace(x_mm=x_mm, y_mm=y_mm, yaw_deg=0.0))
        yield from stand_aside()
        picture = yield from capture("top", f"place {done + 1}")
        u_px, v_px = 100.0 + y_mm, 500.0 - x_mm / 2
        samples.append(
            Sample(
                label=f"place {done + 1}",
                given=(x_mm, y_mm),
                measured=(u_px, v_px),
                residual=(0.25, -0.5 * done),
                residual_mm=0.3,
                held_out_mm=0.4,
                picture=picture.digest,
            )
        )
    yield from return_block(CYLINDER)
    (r1, r2, (a, b, c)) = (0.00656, 0.58748, 222.028), (0.58116, -0.00504, -375.536), (0.0, 1e-5, 1)
    return Measurement(
        kind="homography",
        subject="top",
        method="three places of one cylinder",
        samples=tuple(samples),
        accuracy=Accuracy(held_out_rms=1.5 + abs(shift_mm), held_out_count=3, how="leave-one-out"),
        region=Region(text="between the places"),
        values={
            "cameras.top.plane_map": [
                [r1[0], r1[1], r1[2] + shift_mm], [r2[0], r2[1], r2[2]], [a, b, c],
            ]
        },
    )  # fmt: skip


def look_again(site: Site, record: CalibrationRecord) -> Procedure:
    """Take a fresh picture; `moved` says by how much the camera moved."""
    moved_mm = yield from ask_number("moved", "By how much did it move?", default=0.0)
    yield from light(is_on=True)
    picture = yield from capture("top", "fresh")
    grade = Grade.BAD if moved_mm > 2 else Grade.DEGRADED if moved_mm > 1 else Grade.OK
    finding = Finding(code="moved", grade=grade, text=f"moved by {moved_mm:g} mm", hint="mend")
    return Measurement(
        kind=record.kind,
        subject=record.subject,
        method=f"a picture of {picture.pixels.shape[1]} columns",
        findings=() if grade is Grade.OK else (finding,),
    )


def filed(site: Site) -> Procedure:
    """Read a picture from a file."""
    picture = yield from read_picture("board.png")
    return Measurement(
        kind="lens",
        subject="top",
        method="from a file",
        samples=(Sample(label="board.png", picture=picture.digest),),
    )


def failing(site: Site) -> Procedure:
    """Fetch a block and find that nothing can be fitted."""
    yield from put_block(CYLINDER, TablePlace(x_mm=500.0, y_mm=0.0, yaw_deg=0.0))
    raise FitFailed("three points on a line determine no homography; move one of them")
