"""Where the twin's Lynx really stands: its shafts, and how its weight bends it.

A servo holds against a torque with a spring's stiffness: far out the arm sags. The model is
the static one: for J2, J3 and J4 the torque of all that hangs beyond the joint, about the
joint's axis, turns it down by its compliance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cell.geometry import JointPositions, Pose
from cell.kinematics.lynx import LynxArm
from cell.profile.lynx import LynxProfile
from cell.twin.emulators.ssc32.servos import ServoBank

_GRAVITY_N_G = 9.81e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Sag:
    """How heavy the arm is and how it gives in; masses and compliance are assumed.

    Attributes:
        upper_arm_g: Mass of the upper arm with the elbow's servo, at its middle.
        forearm_g: Mass of the forearm with the wrist's servo, at its middle.
        hand_g: Mass of hand and fingers, halfway from wrist to tool point.
        load_g: Mass of what is held, at the tool point.
        compliance_deg_n_mm: How far J2, J3 and J4 give in to a torque, in deg for 1 N mm.
    """

    upper_arm_g: float = 120.0
    forearm_g: float = 110.0
    hand_g: float = 90.0
    load_g: float = 0.0
    compliance_deg_n_mm: tuple[float, float, float] = (0.004, 0.004, 0.006)

    @staticmethod
    def none() -> Sag:
        """Return the knob turned off."""
        return Sag(compliance_deg_n_mm=(0.0, 0.0, 0.0))


class LynxMechanics:
    """The arm's truth, which only tests and the twin's world may read.

    Args:
        profile: Which channel drives which joint.
        bank: The servos.
        kinematics: The arm's geometry.
        sag: How it gives in to its weight.
    """

    def __init__(
        self, profile: LynxProfile, bank: ServoBank, kinematics: LynxArm, sag: Sag | None = None
    ) -> None:
        self._joints = tuple(bank.servos[servo.channel] for servo in profile.servos)
        self._fingers = bank.servos[profile.fingers.servo.channel]
        self._kinematics = kinematics
        self.sag = Sag() if sag is None else sag
        self.held_mm: float | None = None
        """Width of what stands between the fingers, None for nothing."""

    def joints(self, now_s: float) -> JointPositions:
        """Return where the joints really stand, in degrees."""
        shafts = tuple(servo.truth(now_s) for servo in self._joints)
        return JointPositions(_sagged(shafts, self._kinematics, self.sag))

    def pose(self, now_s: float) -> Pose:
        """Return where the tool point really is."""
        return self._kinematics.forward(self.joints(now_s))

    def opening_mm(self, now_s: float) -> float:
        """Return the opening really between the fingers."""
        wanted_mm = max(self._fingers.truth(now_s), 0.0)
        return wanted_mm if self.held_mm is None else max(wanted_mm, self.held_mm)

    def squeeze_mm(self, now_s: float) -> float:
        """Return how much further the fingers would close but for what holds them."""
        return self.opening_mm(now_s) - self._fingers.truth(now_s)


def _sagged(values: tuple[float, ...], arm: LynxArm, sag: Sag) -> tuple[float, ...]:
    """Return joint angles with the weight on them; torques are those of the shafts' stance."""
    points = arm.link_points_mm((0.0, *values[1:]))
    _, shoulder, elbow, wrist, tool = (point[0] for point in points)
    weights = (
        (0, sag.upper_arm_g, 0.5 * (shoulder + elbow)),
        (1, sag.forearm_g, 0.5 * (elbow + wrist)),
        (2, sag.hand_g, 0.5 * (wrist + tool)),
        (2, sag.load_g, tool),
    )
    bent = list(values)
    for index, pivot in enumerate((shoulder, elbow, wrist)):
        torque_n_mm = math.fsum(
            mass_g * _GRAVITY_N_G * (at_mm - pivot)
            for beyond, mass_g, at_mm in weights
            if beyond >= index
        )
        bent[index + 1] += sag.compliance_deg_n_mm[index] * torque_n_mm
    return tuple(bent)
