"""Calibrates a lens from pictures of a board: from files, or live with guidance."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from pydantic import JsonValue

from calibration.catalogue import Site
from calibration.errors import CalibrationError, FitFailed
from calibration.lens.checking import checked, unchecked
from calibration.lens.fit import BoardView, LensPrior, fit_lens
from calibration.lens.judging import guidance, other_board, without_board
from calibration.lens.result import judged
from calibration.procedure import (
    Procedure,
    Steps,
    ask_choice,
    ask_number,
    ask_text,
    ask_whole,
    ask_yes,
    capture,
    read_picture,
    tell,
)
from calibration.record import CalibrationRecord, Measurement
from calibration.requests import Picture
from calibration.verdict import Finding, Grade
from cell.vision.boards import Board, find_board

_MODELS = ("k1", "k1 k2", "k1 k2 p1 p2", "k1 k2 k3 p1 p2")
_LIVE_VIEWS = 12
_RANGE = re.compile(r"\{(\d+)-(\d+)\}")
_MOST_FILES = 500
_MOST_SQUARES = 100


@dataclass(slots=True)
class _Gathered:
    """Views as they come in."""

    board: Board
    views: list[BoardView] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    pictures: dict[str, str] = field(default_factory=dict)
    missed: list[Picture] = field(default_factory=list)
    first: Picture | None = None
    size_px: tuple[int, int] | None = None

    def take(self, label: str, picture: Picture) -> bool:
        """Look for the board; return whether it is there."""
        size = (picture.pixels.shape[1], picture.pixels.shape[0])
        if self.size_px is None:
            self.size_px = size
        if size != self.size_px:
            self.findings.append(
                Finding(
                    code="wrong-picture-size",
                    grade=Grade.BAD,
                    text=f"{label} has {size[0]} x {size[1]} pixels, the first picture "
                    f"{self.size_px[0]} x {self.size_px[1]}",
                    hint="take all pictures in the same mode, and crop none",
                    samples=(label,),
                )
            )
            return False
        found = find_board(picture.pixels, self.board)
        if found is None:
            self.findings.append(without_board(label, picture.pixels))
            self.missed.append(picture)
            return False
        self.first = self.first or picture
        self.views.append(BoardView(label=label, ids=found.ids, pixels=found.pixels))
        self.pictures[label] = picture.digest
        return True


def calibrate_lens(site: Site) -> Procedure:
    """Calibrate focal length, centre and distortion of a camera's lens."""
    cameras = tuple(site.profile.cameras)
    if not cameras:
        raise CalibrationError(f"the profile of {site.profile.name} has no camera")
    first = "top" if "top" in cameras else cameras[0]
    camera = yield from ask_choice("camera", "Which camera's lens?", cameras, default=first)
    board = yield from ask_board()
    model = yield from ask_choice(
        "model", "Which distortion has the lens?", _MODELS, default="k1 k2"
    )
    prior = LensPrior(
        has_square_pixels=(
            yield from ask_yes("square_pixels", "Are the sensor's pixels square?", default=True)
        ),
        radial=sum(name in model for name in ("k1", "k2", "k3")),
        has_tangential="p1" in model,
    )
    quality_px = yield from ask_number(
        "quality", "Which held-out error is good enough?", unit="px", default=0.5
    )
    distance_mm = yield from ask_number(
        "distance", "About how far from the lens is the board held (0: not measured)?",
        unit="mm", default=0.0,
    )  # fmt: skip
    gathered = yield from gather(camera, board, prior)
    return _judged(site, camera, gathered, prior, quality_px, distance_mm)


def ask_board(usual: JsonValue = None) -> Steps[Board]:
    """Ask which board is used; what a record's details tell of its board is the default."""
    told = usual if isinstance(usual, dict) else {}
    kind = yield from ask_choice(
        "board",
        "Which board?",
        ("charuco", "chessboard"),
        default="chessboard" if told.get("kind") == "chessboard" else "charuco",
    )
    columns = yield from ask_whole(
        "columns", "How many squares across?", low=2, high=_MOST_SQUARES,
        default=round(_figure(told, "columns", 11.0)),
    )  # fmt: skip
    rows = yield from ask_whole(
        "rows", "How many squares down?", low=2, high=_MOST_SQUARES,
        default=round(_figure(told, "rows", 8.0)),
    )  # fmt: skip
    square_mm = yield from ask_number(
        "square", "How large is a square?", unit="mm", default=_figure(told, "square_mm", 30.0)
    )
    marker_mm, dictionary = 0.0, "DICT_5X5_100"
    if kind == "charuco":
        marker_mm = yield from ask_number(
            "marker", "How large is a marker?", unit="mm", default=_figure(told, "marker_mm", 22.0)
        )
        dictionary = yield from ask_text(
            "dictionary",
            "Which dictionary are its markers of?",
            default=str(told.get("dictionary") or dictionary),
        )
    try:
        return Board(
            kind="charuco" if kind == "charuco" else "chessboard", columns=columns,
            rows=rows, square_mm=square_mm, marker_mm=marker_mm, dictionary=dictionary,
        )  # fmt: skip
    except ValueError as error:
        raise CalibrationError(f"there is no such board: {error}") from error


