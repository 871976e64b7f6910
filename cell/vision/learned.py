"""The looks of the blocks as the profile has them: learned ones, else the reference's tables."""

from __future__ import annotations

from collections.abc import Sequence

from cell.profile import Profile, RecognitionProfile
from cell.vision.colour_model import ColourClass, ColourModel
from cell.vision.recognition import RecognitionModel, reference_model
from cell.vision.tables import KINDS, KindRange, Range, symmetry_deg


def recognition_model(profile: Profile, camera: str) -> RecognitionModel:
    """Return what a camera's pictures are recognised by."""
    learned = profile.recognition
    if learned is None or learned.camera != camera:
        return reference_model()
    return RecognitionModel(colours=colour_model(learned))


def colour_model(learned: RecognitionProfile) -> ColourModel:
    """Return learned colours."""
    return ColourModel(
        classes=tuple(
            ColourClass(colour=name, mean=one.mean, covariance=one.covariance)
            for name, one in learned.colours.items()
        ),
        most_distance=learned.most_distance,
        origin=learned.origin,
    )


def kind_ranges(profile: Profile, camera: str) -> Sequence[KindRange]:
    """Return what the kinds are told by in the white-minus-black method."""
    learned = profile.recognition
    if learned is None or learned.camera != camera or not learned.kinds:
        return KINDS
    return tuple(
        KindRange(
            kind=name,
            area_px=Range(*one.area_px),
            circularity=Range(*one.circularity),
            symmetry_deg=symmetry_deg(name),
        )
        for name, one in learned.kinds.items()
    )
