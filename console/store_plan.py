"""`cell store plan` and `cell store read-plan`: the store's sheet, printed and read back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from console.exits import ConsoleError, Exit
from console.figures import Figure
from console.hand import DEFAULTS, HandOptions, by_hand
from console.options import AsJson, ProfileName
from console.output import put, put_json, put_table, say

if TYPE_CHECKING:
    from cell.by_hand import ByHand
    from cell.profile import Profile
    from cell.sheet import SheetLayout
    from cell.sheet.finding import Pixels
    from cell.sheet.reading import Look, SheetReading

_SUFFIXES = (".pdf", ".svg")


def register(app: App) -> None:
    """Add the commands to those of the store."""
    app.command(plan, name="plan")
    app.command(read_plan, name="read-plan")


def plan(
    *,
    script: Annotated[str, Parameter(help="Script whose store it is; path or name.")] = "mash",
    profile: ProfileName = "mash",
    out: Annotated[str | None, Parameter(help="File to write, .pdf or .svg.")] = None,
    paper: Annotated[
        str | None,
        Parameter(help="a4, a3 or WxH in mm, joined; one page of its size unless given."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Draw the store's printed plan to scale; tell what is on it.

    Args:
        script: Script whose store it is.
        profile: The cell, for the sizes of blocks.
        out: File to write.
        paper: Paper to print on.
        as_json: Write JSON for programs.
    """
    from cell.sheet import SheetError, draw_sheet, pages_of, paper_of, pdf_bytes, svg_text

    path = None if out is None else _checked_path(out)
    if path is not None and path.suffix.lower() == ".svg" and paper is not None:
        raise ConsoleError("an SVG is one sheet of its own size; leave --paper out, or write a PDF")
    try:
        chosen = None if paper is None else paper_of(paper)
    except SheetError as error:
        raise ConsoleError(f"--paper: {error}") from error
    cell = _playground(profile)
    layout = _layout(cell, script)
    if layout.missing:
        raise ConsoleError(f"the plan does not fit its sheet: {layout.missing[0]}", Exit.FAILED)
    name = Path(script).stem
    drawing = draw_sheet(layout, name=name, angle_deg=cell.store.angle_deg)
    try:
        pages = pages_of(drawing, chosen)
    except SheetError as error:
        raise ConsoleError(f"--paper {paper}: {error}", Exit.FAILED) from error
    if path is not None:
        is_svg = path.suffix.lower() == ".svg"
        data = svg_text(drawing).encode() if is_svg else pdf_bytes(pages, f"Store plan {name}")
        _write(path, data)
    told = _facts(layout, pages=len(pages), path=path)
    if as_json:
        put_json(told)
    else:
        put(f"sheet    {layout.width_mm} x {layout.height_mm} mm, print {layout.identity[:8]}")
        put(f"slots    {len(layout.slots)}")
        put(f"markers  {len(layout.fiducials)} of {layout.fiducials[0].size_mm:g} mm")
        put(f"pages    {len(pages)} of {pages[0].width_mm:g} x {pages[0].height_mm:g} mm")
        put(f"written  {path}" if path else "written  no; --out FILE writes it")
    if path is not None:
        say("print at 100 %, not fitted to the page; its rulers must measure 100.0 mm", "dim")
    return Exit.DONE


def read_plan(
    *,
    camera: Annotated[str, Parameter(help="Camera that looks, or whose picture it is.")] = "top",
    picture: Annotated[str | None, Parameter(help="Picture to read; taken unless given.")] = None,
    ruler: Annotated[
        Figure | None, Parameter(help="What the sheet's 100 mm ruler measures, mm.")
    ] = None,
    options: HandOptions = DEFAULTS,
) -> int:
    """Find the store's printed plan in a picture; exit code 1 if it is not as it should be.

    Args:
        camera: Camera that looks, or whose picture it is.
        picture: File with a picture.
        ruler: What the sheet's 100 mm ruler measures.
        options: Options of every command by hand.
    """
    cell = _known(_playground(options.profile))
    if camera not in cell.cameras:
        known = ", ".join(sorted(cell.cameras))
        raise ConsoleError(f"there is no camera {camera}; the profile has {known}")
    layout = _layout(cell, options.script)
    if picture is not None:
        return _read([_still(_picture(picture), cell, camera)], cell, layout, ruler, options)
    moves = cell.cameras[camera].mount is not None

    def work(hands: ByHand) -> int:
        if moves:
            return _read(_looks_around(hands, cell, camera, layout), cell, layout, ruler, options)
        frame = hands.playground.grab(camera)
        return _read([_still(frame.pixels, cell, camera)], cell, layout, ruler, options)

    return by_hand(options, work)


def _still(pixels: Pixels, cell: Profile, camera: str) -> Look:
    """Return a picture with the view of a camera that stands still."""
    from cell.geometry import CameraView
    from cell.sheet.reading import Look

    view = cell.cameras[camera].view(cell.heights.surface_mm)
    is_known = isinstance(view, CameraView) and pixels.shape[:2] == (960, 1280)
    return Look(pixels=pixels, view=view if is_known else None)


