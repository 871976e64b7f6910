"""Fits the coefficients of `cell.vision.confidence` and tells how well they are calibrated.

Layouts of the twin, easy and hard: noise, blur, views that are off, things that hide a part.
Every face that was laid on its edges is a sample, whether or not it would be accepted; it is
right when a block of its kind lies within 5 mm. The odd layouts fit, the even ones judge.

`python -m benchmarks.recognition_confidence` prints the fitted coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Result
from cell.vision.confidence import confidence_of, features_of
from cell.vision.face_fit import FittedFace
from cell.vision.recognition import OnePicture, fitted_faces
from cell.vision.sight import TableSight
from tests.cell.twin.cameras.stage import PROFILE, Stage
from tests.cell.vision.layouts import (
    BACKGROUNDS,
    Laid,
    lit_profile,
    random_layout,
    scene_block,
    true_view,
)

_SEED = 17
_LAYOUTS = 120
_SAME_MM = 5.0
_LEAST_DEVIATION = 0.3
"""Prior deviation of the standardised coefficients' data: keeps a separable fit finite."""
_ROUNDS = 50


def run() -> list[Result]:
    """Compare the Brier score of stated confidences with that of the share that was right."""
    samples = [one for index in range(0, _LAYOUTS, 2) for one in hard_samples(index)]
    said = np.array([confidence_of(face, is_group=group) for face, group, _ in samples])
    right = np.array([is_right for _, _, is_right in samples], np.float64)
    brier = float(np.mean(np.square(said - right)))
    base = float(right.mean() * (1.0 - right.mean()))
    return [
        Result(
            name=f"Brier score of the confidence of {len(samples)} faces",
            value=brier,
            unit="",
            peer="always the share that is right",
            peer_value=base,
            target=0.5,
            of="ratio",
        ),
        Result(
            name="largest gap of stated and true share in five bins",
            value=largest_gap(said, right),
            unit="",
            target=0.1,
        ),
    ]


def largest_gap(said: NDArray[np.float64], right: NDArray[np.float64]) -> float:
    """Return by how much mean confidence and share right differ at most, in bins of 20 or more."""
    gaps = [0.0]
    for low in np.arange(0.0, 1.0, 0.2):
        chosen = (said >= low) & (said < low + 0.2 + 1e-9)
        if chosen.sum() >= 20:
            gaps.append(abs(float(said[chosen].mean() - right[chosen].mean())))
    return max(gaps)


def fit() -> NDArray[np.float64]:
    """Return base and coefficients of a logistic regression on the odd layouts."""
    samples = [one for index in range(1, _LAYOUTS, 2) for one in hard_samples(index)]
    features = np.array([features_of(face, is_group=group) for face, group, _ in samples])
    right = np.array([is_right for _, _, is_right in samples], np.float64)
    design = np.concatenate([np.ones((len(features), 1)), features], axis=1)
    beta = np.zeros(design.shape[1])
    prior = np.full(len(beta), _LEAST_DEVIATION)
    prior[0] = 1e-6
    scale = np.maximum(design.std(axis=0), 1e-6)
    prior = prior * scale**2
    for _ in range(_ROUNDS):
        share = 1.0 / (1.0 + np.exp(-np.clip(design @ beta, -30.0, 30.0)))
        slope = design.T @ (right - share) - prior * beta
        bend = (design * (share * (1.0 - share))[:, None]).T @ design + np.diag(prior + 1e-9)
        beta = beta + np.linalg.solve(bend, slope)
    return beta


def hard_samples(index: int) -> Iterator[tuple[FittedFace, bool, bool]]:
    """Yield the faces of one layout, whether each is of a group, and whether it is right."""
    generator = np.random.default_rng([_SEED, index])
    laid = random_layout(generator, touching=0.6)
    stage = Stage().put(*(scene_block(one) for one in laid))
    camera = stage.camera("top", profile=lit_profile(generator.uniform(0.7, 1.3)))
    stage.show(BACKGROUNDS[index % len(BACKGROUNDS)])
    picture = _harder(camera.grab().pixels, generator, laid)
    sight = TableSight.of_profile(PROFILE, "top", true_view())
    for face, is_group in fitted_faces(OnePicture(picture), sight):
        is_right = any(
            one.kind == face.shape.kind
            and math.hypot(one.x_mm - face.x_mm, one.y_mm - face.y_mm) < _SAME_MM
            for one in laid
        )
        yield face, is_group, is_right


def _harder(
    picture: NDArray[np.uint8], generator: np.random.Generator, laid: list[Laid]
) -> NDArray[np.uint8]:
    """Return the picture with noise, blur and strips of other colour over some blocks."""
    level = generator.choice([0.0, 2.0, 5.0])
    out = cv2.GaussianBlur(picture, (0, 0), float(generator.choice([0.3, 1.2, 2.2])))
    view = true_view()
    for one in laid:
        if generator.random() < 0.5:
            continue
        u, v = view.to_picture(np.array([[one.x_mm, one.y_mm]]), 71.5)[0]
        turn, side = generator.uniform(0, math.pi), generator.uniform(12.0, 34.0)
        shift = side * np.array([math.cos(turn), math.sin(turn)])
        start = np.array([u, v]) + shift + 90.0 * np.array([-shift[1], shift[0]]) / side
        end = 2.0 * (np.array([u, v]) + shift) - start
        paint = generator.uniform(20.0, 220.0, 3).tolist()
        ends = [(round(float(p[0])), round(float(p[1]))) for p in (start, end)]
        cv2.line(out, ends[0], ends[1], paint, int(generator.integers(3, 14)))
    noisy = np.asarray(out, np.float64) + generator.normal(0.0, 1.0, picture.shape) * level
    return np.asarray(np.clip(np.rint(noisy), 0, 255), np.uint8)


if __name__ == "__main__":
    for value in fit().tolist():
        print(f"{value:.2f}")
    for result in run():
        print(result)
