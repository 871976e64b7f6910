"""An eye in hand whose truth is known, looked through with noise."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from calibration.eye_in_hand.guidance import Reach, gripping_joints, viewing_joints
from calibration.eye_in_hand.judge import Fresh
from calibration.eye_in_hand.samples import LineLook, Look, Samples, Stages, Touch
from calibration.procedure import Procedure
from calibration.record import Measurement
from calibration.requests import Answer, Ask, Request
from cell.geometry.eye_in_hand import EyeInHand

NOMINAL = EyeInHand()
TRUTH = EyeInHand(
    d_t_c_mm=82.4, b_angle_deg=136.9, angle_error_deg=0.7, link_1_mm=400.4, link_2_mm=249.5
)
POINT = (-180.0, 420.0)
REACH = Reach()


class Bench:
    """Takes samples of a true eye in hand.

    Args:
        seed: Of the noise.
        eye: The truth.
        point: Where the looked-at point lies, mm.
    """

    def __init__(
        self, seed: int, eye: EyeInHand = TRUTH, point: tuple[float, float] = POINT
    ) -> None:
        self.generator = np.random.default_rng(seed)
        self.eye, self.point = eye, point

    def joints(self, count: int) -> np.ndarray:
        """Return joints (count, 2) spread over all from which the point is seen."""
        seen = viewing_joints(self.eye, self.point, REACH, step_deg=2.0)
        chosen = [seen[0]]
        while len(chosen) < count:
            away = np.linalg.norm(seen[:, None] - np.array(chosen)[None], axis=2).min(axis=1)
            chosen.append(seen[int(away.argmax())])
        return np.array(chosen)

    def look(self, label: str, joints: np.ndarray, px: float = 0.4) -> Look:
        u, v = self.eye.pixels(np.array(self.point), joints, height_mm=0.0)
        u, v = (u, v) + self.generator.normal(0, px, 2)
        return Look(label=label, u_px=float(u), v_px=float(v), j1_deg=joints[0], j2_deg=joints[1])

    def touch(self, label: str, mm: float = 0.2) -> Touch:
        x, y = self.point + self.generator.normal(0, mm, 2)
        found = gripping_joints(self.eye, (x, y))
        assert found is not None
        return Touch(label=label, j1_deg=found[0], j2_deg=found[1])

    def samples(self, looks: int = 12, touches: int = 2) -> Samples:
        return Samples(
            looks=tuple(
                self.look(f"look {i}", joints) for i, joints in enumerate(self.joints(looks), 1)
            ),
            touches=tuple(self.touch(f"touch {i}") for i in range(1, touches + 1)),
        )

    def stages(
        self, count: int, reference: tuple[float, float] | None = None, mm: float = 0.2
    ) -> list[Stages]:
        pairs = []
        for number in range(1, count + 1):
            seen = np.array([40.0 + 10.0 * number, 110.0 - 5.0 * number])
            point = self.eye.places(
                np.array(reference or self.eye.reference_px), seen, height_mm=0.0
            )
            x, y = point + self.generator.normal(0, mm, 2)
            over = gripping_joints(self.eye, (x, y))
            assert over is not None
            pairs.append(Stages(label=f"pair {number}", seen_deg=(seen[0], seen[1]), over_deg=over))
        return pairs

    def edge(self, label: str, joints: np.ndarray, direction: float, known: bool) -> LineLook:
        alpha = direction - joints.sum() + self.eye.angle_error_deg
        return LineLook(
            label=label,
            alpha_deg=float(alpha + self.generator.normal(0, 0.3)),
            j1_deg=joints[0],
            j2_deg=joints[1],
            direction_deg=direction if known else None,
        )

    def fresh(self, count: int) -> list[Fresh]:
        points = []
        for number in range(count):
            point = (POINT[0] + 30.0 * number, POINT[1] - 20.0 * number)
            other = Bench(int(self.generator.integers(1 << 30)), self.eye, point)
            joints = other.joints(3)[2]
            points.append(
                Fresh(look=other.look(f"fresh {number + 1}", joints), touch=other.touch("t"))
            )
        return points


def play(procedure: Procedure, answers: dict[str, Answer]) -> tuple[Measurement, list[Request]]:
    """Answer a procedure from a table; what the table has not gets its default."""
    asked: list[Request] = []
    stepping: Generator[Request, Answer, Measurement] = procedure
    answer: Answer = None
    while True:
        try:
            request = stepping.send(answer)
        except StopIteration as stop:
            return stop.value, asked
        asked.append(request)
        answer = None
        if isinstance(request, Ask):
            answer = answers.get(request.key, request.default)
