"""Random layouts of blocks on the twin's screen, and how a recognition of them is judged.

Right is a block that was found within 10 mm of its place with its own kind and colour. One
that was not found, or reported as unknown, is not right. What was found and belongs to no
block is false.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.geometry import CameraView, LensModel, Pose, Transform
from cell.profile import Profile, TwinCameraProfile, TwinLightProfile
from cell.twin.cameras import TwinCamera
from cell.twin.scene import SceneBlock
from cell.vision.recognition import OnePicture, Recognition, TwoPictures, recognise
from cell.vision.sight import TableSight
from tests.cell.twin.cameras.stage import PROFILE, Stage, block

COLOURS = ("red", "green", "blue", "yellow", "natural")
KINDS = ("cube", "bridge", "cylinder")
BACKGROUNDS = ("black", "white", "mash", "water", "forest")
LIGHTS = (0.7, 0.85, 1.0, 1.15, 1.3)

_SAME_MM = 10.0
_SYMMETRY_DEG = {"cube": 90.0, "bridge": 180.0}


@dataclass(frozen=True, slots=True)
class Laid:
    """A block as it was laid."""

    kind: str
    colour: str
    x_mm: float
    y_mm: float
    yaw_deg: float


@dataclass
class Tally:
    """What many layouts came to."""

    laid: int = 0
    right: int = 0
    off_mm: list[float] = field(default_factory=list)
    stated_mm: list[float] = field(default_factory=list)
    off_deg: list[float] = field(default_factory=list)
    stated_deg: list[float] = field(default_factory=list)
    confidences: list[tuple[float, bool]] = field(default_factory=list)
    false: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)

    @property
    def share(self) -> float:
        """Share of the blocks laid that were right."""
        return self.right / self.laid

    @property
    def rms_mm(self) -> float:
        """Root mean square distance of the middles of the right ones."""
        return float(np.sqrt(np.mean(np.square(self.off_mm))))

    @property
    def rms_deg(self) -> float:
        """The same of the angles of those that have one."""
        return float(np.sqrt(np.mean(np.square(self.off_deg))))


def true_view(placing: TwinCameraProfile = PROFILE.twin.cameras["top"]) -> CameraView:
    """Return the view of a twin's camera as it is."""
    lens = LensModel(
        width_px=1280,
        height_px=960,
        focal_u_px=placing.focal_px,
        focal_v_px=placing.focal_px,
        centre_u_px=placing.centre_px[0],
        centre_v_px=placing.centre_px[1],
        k1=placing.k1,
        k2=placing.k2,
    )
    return CameraView(lens, Transform.from_pose(Pose(*placing.position_mm, *placing.rotation_deg)))


def lit_profile(level: float, profile: Profile = PROFILE) -> Profile:
    """Return a profile whose twin has lamps of another level."""
    light = TwinLightProfile(level=level)
    return profile.model_copy(update={"twin": profile.twin.model_copy(update={"light": light})})


def outline_mm(laid: Laid, grown_mm: float = 0.0) -> NDArray[np.float32]:
    """Return the corners of a block's top, (n, 2)."""
    size = PROFILE.blocks[laid.kind]
    length, width = size.length_mm + grown_mm, size.width_mm + grown_mm
    if size.shape == "cylinder":
        turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        local = length / 2.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    else:
        local = np.array([(-length, -width), (length, -width), (length, width), (-length, width)])
        local = local / 2.0
    angle = math.radians(laid.yaw_deg)
    cos, sin = math.cos(angle), math.sin(angle)
    turned = local @ np.array([[cos, sin], [-sin, cos]]) + (laid.x_mm, laid.y_mm)
    return np.asarray(turned, np.float32)


def random_layout(
    generator: np.random.Generator, *, most: int = 12, touching: float = 0.35
) -> list[Laid]:
    """Return 1 to `most` blocks that do not overlap, some of them side by side."""
    count = int(generator.integers(1, most + 1))
    out: list[Laid] = []
    while len(out) < count:
        is_beside = bool(out) and generator.random() < touching
        new = _beside(generator, out) if is_beside else _anywhere(generator)
        # Wholly in the picture, which ends at y = -375 mm.
        if not (290.0 < new.x_mm < 710.0 and -325.0 < new.y_mm < 310.0):
            continue
        grown = outline_mm(new, -0.02 if is_beside else 2.0)
        if all(cv2.intersectConvexConvex(grown, outline_mm(one))[0] < 0.5 for one in out):
            out.append(new)
    return out


def _anywhere(generator: np.random.Generator) -> Laid:
    return Laid(
        KINDS[generator.integers(3)],
        COLOURS[generator.integers(5)],
        generator.uniform(300.0, 700.0),
        generator.uniform(-320.0, 300.0),
        generator.uniform(-180.0, 180.0),
    )


