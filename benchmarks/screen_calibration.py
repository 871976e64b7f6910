"""Calibration by the screen: accuracy on cells of hidden truth, and the time to solve.

Statistical: places of the screen and block centres are projected through each cell's truth
and get 0.5 px of noise; blocks lie 0.3 mm off. The whole chain on rendered pictures runs in
the tests, on fewer cells.
"""

from __future__ import annotations

import os
import statistics
import time

import numpy as np

from benchmarks.measure import Result
from calibration.playground import playground_grid
from calibration.screen.joint_fit import fit_screen
from calibration.statistics import chi_square_quantile
from cell.profile import load_profile
from tests.calibration.screen.synthetic import TOP_MM, synthetic_cell

_CELLS = int(os.environ.get("ROBOCELL_SCREEN_CELLS", "200"))


def run() -> list[Result]:
    """Return block centre errors, with and without placed blocks, coverage and time."""
    profile = load_profile("mash")
    errors: dict[str, list[float]] = {"top": [], "oblique": []}
    times, held, predicted = [], [], []
    for seed in range(_CELLS):
        cell = synthetic_cell(profile, seed)
        began = time.perf_counter()
        found = fit_screen(cell.given)
        times.append(time.perf_counter() - began)
        for name, some in errors.items():
            some.append(float(np.mean(np.sum(cell.errors_mm(found, name) ** 2, axis=1))))
        off = cell.errors_mm(found, "top")
        covariance = found.covariance_at("top", playground_grid(), TOP_MM)
        distance = np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariance), off)
        held.append(float(np.mean(distance < chi_square_quantile(0.95, 2))))
        predicted.append(float(np.trace(covariance, axis1=1, axis2=2).mean()))
    results = [
        Result(
            name=f"{name}: block centres of {_CELLS} cells, RMS",
            value=float(np.sqrt(np.mean(some))),
            unit="mm",
            target=0.4,
        )
        for name, some in errors.items()
    ]
    return [
        *results,
        Result(
            name="top: worst cell, RMS", value=float(np.sqrt(max(errors["top"]))), unit="mm"
        ),
        Result(
            name="top: predicted by the covariance, RMS",
            value=float(np.sqrt(np.mean(predicted))),
            unit="mm",
        ),
        Result(
            name="top: stated 95 % regions that hold", value=100 * float(np.mean(held)), unit="%"
        ),
        Result(
            name="solve, two cameras, 7,400 places", value=statistics.median(times), unit="s",
            target=2.0,
        ),
    ]  # fmt: skip
