"""Blocks in the picture of a fixed camera: one call for one picture or for two.

With two pictures, on a white and on a black screen, faces are sought in the black one and
whatever hides the lit screen must be explained by them. With one picture, on any background,
faces are sought in it alone, and the background's own look is subtracted where it is known.

What cannot be explained is reported as an unknown thing with the reason; what could not be
seen is told by the visible area. Nothing is guessed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.errors import VisionError
from cell.vision.colour_model import ColourGuess, ColourModel, reference_colours
from cell.vision.confidence import confidence_of
from cell.vision.face_fit import FittedFace, Start, fit_faces
from cell.vision.faces import PITCH_PX, Face, faces, halved
from cell.vision.seams import in_seen_order
from cell.vision.sight import TableSight, turned
from cell.vision.tables import fold_deg
from cell.vision.tiling import Placement, may_be_blocks, single_faces, tile
from cell.vision.visible_area import VisibleArea, visible_area

Pixels = NDArray[np.uint8]
Points = NDArray[np.float64]

_OUTLINE_LOSS_PX = 1.0
_LEAST_SUPPORT = 0.55
_LEAST_OPEN_SUPPORT = 0.6
_LEAST_UNIFORM = 0.85
_LEAST_GROUP_SUPPORT = 0.25
_MOST_LIGHT_SPREAD = 0.22
_LIT_SHARE = 0.15
_LEAST_SCREEN_LEVEL = 60.0
_LEAST_UNKNOWN_SHARE = 0.35
_LEAST_STEPPED_SHARE = 0.7
_LEAST_UNKNOWN_STEPPED_SHARE = 0.9
_DARK_GROWTH = 1.12
_DARK_WINDOW = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundBlock:
    """A block that was recognised.

    Attributes:
        kind: Kind in the profile's table of blocks.
        colour: Its paint.
        x_mm: Robot x of its middle.
        y_mm: Robot y of its middle.
        angle_deg: Direction of its length from robot x, folded by the kind's symmetry: cubes
            -45 to 45, bridges -90 to 90, cylinders 0.
        confidence: Probability that kind and colour are right.
        deviation_mm: Standard deviation of the middle along its worst direction.
        deviation_deg: Standard deviation of the angle.
        outline_px: Corners of its top face in the picture, (n, 2).
        mean_rgb: Mean colour of its top face.
        touches: Whether its face joins that of another block of its colour.
    """

    kind: str
    colour: str
    x_mm: float
    y_mm: float
    angle_deg: float
    confidence: float
    deviation_mm: float
    deviation_deg: float
    outline_px: Points
    mean_rgb: tuple[float, float, float]
    touches: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UnknownThing:
    """Something that is there and was not recognised.

    Attributes:
        reason: Why not.
        x_mm: Robot x of its middle, as if it were as high as a block.
        y_mm: Robot y of the same.
        outline_px: Its outline in the picture, (n, 2).
    """

    reason: str
    x_mm: float
    y_mm: float
    outline_px: Points


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recognition:
    """What a look at the playground came to.

    Attributes:
        blocks: The blocks, from the picture's top to its bottom.
        unknown: Things that are there and were not recognised.
        area: Where one could have seen a block.
        light: Level of the lamps that the blocks tell, 1 for the model's; None without blocks.
    """

    blocks: tuple[FoundBlock, ...]
    unknown: tuple[UnknownThing, ...]
    area: VisibleArea
    light: float | None


@dataclass(frozen=True, slots=True, eq=False)
class TwoPictures:
    """Pictures on a white and on a black screen, nothing moved in between.

    Attributes:
        white: R G B (960, 1280, 3), uint8.
        black: The same view.
    """

    white: Pixels
    black: Pixels


@dataclass(frozen=True, slots=True, eq=False)
class OnePicture:
    """A picture on any background.

    Attributes:
        pixels: R G B (960, 1280, 3), uint8.
    """

    pixels: Pixels


@dataclass(frozen=True, slots=True, kw_only=True)
class RecognitionModel:
    """What the recogniser has learned, beside the profile.

    Attributes:
        colours: The blocks' colours.
        least_confidence: Blocks less sure than this are reported as unknown.
    """

    colours: ColourModel
    least_confidence: float = 0.5


def reference_model() -> RecognitionModel:
    """Return the model of the reference's tables."""
    return RecognitionModel(colours=reference_colours())


