"""The playground: lattice, store, heights, blocks, and the boxes that no arm may enter."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Kind, NotNegative, Positive, Table, Text


class LatticeProfile(Table):
    """Where the lattice lies in the robot frame."""

    step_mm: Positive = 20.0
    """Distance of two neighbouring points."""
    angle_deg: float = 90.0
    """Angle from robot X to lattice x, counter-clockwise."""
    origin_mm: tuple[float, float] = (710.0, -265.0)
    """Robot x and y of the lattice point (0, 0)."""


class CalibrationObjectProfile(Table):
    """The block that calibrations are made with; it has its own slot, and no task may take it."""

    number: Annotated[int, Field(ge=1)]
    """Number of its slot."""
    kind: Kind
    """Its kind, one of `blocks`; a cylinder, whose centre does not depend on how it is turned."""
    colour: Text
    """Its colour."""
    place_mm: tuple[float, float]
    """Where its slot lies on the store plan: to the right and down from the corner."""


class StoreProfile(Table):
    """Where the store plan lies: plan x along `angle_deg`, plan y to its right."""

    corner_mm: tuple[float, float]
    """Robot x and y of the plan's upper left corner."""
    angle_deg: float = 0.0
    """Angle from robot X to plan x, counter-clockwise."""
    calibration: CalibrationObjectProfile | None = None
    """The calibration object, if the store has one."""


class HeightsProfile(Table):
    """Heights of the tool point above the robot's base plane."""

    surface_mm: float
    """Height of the glass and of the store's sheet."""
    service_mm: float = 200.0
    """Height at which the arm travels from place to place."""
    laying_mm: float = 55.0
    """Height at which blocks are gripped and released."""


class BlockProfile(Table):
    """Size of one kind of block; the fingers close across `width_mm`."""

    shape: Literal["box", "cylinder"]
    """Its shape seen from above."""
    length_mm: Positive
    """Size across the closing direction of the fingers."""
    width_mm: Positive
    """Size along the closing direction of the fingers."""
    height_mm: Positive
    """Size upwards."""
    arch_radius_mm: NotNegative = 0.0
    """Radius of a round opening along the width, at the middle of the bottom; 0 for none."""


class BoxProfile(Table):
    """A box that no part of the arm may enter, in the robot frame."""

    name: Text
    """What the box stands for; refusals name it."""
    min_mm: tuple[float, float, float]
    """Its corner with the least x, y and z."""
    max_mm: tuple[float, float, float]
    """Its corner with the greatest x, y and z."""


class ManipulationProfile(Table):
    """Whether the arm moves blocks; without it people lay them out by hand."""

    enabled: bool = True
    """Whether the arm moves blocks."""