def _figure(told: Mapping[str, JsonValue], name: str, otherwise: float) -> float:
    value = told.get(name)
    return float(value) if isinstance(value, int | float) and value > 0 else otherwise


def gather(camera: str, board: Board, prior: LensPrior) -> Steps[_Gathered]:
    """Take views, from files or with the camera."""
    gathered = _Gathered(board)
    text = yield from ask_text(
        "files",
        "Pictures from files: names separated by commas, numbers as board{01-12}.png (empty: "
        "take them with the camera)",
        default="",
    )
    if text:
        names = expanded(text)
        for done, name in enumerate(names):
            yield from tell(f"reading {name}", done, len(names))
            picture = yield from read_picture(name)
            gathered.take(name.rsplit("/", 1)[-1], picture)
        return gathered
    advice = "hold the board so that it fills half the picture"
    for number in range(1, 10 * _LIVE_VIEWS):
        choice = yield from ask_choice(
            f"view {number}",
            f"View {number}: {advice}. Take it, or is it enough?",
            ("take", "enough"),
            default="take" if number <= _LIVE_VIEWS else "enough",
        )
        if choice == "enough":
            break
        picture = yield from capture(camera, f"board, view {number}")
        if gathered.take(f"view {number}", picture):
            advice = _advice(gathered, prior)
        else:
            advice = gathered.findings[-1].text + "; " + gathered.findings[-1].hint
        yield from tell(advice, len(gathered.views), _LIVE_VIEWS)
    return gathered


def _advice(gathered: _Gathered, prior: LensPrior) -> str:
    wide, high = gathered.size_px or (1280, 960)
    poses: Sequence[np.ndarray[tuple[int, ...], np.dtype[np.float64]]] = ()
    if len(gathered.views) >= 3:
        try:
            poses = fit_lens(gathered.board, gathered.views, wide, high, prior).poses
        except FitFailed:
            return "tilt the board more"
    return guidance(gathered.views, poses, wide, high)


def _judged(
    site: Site,
    camera: str,
    gathered: _Gathered,
    prior: LensPrior,
    quality_px: float,
    distance_mm: float,
) -> Measurement:
    findings = gathered.findings
    other = _other(gathered)
    findings = [*findings, other] if other is not None else findings
    size = gathered.size_px or (1280, 960)
    if size[0] * 3 != size[1] * 4:
        findings = [*findings, _not_four_to_three(size)]
    return judged(
        camera,
        site.profile.cameras[camera].guid,
        gathered.board,
        gathered.views,
        size,
        prior,
        quality_px=quality_px,
        distance_mm=distance_mm,
        pictures=gathered.pictures,
        findings=findings,
    )


def _other(gathered: _Gathered) -> Finding | None:
    """Return which other board was shown, if so."""
    if gathered.first is not None:
        # Corners of a ChArUco board are also found where its squares were miscounted.
        is_charuco = gathered.board.kind == "charuco"
        return other_board(gathered.first.pixels, gathered.board) if is_charuco else None
    is_sharp = all(f.code == "board-not-found" for f in gathered.findings)
    if not gathered.missed or not is_sharp:
        return None
    return other_board(gathered.missed[0].pixels, gathered.board)


def _not_four_to_three(size: tuple[int, int]) -> Finding:
    return Finding(
        code="wrong-picture-size",
        grade=Grade.BAD,
        text=f"the pictures have {size[0]} x {size[1]} pixels; the cell's are 4 : 3 (1280 x 960)",
        hint="take them in one of the camera's own modes, and crop none",
    )


def expanded(text: str) -> list[str]:
    """Return file names of a list, with `{01-12}` counted out.

    Raises:
        CalibrationError: It names nothing, or too many.
    """
    names: list[str] = []
    for part in (piece.strip() for piece in text.split(",")):
        match = _RANGE.search(part)
        if match is None:
            names += [part] if part else []
            continue
        first, last = match.group(1), match.group(2)
        numbers = range(int(first), int(last) + 1)
        if len(numbers) > _MOST_FILES:
            raise CalibrationError(f"{part} names {len(numbers)} files; {_MOST_FILES} are the most")
        names += [
            part[: match.start()] + str(n).zfill(len(first)) + part[match.end() :] for n in numbers
        ]
    if not names:
        raise CalibrationError(f"{text!r} names no files")
    return names


def check_lens(site: Site, record: CalibrationRecord) -> Procedure:
    """Check a lens on fresh views of a board: the lens is held, only poses are fitted.

    Nobody who holds a board is there by default: then nothing is looked at, and that is said.
    """
    has_board = yield from ask_yes(
        "has_board",
        "Does somebody hold the board into view, or are there pictures of it in files?",
        default=False,
    )
    if not has_board:
        return unchecked(site, record)
    board = yield from ask_board(record.details.get("board"))
    gathered = yield from gather(record.subject, board, LensPrior())
    return checked(site, record, board, gathered.views, gathered.findings, gathered.size_px)
