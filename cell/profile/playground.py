"""The playground: lattice, store, heights, blocks, and the boxes that no arm may enter."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table


class LatticeProfile(Table):
    """Where the lattice lies in the robot frame."""

    step_mm: Positive = 20.0
    angle_deg: float = 90.0
    origin_mm: tuple[float, float] = (710.0, -265.0)


class StoreProfile(Table):
    """Where the store plan lies: plan x along `angle_deg`, plan y to its right."""

    corner_mm: tuple[float, float]
    angle_deg: float = 0.0


class HeightsProfile(Table):
    """Heights of the tool point above the robot's base plane."""

    surface_mm: float
    """Height of the glass and of the store's sheet."""
    service_mm: float = 200.0
    laying_mm: float = 55.0


class BlockProfile(Table):
    """Size of one kind of block; the fingers close across `width_mm`."""

    shape: Literal["box", "cylinder"]
    length_mm: Positive
    width_mm: Positive
    height_mm: Positive
    arch_radius_mm: Annotated[float, Field(ge=0)] = 0.0
    """Radius of a round opening along the width, at the middle of the bottom; 0 for none."""


class BoxProfile(Table):
    """A box that no part of the arm may enter, in the robot frame."""

    name: str
    min_mm: tuple[float, float, float]
    max_mm: tuple[float, float, float]


class ManipulationProfile(Table):
    """Whether the arm moves blocks; without it people lay them out by hand."""

    enabled: bool = True
