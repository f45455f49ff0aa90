"""Sectors between the creases around one node: the tangents of creases, and the gradient inside a sector.

Everything concerns one fan of k edges in counter-clockwise order from a crease, given by their rest vectors (k, 3).
Tangents are rows (k,) of weights of these edge vectors. See glossa.anatomy.surface_tangents for the rules.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.quad_mesh import IndexArray

_STRAIGHT = np.cos(np.radians(60.0))  # creases that turn by less continue each other
_SLENDER = np.sin(np.radians(15.0))  # directions closer than this to one line determine no plane
_STEEP = 1e6  # an edge stretched by more than this stands on the plane and has no direction in it
_TIE = 1e-6  # cosines closer than this are equal: symmetric meshes must get symmetric tangents


@dataclass(frozen=True)
class Sector:
    """Positions in the fan: the crease where a sector begins, the edges inside it, the crease where it ends."""

    first: int
    inner: list[int]
    last: int


@dataclass(frozen=True, eq=False)
class Gradient:
    """Slopes along two orthogonal directions of a plane: rows (2, k); rest coordinates of the edges: places (k, 2)."""

    rows: FloatArray
    places: FloatArray


def crease_sectors(creases: IndexArray, size: int) -> list[Sector]:
    """Sectors of a fan of ``size`` edges with at least two ``creases``, the first of them edge 0."""
    bounds = [*creases.tolist(), size]
    return [Sector(a, list(range(a + 1, b)), b % size) for a, b in pairwise(bounds)]


def crease_tangents(edges: FloatArray, creases: IndexArray) -> tuple[FloatArray, IndexArray]:
    """Rows (k, k) of weights, filled for the creases, and by edge the crease that continues it (k,), -1 for none."""
    size = len(edges)
    lengths = np.linalg.norm(edges, axis=1)
    directions = edges / lengths[:, None]
    straightness = np.full((size, size), -1.0)
    straightness[np.ix_(creases, creases)] = -directions[creases] @ directions[creases].T
    for sector in crease_sectors(creases, size):
        if not sector.inner:  # a face alone in its sector would be left without a corner there
            straightness[sector.first, sector.last] = straightness[sector.last, sector.first] = -1.0
    partner = np.full(size, -1)
    rows = np.zeros((size, size))
    rows[creases, creases] = 1.0
    for i in creases:
        j = int(straightness[i].argmax())
        rivals = np.delete(straightness[[i, j]], [i, j], axis=1)
        if straightness[i, j] >= max(_STRAIGHT, rivals.max(initial=-1.0) + _TIE):
            partner[i] = j
            # slope of the parabola through the three points, times the length
            total = 1.0 / lengths[i] + 1.0 / lengths[j]
            rows[i, [i, j]] = lengths[i] / total * np.array([lengths[i] ** -2, -(lengths[j] ** -2)])
    return rows, partner


def sector_gradient(
    edges: FloatArray, area: FloatArray, sector: Sector, rows: FloatArray, smooth: bool
) -> Gradient | None:
    """The gradient that a sector's two crease tangents, and the edges inside it, determine; None where they do not.

    Args:
        edges: (k, 3) m.
        area: (3,) sum of the faces' mean normals times areas.
        sector: with at least one edge inside.
        rows: (k, k) from ``crease_tangents``.
        smooth: whether the two creases continue each other.
    """
    begin, end = rows[sector.first] @ edges, rows[sector.last] @ edges
    lengths = np.linalg.norm(begin), np.linalg.norm(end)
    x_direction = begin / lengths[0]
    if smooth:
        normal = area - (area @ x_direction) * x_direction
    else:
        normal = np.cross(begin, end) / (lengths[0] * lengths[1])
        if np.linalg.norm(normal) < _SLENDER:
            return None
        normal *= np.sign(normal @ area)
    if np.linalg.norm(normal) == 0.0:
        return None
    y_direction = np.cross(normal / np.linalg.norm(normal), x_direction)
    places = edges @ np.stack([x_direction, y_direction], axis=1)
    size = np.linalg.norm(places, axis=1)
    stretch = np.linalg.norm(edges, axis=1) / np.maximum(size, np.finfo(float).tiny)
    if stretch[sector.inner].max() > _STEEP:
        return None
    places *= stretch[:, None]
    slopes = np.stack([rows[sector.first] / lengths[0], np.zeros(len(edges))])
    if smooth:
        x, y = places[sector.inner].T
        h = np.hypot(x, y)
        if np.abs(y / h).max() < _SLENDER:
            return None
        weights = y / h**3
        slopes[1, sector.inner] = weights
        slopes[1] = (slopes[1] - (weights * x).sum() * slopes[0]) / (weights * y).sum()
        places[sector.last] = -lengths[1], 0.0
    else:
        places[sector.last] = end @ x_direction, end @ y_direction
        slopes[1] = (rows[sector.last] - places[sector.last, 0] * slopes[0]) / places[sector.last, 1]
    places[sector.first] = lengths[0], 0.0
    return Gradient(slopes, places)
