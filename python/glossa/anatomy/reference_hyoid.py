"""The hyoid bone of the built-in speaker: a closed tube along a spline, held by springs on both sides."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.landmarks import pchip
from glossa.anatomy.solid import solid
from glossa.anatomy.swept_surface import chord_lengths, cubic_spline, grid_quads, mirrored_wall
from glossa.anatomy.wall_landmarks import Table, WallLandmarks
from glossa.anatomy.walls import Hyoid, Spring, Wall

_SPACING = 1.4  # mm between rings
_AROUND = 16  # vertices of a ring
_CAP_RINGS = 2  # rings of the round end of a horn
_MILLIMETRE = 1e-3
_SIDES = {"left": np.array([1.0, -1.0, 1.0]) * _MILLIMETRE, "right": np.ones(3) * _MILLIMETRE}


def reference_hyoid(landmarks: WallLandmarks) -> Hyoid:
    """Surface, mass and centre of the bone, and its springs "<muscle or ligament> <side>"; y > 0 is the right side."""
    surface = _surface(landmarks.hyoid)
    volume, centre = solid(surface)
    springs = tuple(
        Spring(ends[0] * reflection, ends[1] * reflection, landmarks.spring_stiffness, name=f"{name} {side}")
        for side, reflection in _SIDES.items()
        for name, ends in landmarks.springs.items()
    )
    return Hyoid(surface, volume * landmarks.density, centre, springs)


def _surface(table: Table) -> Wall:
    """Rings from the midplane to the tip of the horn, a round end, and the mirror image."""
    centres, tangents, radii = _centre_line(table)
    level = np.cross(tangents, [0.0, 0.0, 1.0])
    level /= np.sqrt((level**2).sum(axis=1, keepdims=True))
    upright = np.cross(tangents, level)  # downwards: rings turn so that normals point outwards
    # the round end: half an ellipse along the tangent, from the last ring to its pole
    turn = np.pi / 2.0 * np.arange(1, _CAP_RINGS + 1)[:, None] / (_CAP_RINGS + 1)
    caps = np.ones((_CAP_RINGS, 1))
    ends = centres[-1] + radii[-1].min() * np.sin(turn) * tangents[-1]
    rings = [
        _rings(centres, radii, level, upright),
        _rings(ends, radii[-1] * np.cos(turn), caps * level[-1], caps * upright[-1]),
    ]
    vertices = np.concatenate(rings).reshape(-1, 3)
    vertices[:_AROUND, 1] = 0.0
    pole = centres[-1] + radii[-1].min() * tangents[-1]
    quads = grid_quads(len(vertices) // _AROUND, _AROUND, closed=True)
    return mirrored_wall(
        np.concatenate([vertices, pole[None]]) * _MILLIMETRE, np.concatenate([quads, _fan(len(vertices))])
    )


def _centre_line(table: Table) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Centres (n, 3), unit tangents (n, 3) and radii (n, 2) in mm, from the midplane to the tip of the horn.

    The spline runs through the rows and their mirror images, so that it crosses the midplane at a right angle.
    """
    half = np.stack([table["x"], table["y"], table["z"]], axis=1)
    points = np.concatenate([half[:0:-1] * [1.0, -1.0, 1.0], half])
    knots = chord_lengths(points)
    knots -= knots[len(half) - 1]
    at = np.linspace(0.0, knots[-1], round(knots[-1] / _SPACING) + 1)
    step = 1e-4 * knots[-1]
    tangents = (cubic_spline(knots, points.T, at + step) - cubic_spline(knots, points.T, at - step)).T
    tangents[0] = [0.0, 1.0, 0.0]
    radii = np.stack([table["level_radius"], table["upright_radius"]])
    return (
        cubic_spline(knots, points.T, at).T,
        tangents / np.sqrt((tangents**2).sum(axis=1, keepdims=True)),
        pchip(knots, np.concatenate([radii[:, :0:-1], radii], axis=1), at).T,
    )


def _rings(centres: FloatArray, radii: FloatArray, level: FloatArray, upright: FloatArray) -> FloatArray:
    """(n, _AROUND, 3) ellipses around the centres."""
    angle = 2.0 * np.pi * np.arange(_AROUND)[:, None] / _AROUND
    across = radii[:, None, :1] * np.cos(angle) * level[:, None], radii[:, None, 1:] * np.sin(angle) * upright[:, None]
    return centres[:, None] + across[0] + across[1]


def _fan(pole: int) -> IntArray:
    """(_AROUND, 4) triangles between the last ring before the vertex ``pole`` and it."""
    ring = np.arange(pole - _AROUND, pole, dtype=np.int32)
    tip = np.full(_AROUND, pole, dtype=np.int32)
    return np.stack([ring, np.roll(ring, -1), tip, tip], axis=1)