def _beside(generator: np.random.Generator, out: list[Laid]) -> Laid:
    """Return a block with a side on a side of one that lies, often of its colour."""
    other = out[generator.integers(len(out))]
    kind, colour = KINDS[generator.integers(3)], COLOURS[generator.integers(5)]
    if generator.random() < 0.4:
        colour = other.colour
    own, its = PROFILE.blocks[kind], PROFILE.blocks[other.kind]
    if kind == "cylinder" and other.kind == "cylinder":
        turn = generator.uniform(0.0, 2.0 * math.pi)
        dx, dy = 33.01 * math.cos(turn), 33.01 * math.sin(turn)
        return Laid(kind, colour, other.x_mm + dx, other.y_mm + dy, other.yaw_deg)
    side = int(generator.integers(4))
    sign = 1.0 if side % 2 else -1.0
    slide = generator.uniform(-0.9, 0.9)
    length = (own.length_mm + its.length_mm) / 2.0
    width = (own.width_mm + its.width_mm) / 2.0
    along, across = (
        (sign * (length + 0.01), slide * width)
        if side < 2
        else (slide * length, sign * (width + 0.01))
    )
    turn = math.radians(other.yaw_deg)
    return Laid(
        kind,
        colour,
        other.x_mm + along * math.cos(turn) - across * math.sin(turn),
        other.y_mm + along * math.sin(turn) + across * math.cos(turn),
        other.yaw_deg,
    )


def judge(tally: Tally, laid: list[Laid], recognition: Recognition, where: str) -> None:
    """Add one layout to a tally."""
    free = list(recognition.blocks)
    tally.laid += len(laid)
    for one in laid:
        found = min(
            free, key=lambda f: math.hypot(f.x_mm - one.x_mm, f.y_mm - one.y_mm), default=None
        )
        distance = (
            math.inf if found is None else math.hypot(found.x_mm - one.x_mm, found.y_mm - one.y_mm)
        )
        if found is None or distance > _SAME_MM:
            tally.wrong.append(f"{where}: {one} was not found")
            continue
        free.remove(found)
        is_right = (found.kind, found.colour) == (one.kind, one.colour)
        tally.confidences.append((found.confidence, is_right))
        if not is_right:
            tally.wrong.append(f"{where}: {one} taken for a {found.colour} {found.kind}")
            continue
        tally.right += 1
        tally.off_mm.append(distance)
        tally.stated_mm.append(found.deviation_mm)
        period = _SYMMETRY_DEG.get(one.kind)
        if period is not None:
            off = (found.angle_deg - one.yaw_deg + period / 2.0) % period - period / 2.0
            tally.off_deg.append(off)
            tally.stated_deg.append(found.deviation_deg)
    for found in free:
        tally.confidences.append((found.confidence, False))
        tally.false.append(
            f"{where}: {found.colour} {found.kind} at {found.x_mm:.0f}, {found.y_mm:.0f}"
        )


def run_layouts(count: int, seed: int, *, sight: TableSight | None = None) -> dict[str, Tally]:
    """Return the tallies, by `one picture` and `two pictures`, of random layouts.

    Backgrounds and lights take turns; every layout's seed is in the text of what was wrong.
    """
    sight = sight or TableSight.of_profile(PROFILE, "top", true_view())
    tallies = {"one picture": Tally(), "two pictures": Tally()}
    for number, level in enumerate(LIGHTS):
        stage = Stage()
        camera = stage.camera("top", profile=lit_profile(level))
        for index in range(count // len(LIGHTS)):
            generator = np.random.default_rng([seed, number, index])
            laid = random_layout(generator)
            stage.put(*(scene_block(one) for one in laid))
            background = BACKGROUNDS[index % len(BACKGROUNDS)]
            where = f"seed {seed}, light {level}, layout {index} on {background}"
            pictures = {
                name: _shown(stage, camera, name) for name in {background, "black", "white"}
            }
            one = recognise(OnePicture(pictures[background]), sight)
            judge(tallies["one picture"], laid, one, where)
            two = recognise(TwoPictures(pictures["white"], pictures["black"]), sight)
            judge(tallies["two pictures"], laid, two, where)
    return tallies


def _shown(stage: Stage, camera: TwinCamera, name: str) -> NDArray[np.uint8]:
    stage.show(name)
    return camera.grab().pixels


def scene_block(one: Laid) -> SceneBlock:
    """Return a block as the scene takes it."""
    return block(one.kind, one.colour, one.x_mm, one.y_mm, yaw_deg=one.yaw_deg)