def _looks_around(hands: ByHand, cell: Profile, camera: str, layout: SheetLayout) -> list[Look]:
    """Return looks of the camera on the flange, from poses that see all of the sheet."""
    from cell.sheet import SheetError
    from cell.sheet.looking import hand_camera, looking_poses
    from console.robot import bring_up

    try:
        hand = hand_camera(cell, camera)
    except SheetError as error:
        raise ConsoleError(str(error), Exit.FAILED) from error
    bring_up(hands)
    playground = hands.playground
    poses = looking_poses(
        cell, layout, hand.lens, hand.flange_from_camera, start=playground.arm.joints()
    )
    if not poses:
        raise ConsoleError(
            f"the arm can bring camera {camera} nowhere from where it sees the sheet", Exit.FAILED
        )
    were_on = playground.arm.arm.read_output(cell.outputs.lights)
    playground.switch_lights(is_on=True)
    looks = []
    try:
        for one in poses:
            playground.arm.move_joint(one.pose)
            pixels = playground.grab(camera).pixels
            looks.append(hand.look(pixels, playground.read_pose()))
    finally:
        playground.switch_lights(is_on=were_on)
    hands.home()
    return looks


def _read(
    looks: list[Look],
    cell: Profile,
    layout: SheetLayout,
    ruler: float | None,
    options: HandOptions,
) -> int:
    from cell.sheet import SheetError
    from cell.sheet.reading import read_sheet

    try:
        reading = read_sheet(
            looks,
            layout,
            surface_mm=cell.heights.surface_mm,
            expected=cell.store,
            ruler_mm=ruler,
        )
    except SheetError as error:
        raise ConsoleError(str(error), Exit.FAILED) from error
    _tell(reading, options.as_json)
    return Exit.DONE if reading.is_good else Exit.FAILED


def _tell(reading: SheetReading, as_json: bool) -> None:
    place = reading.place
    if as_json:
        put_json(
            {
                "print": reading.identity,
                "markers_seen": list(reading.seen),
                "markers": reading.total,
                "corner_mm": None if place is None else list(place.corner_mm),
                "angle_deg": None if place is None else place.angle_deg,
                "scale": None if place is None else place.scale,
                "covariance": None if place is None else place.covariance.tolist(),
                "held_out_rms_mm": reading.held_out_rms_mm,
                "slots": [
                    {"slot": s.number, "state": s.state, "colour": s.colour, "right": s.is_right}
                    for s in reading.slots
                ],
                "findings": [
                    {"code": f.code, "weight": f.weight, "text": f.text, "hint": f.hint}
                    for f in reading.findings
                ],
            }
        )
        return
    put(f"print    {reading.identity[:8]}, {len(reading.seen)} of {reading.total} markers seen")
    if place is not None:
        x, y = place.corner_mm
        put(f"corner   ({x:.2f}, {y:.2f}) mm, angle {place.angle_deg:.3f} deg")
        put(f"printed  at {100 * place.scale:.2f} %")
        held = reading.held_out_rms_mm
        put("held out " + ("not known" if held is None else f"{held:.2f} mm at unused markers"))
    if reading.slots:
        rows = [
            (str(s.number), s.state, s.colour or "-", _right(s.is_right)) for s in reading.slots
        ]
        put_table(("slot", "state", "colour", "right"), rows)
    for finding in reading.findings:
        say(f"{finding.text}; {finding.hint}", "red" if finding.weight == "failure" else "yellow")


def _right(is_right: bool | None) -> str:
    return "-" if is_right is None else "yes" if is_right else "no"


def _facts(layout: SheetLayout, *, pages: int, path: Path | None) -> dict[str, object]:
    return {
        "print": layout.identity,
        "width_mm": layout.width_mm,
        "height_mm": layout.height_mm,
        "pages": pages,
        "file": None if path is None else str(path),
        "slots": [
            {
                "slot": one.slot.number,
                "kind": one.slot.kind,
                "colour": one.slot.colour,
                "plan_mm": [one.slot.x_mm, one.slot.y_mm],
            }
            for one in layout.slots
        ],
        "markers": [
            {"id": one.marker_id, "plan_mm": [one.x_mm, one.y_mm], "size_mm": one.size_mm}
            for one in layout.fiducials
        ],
    }


def _checked_path(out: str) -> Path:
    path = Path(out)
    if path.suffix.lower() not in _SUFFIXES:
        raise ConsoleError(f"--out {out}: the plan is written as .pdf or .svg; end the name so")
    return path


def _write(path: Path, data: bytes) -> None:
    try:
        path.write_bytes(data)
    except OSError as error:
        raise ConsoleError(
            f"{path} cannot be written: {error.strerror}; name another place", Exit.ENVIRONMENT
        ) from error


def _playground(name: str) -> Profile:
    from cell.profile import Profile, load_cell_profile

    profile = load_cell_profile(name)
    if not isinstance(profile, Profile):
        raise ConsoleError(f"the cell {profile.name} has no store")
    return profile


def _known(profile: Profile) -> Profile:
    """Return a profile with the calibrations in force."""
    from console.calibrating import with_calibrations

    return with_calibrations(profile).profile


def _layout(cell: Profile, script: str) -> SheetLayout:
    from cell.sheet import SheetError, lay_out
    from cell.store import with_calibration_object
    from console.assembling import plan_of

    plan = with_calibration_object(plan_of(script), cell.store)
    try:
        return lay_out(plan.slots, cell.blocks)
    except SheetError as error:
        raise ConsoleError(str(error), Exit.FAILED) from error


def _picture(name: str) -> Pixels:
    from calibration.errors import CalibrationError
    from calibration.pictures import read_picture_file

    try:
        return read_picture_file(Path(name)).pixels
    except CalibrationError as error:
        raise ConsoleError(f"--picture {name}: {error}") from error