def recognise(
    look: TwoPictures | OnePicture,
    sight: TableSight,
    model: RecognitionModel | None = None,
    *,
    hidden: Pixels | None = None,
) -> Recognition:
    """Return the blocks on the screen.

    Args:
        look: One picture or two.
        sight: What is known of the table.
        model: What was learned; the reference's tables without one.
        hidden: Above 0 where something known hides the table, such as the arm (see
            `cell.vision.arm_mask`), (960, 1280).

    Raises:
        VisionError: A picture has the wrong shape, or the screen is off in both pictures.
    """
    model = model or reference_model()
    picture = look.black if isinstance(look, TwoPictures) else look.pixels
    for one in (look.white, look.black) if isinstance(look, TwoPictures) else (look.pixels,):
        _check(one)
    return _Look(picture, sight, model, hidden).result(
        look.white if isinstance(look, TwoPictures) else None
    )


def fitted_faces(
    look: TwoPictures | OnePicture,
    sight: TableSight,
    model: RecognitionModel | None = None,
) -> list[tuple[FittedFace, bool]]:
    """Return all faces laid on their edges, accepted or not, and whether each is of a group.

    For those who judge the recogniser; blocks are told by `recognise`.

    Args:
        look: One picture or two.
        sight: What is known of the table.
        model: What was learned; the reference's tables without one.

    Raises:
        VisionError: A picture has the wrong shape.
    """
    picture = look.black if isinstance(look, TwoPictures) else look.pixels
    _check(picture)
    return _Look(picture, sight, model or reference_model(), None).fitted()


def _check(picture: Pixels) -> None:
    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8:
        raise VisionError(
            f"the picture is {picture.dtype} of shape {picture.shape}; take it as uint8 R G B"
        )
    if picture.shape[:2] != (960, 1280):
        raise VisionError(
            f"the picture has {picture.shape[1]} x {picture.shape[0]} pixels; the view of the "
            "table is known for 1280 x 960"
        )


