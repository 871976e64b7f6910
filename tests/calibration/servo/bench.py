"""A Lynx whose servos and sag are known, seen through a noisy camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from calibration.servo.chain import MarkerChain
from calibration.servo.samples import BACK, TOP, MarkerNoise, Sight
from cell.geometry import Pose
from cell.kinematics.lynx import LynxGeometry
from cell.kinematics.servo_map import ArmCorrection, Five, SagModel, ServoMap

Array = NDArray[np.float64]
GEOMETRY = LynxGeometry()
NOISE = MarkerNoise()
SAG = SagModel(shoulder_deg=2.2, elbow_deg=1.4, wrist_deg=0.5, hand_share=0.35)
LOW = np.array([-80.0, -60.0, -60.0, -60.0, -110.0])
HIGH = np.array([80.0, 75.0, 90.0, 95.0, 80.0])
HOME = (0.0, 10.0, 20.0, 40.0, 0.0)


def curve(joint: int, x: Array) -> Array:
    """A smooth servo: gain, offset, a bend and a wave."""
    gain = (1.02, 0.97, 1.03, 0.98, 1.01)[joint]
    offset = (1.5, -2.0, 1.0, 2.5, -1.0)[joint]
    wave = (1.2, 1.0, 1.4, 0.8, 1.3)[joint]
    return gain * x + offset + wave * np.sin(np.radians(1.5 * x + 40.0 * joint))


def smooth_truth(points: int = 61) -> ArmCorrection:
    return truth_at([np.linspace(LOW[i], HIGH[i], points) for i in range(5)])


def truth_at(knots: list[Array] | tuple[Array, ...]) -> ArmCorrection:
    """The servos as maps with knots at commanded angles."""
    a, b, c, d, e = (
        ServoMap(tuple(zip(k.tolist(), curve(i, k).tolist(), strict=True)), f"J{i + 1}")
        for i, k in enumerate(knots)
    )
    return ArmCorrection(maps=(a, b, c, d, e), sag=SAG)


def plan(reach_poses: int = 40, steps: int = 9) -> Array:
    """Sweeps of one joint each, the others held, and poses at different reach."""
    rows = []
    for joint in range(5):
        for angle in np.linspace(LOW[joint], HIGH[joint], steps):
            row = np.array(HOME)
            row[joint] = angle
            rows.append(row)
    generator = np.random.default_rng(77)
    rows += list(generator.uniform(LOW, HIGH, (reach_poses, 5)))
    return np.array(rows)


class Camera:
    """Sees markers.

    Args:
        truth: The arm as it is.
        commanded: Commands (n, 5) that it is given.
        noise: How exactly it sees.
    """

    def __init__(self, truth: ArmCorrection, commanded: Array, noise: MarkerNoise = NOISE) -> None:
        self.commanded, self.noise = commanded, noise
        reached = truth.reached_all(commanded)
        self.reached = reached
        downs = reached[:, 1:4].sum(axis=1)
        self.mounts = ["back" if down > 45 else "top" for down in downs]
        frames = {"back": BACK.tool_from_marker, "top": TOP.tool_from_marker}
        chain = MarkerChain(GEOMETRY, [frames[name] for name in self.mounts])
        self.position, self.rotation, _ = chain.places(reached)

    def sights(self, generator: np.random.Generator, factor: float = 1.0) -> list[Sight]:
        noise = self.noise
        tilt = noise.tilt_deg or 1.5
        height = noise.height_mm or 2.0
        count = len(self.commanded)
        off = generator.normal(size=(count, 6)) * factor
        off *= [noise.place_mm, noise.place_mm, height, tilt, tilt, noise.yaw_deg]
        turned = _turns(np.radians(off[:, 3:])) @ self.rotation
        places = self.position + off[:, :3]
        a = np.degrees(np.arctan2(turned[:, 2, 1], turned[:, 2, 2]))
        b = np.degrees(np.arctan2(-turned[:, 2, 0], np.hypot(turned[:, 0, 0], turned[:, 1, 0])))
        c = np.degrees(np.arctan2(turned[:, 1, 0], turned[:, 0, 0]))
        poses = np.column_stack([places, a, b, c]).tolist()
        found = []
        for i, pose in enumerate(poses):
            commanded: Five = tuple(self.commanded[i].tolist())
            found.append(
                Sight(
                    label=f"sight {i + 1}",
                    commanded_deg=commanded,
                    seen=Pose(*pose),
                    mount=self.mounts[i],
                )
            )
        return found


def _turns(vectors: Array) -> Array:
    """Rodrigues' formula, for vectors (n, 3)."""
    angle = np.linalg.norm(vectors, axis=1)
    x, y, z = (vectors / np.maximum(angle, 1e-12)[:, None]).T
    zero = np.zeros_like(x)
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    sine, rest = np.sin(angle)[:, None, None], 1.0 - np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + rest * cross @ cross)
