"""Figures: solids at their places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.twin.cameras.shapes import Colour, Solid

Matrix = NDArray[np.float64]
"""Shape (3, 3)."""

Point = NDArray[np.float64]
"""Shape (3,), millimetres."""


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """A solid at its place.

    Attributes:
        solid: The template.
        rotation: Robot-from-template rotation.
        place_mm: Where the template's origin is in the robot frame.
        colour: Reflectance.
        gloss: Share of the mirror's law that the surface obeys.
        takes_glare: Whether its top face gives way to the glare of a lit screen.
    """

    solid: Solid
    rotation: Matrix
    place_mm: Point
    colour: Colour
    gloss: float
    takes_glare: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """The geometry of several figures in the robot frame, joined.

    Attributes:
        corners_mm: All corners, (n, 3).
        inset: Where glare moves them, (n, 3).
        normals: Normals of all faces, (m, 3).
        centres_mm: Centres of all faces, (m, 3).
        corner_counts: Number of corners of each figure.
        face_counts: Number of faces of each figure.
    """

    corners_mm: NDArray[np.float64]
    inset: NDArray[np.float64]
    normals: NDArray[np.float64]
    centres_mm: NDArray[np.float64]
    corner_counts: list[int]
    face_counts: list[int]


def place_all(figures: list[Figure]) -> Placed:
    """Return the joined geometry of figures, in their order."""
    rotations = np.array([figure.rotation for figure in figures])
    places = np.array([figure.place_mm for figure in figures])
    corner_counts = [len(figure.solid.vertices_mm) for figure in figures]
    face_counts = [len(figure.solid.normals) for figure in figures]
    of_corner = np.repeat(np.arange(len(figures)), corner_counts)
    of_face = np.repeat(np.arange(len(figures)), face_counts)
    corners = np.concatenate([figure.solid.vertices_mm for figure in figures])
    inset = np.concatenate([figure.solid.inset for figure in figures])
    normals = np.concatenate([figure.solid.normals for figure in figures])
    centres = np.concatenate([figure.solid.centres_mm for figure in figures])
    by_corner, by_face = rotations[of_corner], rotations[of_face]
    return Placed(
        corners_mm=_turned(by_corner, corners) + places[of_corner],
        inset=_turned(by_corner, inset),
        normals=_turned(by_face, normals),
        centres_mm=_turned(by_face, centres) + places[of_face],
        corner_counts=corner_counts,
        face_counts=face_counts,
    )


def middles_mm(figures: list[Figure]) -> NDArray[np.float64]:
    """Return the middles of figures in the robot frame, (n, 3)."""
    rotations = np.array([figure.rotation for figure in figures])
    middles = np.array([figure.solid.middle_mm for figure in figures])
    places = np.array([figure.place_mm for figure in figures])
    return np.asarray(_turned(rotations, middles) + places)


def _turned(rotations: NDArray[np.float64], vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn each vector by its own rotation."""
    return np.asarray((rotations @ vectors[:, :, None])[:, :, 0])
