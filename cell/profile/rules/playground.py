"""The playground: heights, fingers and blocks must fit each other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from cell.profile.cell import Profile
from cell.profile.rules.problem import PlaygroundRule, Problem

GRIP_PLAY_MM: Final = 2.0
"""Least room on both sides of a block together when the fingers come down over it (ours)."""


def _outputs(profile: Profile) -> Iterator[Problem]:
    """No two outputs have the same bit."""
    taken: dict[int, str] = {}
    for name in ("lights", "gripper_power", "magnet"):
        bit = {
            "lights": profile.outputs.lights,
            "gripper_power": profile.outputs.gripper_power,
            "magnet": profile.outputs.magnet,
        }[name]
        first = taken.setdefault(bit, name)
        if first != name:
            yield Problem(
                ("outputs", name),
                f"output {bit} switches both {first} and {name}",
                "give each its own bit, as it is wired",
                other=("outputs", first),
            )


def _heights(profile: Profile) -> Iterator[Problem]:
    """The laying height is above the surface, the service height above the laying height."""
    heights = profile.heights
    if heights.laying_mm <= heights.surface_mm:
        yield Problem(
            ("heights", "laying_mm"),
            f"blocks are laid down at {heights.laying_mm:g} mm, and the surface is at "
            f"{heights.surface_mm:g} mm: the laying height must be above it",
            other=("heights", "surface_mm"),
        )
    elif heights.service_mm <= heights.laying_mm:
        yield Problem(
            ("heights", "service_mm"),
            f"the arm travels at {heights.service_mm:g} mm and lays blocks down at "
            f"{heights.laying_mm:g} mm: the service height must be above the laying height",
            other=("heights", "laying_mm"),
        )


def _fingertips(profile: Profile) -> Iterator[Problem]:
    """At the laying height the fingertips do not touch the surface."""
    heights, gripper = profile.heights, profile.gripper
    tips_mm = heights.laying_mm - gripper.tip_below_tool_mm
    if heights.surface_mm < heights.laying_mm and tips_mm <= heights.surface_mm:
        yield Problem(
            ("heights", "laying_mm"),
            f"at the laying height of {heights.laying_mm:g} mm the fingertips are at "
            f"{tips_mm:g} mm, and the surface is at {heights.surface_mm:g} mm: they would touch it",
            f"lay blocks down above {heights.surface_mm + gripper.tip_below_tool_mm:g} mm",
            other=("gripper", "tip_below_tool_mm"),
        )


def _block_heights(profile: Profile) -> Iterator[Problem]:
    """At the laying height the fingertips reach every kind of block."""
    heights, gripper = profile.heights, profile.gripper
    tips_mm = heights.laying_mm - gripper.tip_below_tool_mm
    for kind, block in profile.blocks.items():
        top_mm = heights.surface_mm + block.height_mm
        if tips_mm >= top_mm:
            yield Problem(
                ("blocks", kind, "height_mm"),
                f"a {kind} ends at {top_mm:g} mm, and the fingertips at the laying height are at "
                f"{tips_mm:g} mm: they would close above it",
                other=("heights", "laying_mm"),
            )


def _carried_blocks(profile: Profile) -> Iterator[Problem]:
    """At the service height a carried block passes over the highest other."""
    heights = profile.heights
    if heights.service_mm <= heights.laying_mm or not profile.blocks:
        return
    kind, block = max(profile.blocks.items(), key=lambda entry: entry[1].height_mm)
    top_mm = heights.surface_mm + block.height_mm
    carried_mm = heights.service_mm - (heights.laying_mm - heights.surface_mm)
    if carried_mm <= top_mm:
        yield Problem(
            ("heights", "service_mm"),
            f"at {heights.service_mm:g} mm the bottom of a carried block is at {carried_mm:g} mm, "
            f"and a {kind} on the table ends at {top_mm:g} mm: they would collide",
            other=("blocks", kind, "height_mm"),
        )


def _block_sizes(profile: Profile) -> Iterator[Problem]:
    """Every block fits between the open fingers, with 2 mm to spare."""
    for kind, block in profile.blocks.items():
        at = ("blocks", kind)
        if block.width_mm + GRIP_PLAY_MM > profile.gripper.open_mm:
            yield Problem(
                (*at, "width_mm"),
                f"a {kind} is {block.width_mm:g} mm wide, and the fingers open to "
                f"{profile.gripper.open_mm:g} mm: they need {GRIP_PLAY_MM:g} mm more than it",
                other=("gripper", "open_mm"),
            )


def _block_shapes(profile: Profile) -> Iterator[Problem]:
    """There is a kind of block; a cylinder is as long as wide; an arch fits into its block."""
    if not profile.blocks:
        yield Problem(("blocks",), "no kind of block is given; a cell with a playground has some")
    for kind, block in profile.blocks.items():
        at = ("blocks", kind)
        if block.shape == "cylinder" and block.length_mm != block.width_mm:
            yield Problem(
                (*at, "length_mm"),
                f"a {kind} is a cylinder {block.length_mm:g} mm long and {block.width_mm:g} mm "
                "wide: both must be its diameter",
                other=(*at, "width_mm"),
            )
        if block.arch_radius_mm > min(block.height_mm, block.length_mm / 2):
            yield Problem(
                (*at, "arch_radius_mm"),
                f"the opening of a {kind} has a radius of {block.arch_radius_mm:g} mm; "
                f"{min(block.height_mm, block.length_mm / 2):g} mm at most fits into it",
            )


def _fingers(profile: Profile) -> Iterator[Problem]:
    """The fingers do not open further than their stroke."""
    gripper = profile.gripper
    if gripper.open_mm > gripper.stroke_mm:
        yield Problem(
            ("gripper", "open_mm"),
            f"the fingers shall open to {gripper.open_mm:g} mm; their stroke of "
            f"{gripper.stroke_mm:g} mm is the most",
            other=("gripper", "stroke_mm"),
        )


def _calibration_object(profile: Profile) -> Iterator[Problem]:
    """The calibration object is of a kind of block that the profile knows."""
    known = profile.store.calibration
    if known is not None and known.kind not in profile.blocks:
        yield Problem(
            ("store", "calibration", "kind"),
            f"the calibration object is a {known.kind}, and no such block is given",
            f"use {', '.join(profile.blocks)}",
        )


PLAYGROUND_RULES = (
    PlaygroundRule(("store", "blocks"), _calibration_object),
    PlaygroundRule(("outputs",), _outputs),
    PlaygroundRule(("heights",), _heights),
    PlaygroundRule(("heights", "gripper"), _fingertips),
    PlaygroundRule(("heights", "gripper", "blocks"), _block_heights),
    PlaygroundRule(("heights", "blocks"), _carried_blocks),
    PlaygroundRule(("gripper", "blocks"), _block_sizes),
    PlaygroundRule(("blocks",), _block_shapes),
    PlaygroundRule(("gripper",), _fingers),
)