class _Look:
    """One recognition."""

    def __init__(
        self, picture: Pixels, sight: TableSight, model: RecognitionModel, hidden: Pixels | None
    ) -> None:
        self._picture = picture
        self._sight = sight
        self._model = model
        self._area = visible_area(sight, hidden, (picture.shape[0] // 2, picture.shape[1] // 2))
        self._small = halved(picture)
        self._unknown: list[UnknownThing] = []
        self._faces: list[Face] = []

    def result(self, white: Pixels | None) -> Recognition:
        """Return what is there."""
        quarter = halved(self._small)
        starts, groups = self._starts(quarter)
        fitted = fit_faces(self._picture, starts)
        blocks, light = self._judged(fitted, groups)
        if white is None:
            self._explain_faces(blocks, groups)
        else:
            self._explain_dark(quarter, halved(halved(white)), blocks)
        return Recognition(
            blocks=tuple(sorted(blocks, key=lambda one: one.outline_px[:, 1].mean())),
            unknown=tuple(self._unknown),
            area=self._area,
            light=light,
        )

    def fitted(self) -> list[tuple[FittedFace, bool]]:
        """Return the faces before they are judged."""
        starts, groups = self._starts(halved(self._small))
        faces_found = fit_faces(self._picture, starts)
        return [
            (face, groups.count(number) > 1)
            for face, number in zip(faces_found, groups, strict=True)
        ]

    def _starts(self, quarter: Pixels) -> tuple[list[Start], list[int]]:
        """Return where faces may lie, and the number of the patch that each is part of."""
        scale = self._mm_per_px()
        least = min(kind.area_mm2 for kind in self._sight.kinds) / (scale * PITCH_PX) ** 2
        found = list(faces(self._small, quarter, self._area.mask, self._model.colours, least))
        self._faces = found
        if not found:
            return [], []
        middles = np.array([face.outline_px.mean(axis=0) for face in found])
        maps, inverses = self._sight.local_maps(middles)
        starts: list[Start] = []
        groups: list[int] = []
        for number, (face, to_mm, back) in enumerate(zip(found, maps, inverses, strict=True)):
            outline = face.outline_px @ to_mm[:, :2].T + to_mm[:, 2]
            placements = self._placements(face, outline, scale, back)
            for one in placements:
                starts.append(Start(one.shape, one.x_mm, one.y_mm, one.angle_rad, back))
                groups.append(number)
        return starts, groups

    def _placements(
        self, face: Face, outline: Points, scale: float, px_from_mm: Points
    ) -> Sequence[Placement]:
        def refine(rough: Sequence[Placement]) -> list[tuple[Placement, float]]:
            starts = [
                Start(one.shape, one.x_mm, one.y_mm, one.angle_rad, px_from_mm) for one in rough
            ]
            return [
                (
                    Placement(
                        shape=one.shape,
                        x_mm=exact.x_mm,
                        y_mm=exact.y_mm,
                        angle_rad=exact.angle_rad,
                        fit=one.fit,
                    ),
                    exact.support,
                )
                for one, exact in zip(rough, fit_faces(self._picture, starts), strict=True)
            ]

        grown = _OUTLINE_LOSS_PX * scale
        kinds = self._sight.kinds
        single = single_faces(outline, grown, kinds)
        if len(single) == 1:
            return single
        if single:
            return [max(refine(single), key=lambda pair: pair[1])[0]]
        is_stepped = face.stepped_share(self._small, self._area.mask) >= _LEAST_STEPPED_SHARE
        if is_stepped and may_be_blocks(outline, kinds):
            several = tile(outline, grown, kinds, refine)
            if several is not None:
                ordered = in_seen_order(several, self._picture, px_from_mm)
                if ordered is None:
                    self._report("flush blocks in a row whose order cannot be seen", face)
                return ordered or []
        if is_stepped and face.touches_edge(self._area.mask):
            self._report("cut by the edge of the picture, the screen or what hides it", face)
        return []

    def _report(self, reason: str, face: Face) -> None:
        self._add_unknown(reason, face.outline_px)

    def _add_unknown(self, reason: str, outline_px: Points) -> None:
        middle = np.array(cv2.minAreaRect(outline_px.astype(np.float32))[0])
        # Table and bezel beside the screen are looked at for blocks that hang over its edge;
        # whatever else lies there is none of ours.
        panel = self._sight.panel_px().astype(np.float32)
        if cv2.pointPolygonTest(panel, (float(middle[0]), float(middle[1])), False) < 0:
            return
        x, y = self._sight.view.to_robot(middle, self._sight.top_mm).tolist()
        self._unknown.append(UnknownThing(reason=reason, x_mm=x, y_mm=y, outline_px=outline_px))

    def _mm_per_px(self) -> float:
        return self._sight.mm_per_px

    def _judged(
        self, fitted: Sequence[FittedFace], groups: Sequence[int]
    ) -> tuple[list[FoundBlock], float | None]:
        """Return the faces that are blocks, and the light they tell."""
        members = {number: groups.count(number) for number in set(groups)}
        kept: list[tuple[FittedFace, bool]] = []
        for face, number in zip(fitted, groups, strict=True):
            is_group = members[number] > 1
            least = _LEAST_GROUP_SUPPORT if is_group else _LEAST_SUPPORT
            if face.support < least or face.open_support < _LEAST_OPEN_SUPPORT:
                continue
            if face.uniform < _LEAST_UNIFORM:
                continue
            kept.append((face, is_group))
        light = self._light([face for face, _ in kept])
        blocks: list[FoundBlock] = []
        if not kept:
            return [], None
        means = np.array([face.mean_rgb for face, _ in kept])
        guesses = self._model.colours.classify_all(means, light=light)
        outlines = self._outlines_px([face for face, _ in kept])
        for (face, is_group), guess, outline in zip(kept, guesses, outlines, strict=True):
            block = self._block(face, guess, outline, is_group)
            if block is not None:
                blocks.append(block)
        return blocks, light

    def _light(self, kept: Sequence[FittedFace]) -> float | None:
        """Return the level of the lamps: the median of what the faces tell."""
        colours = self._model.colours
        if not kept:
            return None
        means = np.array([face.mean_rgb for face in kept])
        names = [guess.colour for guess in colours.classify_all(means)]
        is_told = np.array([name is not None for name in names])
        if not is_told.any():
            return None
        told = colours.lights_of(means[is_told], [name for name in names if name is not None])
        return float(np.median(told))

    def _block(
        self, face: FittedFace, guess: ColourGuess, outline: Points, is_group: bool
    ) -> FoundBlock | None:
        if guess.colour is None:
            self._add_unknown(guess.reason, outline)
            return None
        confidence = guess.probability * confidence_of(face, is_group=is_group)
        if confidence < self._model.least_confidence:
            self._add_unknown(f"may be a {guess.colour} {face.shape.kind}", outline)
            return None
        symmetry = face.shape.symmetry_deg
        return FoundBlock(
            kind=face.shape.kind,
            colour=guess.colour,
            x_mm=face.x_mm,
            y_mm=face.y_mm,
            angle_deg=fold_deg(math.degrees(face.angle_rad), symmetry),
            confidence=confidence,
            deviation_mm=face.deviation_mm,
            deviation_deg=math.degrees(face.deviation_rad),
            outline_px=outline,
            mean_rgb=face.mean_rgb,
            touches=is_group,
        )

    def _outlines_px(self, found: Sequence[FittedFace]) -> list[Points]:
        """Return the outlines of faces in the picture, all projected at once."""
        corners = [
            turned(face.shape.outline_mm, face.angle_rad) + (face.x_mm, face.y_mm) for face in found
        ]
        pixels = self._sight.view.to_picture(np.concatenate(corners), self._sight.top_mm)
        ends = np.cumsum([len(one) for one in corners])[:-1]
        return [np.asarray(part) for part in np.split(pixels, ends)]

    def _explain_faces(self, blocks: Sequence[FoundBlock], groups: Sequence[int]) -> None:
        """Report patches with outline, colour and clear edges of a block that are none found."""
        known = [block.outline_px.astype(np.float32) for block in blocks]
        known += [thing.outline_px.astype(np.float32) for thing in self._unknown]
        for number in sorted(set(groups)) if len(groups) > len(blocks) else ():
            face = self._faces[number]
            middle = face.outline_px.mean(axis=0).tolist()
            if any(cv2.pointPolygonTest(one, middle, False) >= 0 for one in known):
                continue
            if face.stepped_share(self._small, self._area.mask) >= _LEAST_UNKNOWN_STEPPED_SHARE:
                self._report("looks like a block, but its edges are not one's", face)

    def _explain_dark(self, black: Pixels, white: Pixels, blocks: Sequence[FoundBlock]) -> None:
        """Report what hides the lit screen and is no block found; pictures of quarter size."""
        red, green, blue = cv2.split(cv2.subtract(white, black))
        levels = np.asarray(cv2.max(cv2.max(red, green), blue), np.uint8)
        # Bezel and table give no light: only well within the screen does dark mean hidden.
        inset_mm = 4.0 if self._sight.knows_heights else 14.0
        panel = self._sight.panel_mask(-inset_mm, levels.shape)
        looked_at = cv2.bitwise_and(panel, np.ascontiguousarray(self._area.mask[::2, ::2]))
        screen_level = _level_of(levels[looked_at > 0])
        if screen_level < _LEAST_SCREEN_LEVEL:
            raise VisionError(
                "the screen is off or shows the same in both pictures: white minus black is "
                f"{screen_level:.0f} grey levels, a lit screen gives at least "
                f"{_LEAST_SCREEN_LEVEL:.0f}; switch the screen on, show white for the first "
                "picture and black for the second"
            )
        _, dark = cv2.threshold(levels, _LIT_SHARE * screen_level, 255, cv2.THRESH_BINARY_INV)
        dark = cv2.bitwise_and(dark, looked_at)
        lines = []
        for block in blocks:
            middle = block.outline_px.mean(axis=0)
            grown = middle + (block.outline_px - middle) * _DARK_GROWTH
            lines.append(np.rint(_in_quarter(grown) * 16.0).astype(np.int32))
        # One by one: where two overlap, all at once would leave a hole.
        for line in lines:
            cv2.fillConvexPoly(dark, line, 0, cv2.LINE_8, 4)
        dark = np.asarray(cv2.morphologyEx(dark, cv2.MORPH_OPEN, _DARK_WINDOW))
        least = min(kind.area_mm2 for kind in self._sight.kinds) / (4.0 * self._mm_per_px()) ** 2
        known = [thing.outline_px.mean(axis=0) for thing in self._unknown]
        contours, _ = cv2.findContours(dark, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        for contour in contours:
            if cv2.contourArea(contour) < _LEAST_UNKNOWN_SHARE * least:
                continue
            outline = (np.asarray(contour, np.float64).reshape(-1, 2) + 0.5) * 4.0 - 0.5
            middle = outline.mean(axis=0)
            if any(np.linalg.norm(middle - other) < 20.0 for other in known):
                continue
            self._add_unknown("hides the screen and is no block that could be told", outline)


def _in_quarter(pixels: Points) -> Points:
    """Return pixels of the picture in that of a quarter of its size."""
    return np.asarray((pixels + 0.5) / 4.0 - 0.5)


def _level_of(levels: NDArray[np.uint8]) -> float:
    """Return the level that a fifth of the pixels exceed, 0 without pixels."""
    if levels.size == 0:
        return 0.0
    rank = int(0.8 * (levels.size - 1))
    counts = np.bincount(levels, minlength=256).cumsum()
    return float(np.searchsorted(counts, rank, side="right"))
