"""Lines in which a plane across a coordinate axis cuts a wall."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.walls import Wall

_JOIN = 1e-8  # m; ends of cut segments nearer than this are one point


def plane_cut(wall: Wall, axis: int, at: float = 0.0) -> list[FloatArray]:
    """Lines (k, 2) m in which the plane where coordinate ``axis`` (0, 1, 2) is ``at`` cuts a wall.

    Columns are the other two coordinates in their order. Closed lines repeat their first point. A point in the plane
    counts as beyond it, so that edges in the plane appear once.
    """
    corners = wall.vertices[wall.triangles]
    above = corners[:, :, axis] >= at
    crossed = above.any(axis=1) & ~above.all(axis=1)
    corners, above = corners[crossed], above[crossed]
    following, above_next = np.roll(corners, -1, axis=1), np.roll(above, -1, axis=1)
    fall = corners[:, :, axis] - following[:, :, axis]
    share = np.where(above != above_next, (corners[:, :, axis] - at) / np.where(fall == 0.0, 1.0, fall), 0.0)
    points = corners + share[:, :, None] * (following - corners)
    kept = [other for other in range(3) if other != axis]
    segments = points[above != above_next][:, kept].reshape(-1, 2, 2)
    return _joined(segments[np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1) > _JOIN])


def _joined(segments: FloatArray) -> list[FloatArray]:
    """Lines made of segments (s, 2, 2) that share end points."""
    if len(segments) == 0:
        return []
    keys = np.unique(np.round(segments.reshape(-1, 2) / _JOIN), axis=0, return_inverse=True)[1].reshape(-1, 2)
    place = dict(zip(keys.ravel().tolist(), segments.reshape(-1, 2), strict=True))
    around: dict[int, list[int]] = {}
    for number, ends in enumerate(keys.tolist()):
        for end in ends:
            around.setdefault(end, []).append(number)
    unused = set(range(len(keys)))
    ends_first = sorted(around, key=lambda end: len(around[end]) == 2)
    lines = []
    for start in ends_first:
        while any(number in unused for number in around[start]):
            path = [start]
            while following := [number for number in around[path[-1]] if number in unused]:
                unused.remove(following[0])
                a, b = keys[following[0]]
                path.append(int(b if a == path[-1] else a))
            lines.append(np.array([place[end] for end in path]))
    return lines
