"""Pictures of grey patterns take a shorter way; what comes out is the same."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cell.twin.scene import Scene
from tests.cell.twin.cameras.stage import Stage


@dataclass
class PatternStage(Stage):
    """A stage whose screen shows any pixels."""

    pixels: NDArray[np.uint8] | None = None

    def __call__(self) -> Scene:
        return replace(super().__call__(), pixels=self.pixels)

    def show_pixels(self, name: str, pixels: NDArray[np.uint8]) -> None:
        self.revision += 1
        self.picture, self.pixels = name, pixels


def test_a_grey_pattern_looks_as_any_picture_does() -> None:
    levels = np.random.default_rng(1).integers(0, 256, (27, 48), dtype=np.uint8)
    grey = np.repeat(levels.repeat(40, axis=0).repeat(40, axis=1)[..., None], 3, axis=2)
    coloured = grey.copy()
    coloured[0, 0, 0] ^= 1  # no longer grey, too little to be seen
    for name in ("top", "oblique"):
        seen = []
        for pixels in (grey, coloured):
            stage = PatternStage()
            camera = stage.camera(name)
            stage.show_pixels(f"pattern {pixels[0, 0, 0]}", pixels)
            seen.append(camera.grab().pixels.astype(int))
        difference = np.abs(seen[0] - seen[1])
        assert difference.max() <= 1, name
        assert (difference != 0).mean() < 1e-4, name
