"""What is to be said about learned looks of blocks, each thing by its name."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

from calibration.errors import FitFailed
from calibration.recognition.fitting import Tried, fit_colours, nearest_pairs
from calibration.recognition.samples import BlockSample
from calibration.verdict import Finding, Grade
from cell.profile import LearnedKindProfile
from cell.store import StoreSlot
from cell.vision.colour_model import ColourModel

_LEAST_SAMPLES, _LEAST_BLOCKS = 4, 2
_SAFE_MARGIN, _LEAST_MARGIN = 3.0, 1.5
_LEAST_RIGHT = 0.9


def sample_findings(
    samples: Sequence[BlockSample], missing: Sequence[StoreSlot]
) -> Iterator[Finding]:
    """Yield what is wrong with the samples, whatever is fitted to them."""
    lost = sorted({slot.number for slot in missing})
    if lost:
        yield Finding(
            code="block-not-seen",
            grade=Grade.DEGRADED,
            text=f"blocks of the slots {_list(lost)} were not seen where they were put",
            hint="see that they lie on the lit screen and touch nothing; calibrate the camera's "
            "place first if many are missing",
        )
    clipped = sorted({s.slot for s in samples if s.is_clipped})
    if clipped:
        yield Finding(
            code="clipped-blocks",
            grade=Grade.BAD,
            text=f"blocks of the slots {_list(clipped)} are clipped in the picture: their colour "
            "is not known",
            hint="set the camera first: `cell calibrate camera-settings`",
        )
    for colour in sorted({s.colour for s in samples}):
        own = [s for s in samples if s.colour == colour]
        blocks = len({s.slot for s in own})
        if len(own) < _LEAST_SAMPLES or blocks < _LEAST_BLOCKS:
            yield Finding(
                code="too-few-samples",
                grade=Grade.DEGRADED,
                text=f"{colour} was seen {len(own)} times on {blocks} block(s); at least "
                f"{_LEAST_SAMPLES} times on {_LEAST_BLOCKS} are wanted",
                hint="lay out more blocks of it, or more rounds",
            )


def mixed_up(samples: Sequence[BlockSample]) -> Iterator[Finding]:
    """Yield blocks that look like another colour in every one of their samples."""
    for slot in sorted({s.slot for s in samples}):
        own = [s for s in samples if s.slot == slot]
        rest = [s for s in samples if s.slot != slot]
        try:
            model = fit_colours(rest, "")
        except FitFailed:
            continue
        guesses = {model.classify(s.mean_rgb).colour for s in own}
        seen = next(iter(guesses))
        colours = {s.colour for s in rest}
        if len(guesses) == 1 and seen not in (None, own[0].colour) and own[0].colour in colours:
            yield Finding(
                code="block-mixed-up",
                grade=Grade.BAD,
                text=f"the block of slot {slot} should be {own[0].colour} and looks {seen}",
                hint="put the blocks into their own slots and repeat",
                samples=tuple(s.label for s in own),
            )


def colour_findings(model: ColourModel, tried: Tried) -> Iterator[Finding]:
    """Yield colours that are too near, and blocks that did not come out."""
    for first, second, margin in nearest_pairs(model):
        if margin >= _SAFE_MARGIN:
            break
        yield Finding(
            code="colours-too-near",
            grade=Grade.BAD if margin < _LEAST_MARGIN else Grade.DEGRADED,
            text=f"{first} and {second} lie {margin:.1f} apart (Bhattacharyya): up to "
            f"{50 * math.exp(-margin):.1f} % may be taken for each other",
            hint="set the white balance, use whiter lamps, or use only one of the two",
        )
    if tried.wrong:
        yield Finding(
            code="wrong-when-held-out",
            grade=Grade.BAD,
            text=f"blocks of the slots {_list(sorted(set(tried.wrong)))} get another colour when "
            "they are not learned from",
            hint="see whether they are in their own slots, clean, and lit like the others",
        )
    if tried.count and tried.right < _LEAST_RIGHT * tried.count and not tried.wrong:
        yield Finding(
            code="unsure-when-held-out",
            grade=Grade.DEGRADED,
            text=f"{tried.abstained} of {tried.count} samples get no colour when their block is "
            "not learned from",
            hint="lay out more blocks, at more places",
        )


def kind_findings(kinds: Mapping[str, LearnedKindProfile]) -> Iterator[Finding]:
    """Yield kinds that neither area nor circularity tells apart."""
    for (first, a), (second, b) in combinations(kinds.items(), 2):
        if _overlap(a.area_px, b.area_px) and _overlap(a.circularity, b.circularity):
            yield Finding(
                code="kinds-overlap",
                grade=Grade.BAD,
                text=f"{first} and {second} overlap in area and circularity",
                hint="see that no blocks touch and the pictures are sharp, and repeat",
            )


def _overlap(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return a[0] <= b[1] and b[0] <= a[1]


def _list(numbers: Sequence[int]) -> str:
    return ", ".join(str(number) for number in numbers)
