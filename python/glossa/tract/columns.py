"""Where surfaces cross the columns of the cutting planes.

A column is a straight line in a plane at constant y, along the plane's ``outwards``. All planes share one row of
columns. A crossing counts as seen from the side the triangle's normal points to: "facing out" where the normal has a
positive component along the column, that is for the surfaces below the airway.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray
from glossa.tract.planes import CuttingPlanes

Numbers = NDArray[np.int64]

WIDTH = 0.25e-3
"""Distance of neighbouring columns, m."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """c crossings of columns with triangles, in no particular order.

    Attributes:
        plane, column: (c,) numbers.
        heights: (c,) t, m.
        facing_out: (c,) the triangle's normal points along t.
    """

    plane: Numbers
    column: Numbers
    heights: FloatArray
    facing_out: BoolArray


def runs(mask: BoolArray) -> list[tuple[int, int]]:
    """First column of each run of True in (m,) booleans, and the one behind its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def column_row(half_width: float) -> FloatArray:
    """(m,) y of the columns out to ``half_width`` m, none in the midplane: meshes have vertices there."""
    count = max(4, int(np.ceil(half_width / WIDTH)))
    return np.asarray((np.arange(-count, count) + 0.5) * WIDTH)


def cross(vertices: FloatArray, triangles: IntArray, planes: CuttingPlanes, columns: FloatArray) -> Crossings:
    """All crossings of a surface with the columns.

    Args:
        vertices: (n, 3) m.
        triangles: (m, 3).
        planes: k planes.
        columns: (m,) y, m, equally spaced.
    """
    segments, plane, triangle = cut(vertices, triangles, planes)
    swap = segments[:, 0, 0] > segments[:, 1, 0]
    segments[swap] = segments[swap, ::-1]
    (y0, t0), (y1, t1) = segments[:, 0].T, segments[:, 1].T
    step = columns[1] - columns[0]
    low = np.clip(np.ceil((y0 - columns[0]) / step), 0, len(columns)).astype(np.int64)
    high = np.clip(np.floor((y1 - columns[0]) / step) + 1, 0, len(columns)).astype(np.int64)
    counts = np.maximum(high - low, 0)
    which = np.repeat(np.arange(len(counts)), counts)
    column = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + low[which]
    share = (columns[column] - y0[which]) / np.maximum((y1 - y0)[which], 1e-300)
    heights = t0[which] + np.clip(share, 0.0, 1.0) * (t1 - t0)[which]
    a, b, c = (vertices[triangles[triangle, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)[:, [0, 2]]
    out = (normals * planes.outwards[plane]).sum(axis=1) > 0.0
    return Crossings(plane[which], column, heights, out[which])


def cut(vertices: FloatArray, triangles: IntArray, planes: CuttingPlanes) -> tuple[FloatArray, Numbers, Numbers]:
    """Segments (s, 2, 2) in coordinates (y, t) in which planes cut triangles; number of plane and triangle, (s,)."""
    sagittal = vertices[:, [0, 2]]
    distance = sagittal @ planes.normals.T - (planes.origins * planes.normals).sum(axis=1)
    height = sagittal @ planes.outwards.T - (planes.origins * planes.outwards).sum(axis=1)
    beyond = distance >= 0.0
    corners = [beyond[triangles[:, corner]] for corner in range(3)]
    crossed = (corners[0] != corners[1]) | (corners[1] != corners[2])
    triangle, plane = np.nonzero(crossed)
    points = triangles[triangle]
    sides = distance[points, plane[:, None]]
    over = sides >= 0.0
    # The corner alone on its side comes first; both segment ends lie on its edges.
    alone = np.where(over[:, 1] == over[:, 2], 0, np.where(over[:, 0] == over[:, 2], 1, 2))
    order = (alone[:, None] + np.arange(3)) % 3
    points, sides = np.take_along_axis(points, order, 1), np.take_along_axis(sides, order, 1)
    share = sides[:, :1] / (sides[:, :1] - sides[:, 1:])
    y, t = vertices[points, 1], height[points, plane[:, None]]
    ends = [values[:, :1] + share * (values[:, 1:] - values[:, :1]) for values in (y, t)]
    return np.stack(ends, axis=2), plane, triangle
