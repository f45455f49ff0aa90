"""Midsagittal sections: the outline of the tongue and the lines in which the plane y = 0 cuts walls."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.hexahedra import FACES
from glossa.anatomy.plane_cut import plane_cut
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Wall
from glossa.errors import InputError


def midsagittal_outline(speaker: Speaker) -> IntArray:
    """(k,) nodes around the midsagittal section at rest, in order; the last is joined to the first.

    The section is made of the faces of hexahedra that lie in y = 0; its outline is their outer boundary.

    Raises:
        InputError: no face of a hexahedron lies in y = 0.
    """
    in_plane = np.zeros(len(speaker.nodes), dtype=bool)
    in_plane[speaker.midsagittal_nodes] = True
    faces = speaker.hexahedra[:, FACES]
    flat = in_plane[faces].all(axis=2)
    side = speaker.nodes[speaker.hexahedra, 1].mean(axis=1)
    quads = faces[flat & (side > 0)[:, None]]
    if len(quads) == 0:
        quads = faces[flat]
    if len(quads) == 0:
        raise InputError("no midsagittal section: no face of a hexahedron lies in the plane y = 0")
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    shared = {(int(b), int(a)) for a, b in edges}
    after = {int(a): int(b) for a, b in edges if (int(a), int(b)) not in shared}
    loops = []
    while after:
        start, node = after.popitem()
        loop = [start]
        while node != start and node in after:
            loop.append(node)
            node = after.pop(node)
        loops.append(np.array(loop, dtype=np.int32))
    return max(loops, key=lambda loop: enclosed_area(speaker.nodes[loop][:, [0, 2]]))


def enclosed_area(polygon: FloatArray) -> float:
    """Area of a closed polygon (k, 2), m2."""
    x, z = polygon.T
    return abs(float(np.dot(x, np.roll(z, -1)) - np.dot(np.roll(x, -1), z))) / 2.0


def smooth_closed(points: FloatArray, divisions: int = 6) -> FloatArray:
    """(k * divisions, d) closed curve through all ``points`` (k, d): centripetal Catmull-Rom.

    It passes through every point and rounds the corners between; for drawing only.
    """
    before, after, next_but_one = (np.roll(points, shift, axis=0) for shift in (1, -1, -2))
    t1, t2, t3 = (
        np.sqrt(np.maximum(np.linalg.norm(b - a, axis=1, keepdims=True), 1e-12))
        for a, b in ((before, points), (points, after), (after, next_but_one))
    )
    leave = t2 * ((points - before) / t1 - (after - before) / (t1 + t2) + (after - points) / t2)
    arrive = t2 * ((after - points) / t2 - (next_but_one - points) / (t2 + t3) + (next_but_one - after) / t3)
    s = np.linspace(0.0, 1.0, divisions, endpoint=False)[:, None, None]
    curve = (
        (1 + 2 * s) * (1 - s) ** 2 * points
        + s * (1 - s) ** 2 * leave
        + s**2 * (3 - 2 * s) * after
        + s**2 * (s - 1) * arrive
    )
    return np.asarray(curve.transpose(1, 0, 2).reshape(-1, points.shape[1]))


def midsagittal_cut(wall: Wall) -> list[FloatArray]:
    """Lines (k, 2) in x and z, m, in which y = 0 cuts a wall; closed lines repeat their first point."""
    return plane_cut(wall, 1)
