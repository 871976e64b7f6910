"""The SCARA arm of the avrs cell, behind its slave's dual-port registers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.geometry.eye_in_hand import EyeInHand
from cell.profile.table import NotNegative, Positive, Table
from cell.profile.wires import SerialProfile

Four = tuple[float, float, float, float]


class WorkSpaceProfile(Table):
    """The upright box that the tool point must not leave, in the robot frame."""

    min_mm: tuple[float, float, float]
    max_mm: tuple[float, float, float]


class ServoProfile(Table):
    """The master's servo law: torque = 0x800 + kp·e + kv·(e - e_prev)/period, e in pulses."""

    period_us: Annotated[int, Field(ge=100, le=65535)] = 1000
    """Sample period, as written to the slave's register."""
    kp: Four = (60.0, 60.0, 55.0, 60.0)
    """Torque counts for each pulse of error."""
    kv: Four = (0.1, 0.1, 0.1, 0.1)
    """Torque counts for each pulse a second of error's change."""


class EyeInHandProfile(Table):
    """The camera on link 2: what its pixels measure and where it sits (Bloch 1994, 4.3-4.14)."""

    scale_mm: tuple[Positive, Positive] = (1 / 3.56, 1 / 3.48)
    """Width and height of a pixel on the table (c_x, c_y)."""
    reference_px: tuple[float, float] = (3.0, 457.0)
    """Column and row of the reference pixel (b_x, b_y)."""
    centre_px: tuple[float, float] = (255.0, 241.0)
    """Column and row where the camera looks straight down."""
    camera_height_mm: Positive = 420.0
    """Of the camera over the table."""
    face_height_mm: NotNegative = 8.0
    """Of the parts' upper face over the table."""
    d_t_c_mm: Positive = 81.8
    """From the gripper's axis to the table point under the reference pixel."""
    b_angle_deg: float = 137.7
    """Direction of that way: J1 + J2 + b_angle - 180 in the robot frame."""
    angle_error_deg: float = 1.8
    """Turn of the picture against link 2."""

    def value(self, link_mm: tuple[float, float]) -> EyeInHand:
        """Return the eye in hand of an arm with these links."""
        return EyeInHand(
            scale_u_mm=self.scale_mm[0],
            scale_v_mm=self.scale_mm[1],
            reference_px=self.reference_px,
            centre_px=self.centre_px,
            camera_height_mm=self.camera_height_mm,
            face_height_mm=self.face_height_mm,
            d_t_c_mm=self.d_t_c_mm,
            b_angle_deg=self.b_angle_deg,
            angle_error_deg=self.angle_error_deg,
            link_1_mm=link_mm[0],
            link_2_mm=link_mm[1],
        )


class Ibm7545Profile(Table):
    """An IBM 7545: two turning links, a sliding spindle, a roll."""

    model: Literal["ibm-7545"]
    enabled: bool = True
    """Whether the cell has its arm; without it the cell does what is left."""
    serial: SerialProfile
    """The port of the bridge to the registers."""
    link_mm: tuple[Positive, Positive] = (400.0, 250.0)
    link_height_mm: Positive = 200.0
    """Height of the links' middle over the tool point at the spindle's upper end."""
    link_radius_mm: Positive = 80.0
    """Half the thickness of the links, as the guard sees them."""
    tool_radius_mm: Positive = 45.0
    """Half the thickness of spindle and gripper, as the guard sees them."""
    joint_min: Four
    """Least positions: deg, deg, mm, deg."""
    joint_max: Four
    joint_speed: Four
    """Greatest speeds: deg/s, deg/s, mm/s, deg/s."""
    linear_speed_mm_s: Positive
    max_linear_speed_mm_s: Positive
    joint_speed_percent: Annotated[float, Field(gt=0, le=100)]
    posture: Annotated[int, Field(ge=0, le=1)] = 0
    """0: the elbow bends counter-clockwise, as the arm is built; 1: clockwise."""
    rest: Four
    """Joint positions where the arm stands aside."""
    work_space: WorkSpaceProfile | None = None
    """Where the tool point may be; anywhere in reach without it."""
    servo: ServoProfile = ServoProfile()
    eye_in_hand: EyeInHandProfile | None = None
    """The camera on link 2, if there is one; its calibration sets this and `link_mm`."""

    @property
    def rest_deg(self) -> Four:
        """The rest under the name that other arms' profiles have; the slide's is in mm."""
        return self.rest
