"""1,000 random layouts of up to 12 blocks: what share is told right, how exact, how honest.

Right means: found within 10 mm with its own kind and colour; a block reported as unknown is
not right. Set `ROBOCELL_LAYOUTS` to run fewer.
"""

from __future__ import annotations

import os
import sys

import numpy as np

from benchmarks.measure import Result
from tests.cell.vision.layouts import run_layouts

_COUNT = 1000
_SEED = 4
_LEAST_SHARE = {"one picture": 98.0, "two pictures": 99.5}


def run() -> list[Result]:
    """Recognise every layout with one picture and with two."""
    count = int(os.environ.get("ROBOCELL_LAYOUTS", _COUNT))
    results = []
    for method, tally in run_layouts(count, _SEED).items():
        for text in (*tally.wrong, *tally.false):
            print(f"{method}: {text}", file=sys.stderr)
        confidence = 100.0 * float(np.mean([said for said, _ in tally.confidences]))
        right = 100.0 * float(np.mean([is_right for _, is_right in tally.confidences]))
        results += [
            Result(
                name=f"{method}: right of {tally.laid}",
                value=100.0 * tally.share,
                unit="%",
                target=_LEAST_SHARE[method],
                target_is="at least",
            ),
            Result(name=f"{method}: false blocks", value=len(tally.false), unit="", target=0),
            Result(name=f"{method}: centre rms", value=tally.rms_mm, unit="mm", target=0.6),
            Result(name=f"{method}: angle rms", value=tally.rms_deg, unit="deg", target=1.0),
            Result(
                name=f"{method}: stated confidence",
                value=confidence,
                unit="%",
                peer="share right of those found",
                peer_value=right,
            ),
        ]
    return results
