"""Shaded facets of hexahedral surfaces, for pictures in three dimensions."""

from __future__ import annotations

import math

import numpy as np

from glossa.anatomy.arrays import FloatArray, IntArray

LIGHT = (-0.45, 0.55, 0.70)
"""Direction of the light seen by the viewer: right, up, towards the viewer."""


BULGE = 0.6
"""Strength of the rounding of quads (0: flat, 1: full; the authors of the method take 0.75)."""


def view_frame(elevation: float, azimuth: float) -> FloatArray:
    """(3, 3) rows: right, up and towards the viewer, for angles in degrees as in matplotlib."""
    e, a = math.radians(elevation), math.radians(azimuth)
    towards = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
    right = np.array([-math.sin(a), math.cos(a), 0.0])
    return np.stack([right, np.cross(towards, right), towards])


def node_normals(positions: FloatArray, quads: IntArray) -> FloatArray:
    """(n, 3) unit normals at nodes: means over the quads around, weighted by area; 0 away from the surface."""
    a, b, c, d = (positions[quads[:, k]] for k in range(4))
    normal = np.cross(c - a, d - b)
    sums = np.zeros(positions.shape)
    for k in range(4):
        np.add.at(sums, quads[:, k], normal)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.asarray(np.divide(sums, length, out=np.zeros_like(sums), where=length > 0.0))


def rounded(corners: FloatArray, normals: FloatArray, divisions: int) -> tuple[FloatArray, FloatArray]:
    """Pieces (q * divisions², 4, 3) of quads with corners (q, 4, 3), bulged to suit the corner normals (q, 4, 3).

    Phong tessellation (Boubekeur & Alexa 2008): bilinear points are moved ``BULGE`` of the way to the mean of their
    projections on the tangent planes at the corners. Nodes stay where they are; for drawing only. The second result
    is the unit normal (q * divisions², 3) of each piece, interpolated.
    """
    s = np.linspace(0.0, 1.0, divisions + 1)
    u, v = np.meshgrid(s, s, indexing="ij")
    shape = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=-1)
    flat = np.einsum("uva,qad->quvd", shape, corners)
    height = np.einsum("quvad,qad->quva", flat[:, :, :, None] - corners[:, None, None], normals)
    bulged = flat - BULGE * np.einsum("uva,quva,qad->quvd", shape, height, normals)
    pieces = np.concatenate([bulged, np.einsum("uva,qad->quvd", shape, normals)], axis=3)
    cells = np.stack([pieces[:, :-1, :-1], pieces[:, 1:, :-1], pieces[:, 1:, 1:], pieces[:, :-1, 1:]], axis=3)
    cells = cells.reshape(-1, 4, 6)
    mean = cells[:, :, 3:].mean(axis=1)
    return cells[:, :, :3], mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-12)


def quad_edges(corners: FloatArray, normals: FloatArray, divisions: int) -> FloatArray:
    """(e, 2, 3) straight pieces of the edges of quads rounded as by :func:`rounded`."""
    s = np.linspace(0.0, 1.0, divisions + 1)[:, None, None, None]
    after, normals_after = np.roll(corners, -1, axis=1), np.roll(normals, -1, axis=1)
    flat = (1 - s) * corners + s * after
    first = np.sum((flat - corners) * normals, axis=3, keepdims=True) * normals
    second = np.sum((flat - after) * normals_after, axis=3, keepdims=True) * normals_after
    points = flat - BULGE * ((1 - s) * first + s * second)
    return np.asarray(np.stack([points[:-1], points[1:]], axis=3).reshape(-1, 2, 3))


def shades(normals: FloatArray, frame: FloatArray) -> FloatArray:
    """(f,) brightness from 0 to 1 of facets with unit normals (f, 3): ambient and diffuse light from upper left."""
    light = np.array(LIGHT) @ frame
    facing = normals @ (light / np.linalg.norm(light))
    return np.asarray(0.42 + 0.58 * np.clip(0.5 + 0.5 * facing, 0.0, 1.0) ** 1.3)


def depth_fade(points: FloatArray, frame: FloatArray) -> FloatArray:
    """(f,) 0 for the nearest and 1 for the farthest of points (f, 3)."""
    depth = points @ frame[2]
    span = float(np.ptp(depth)) if len(depth) else 0.0
    return np.zeros(len(depth)) if span == 0.0 else np.asarray((depth.max() - depth) / span)
