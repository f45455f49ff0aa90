"""Sets of points on a smooth surface: samples that carry area, and a closed triangulation."""

from __future__ import annotations

from dataclasses import dataclass
from operator import index

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from glossa.anatomy.arrays import FloatArray, IntArray, frozen, int_array
from glossa.anatomy.facet_surface import FacetSurface
from glossa.anatomy.smooth_surface import SmoothSurface
from glossa.anatomy.surface_patch import face_coordinates
from glossa.errors import InputError

LARGEST_DIVISION = 6
LARGEST_LATTICE = 40
"""Pieces of an edge at most: so many points of a face that is far larger than the others are not needed."""
ROUNDING = 1e-9
"""Relative length that decides nothing: both sides of a symmetric body are divided alike."""
_GAUSS = (np.array([-1.0, 1.0]) / np.sqrt(3.0) + 1.0) / 2.0


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Points of a smooth surface, each for the area around it.

    Attributes:
        faces: (k,) face of each point.
        u, v: (k,) parameters.
        operator: (k, n) weights of the nodes.
        areas: (k,) m2 at rest; those of a face sum to its area.
        normals: (k, 3) outward unit normals at rest.
    """

    faces: IntArray
    u: FloatArray
    v: FloatArray
    operator: sparse.csr_array
    areas: FloatArray
    normals: FloatArray


def surface_samples(
    surface: SmoothSurface | FacetSurface, faces: ArrayLike, spacing: float, most: int = LARGEST_DIVISION
) -> SurfaceSamples:
    """See ``SmoothSurface.samples``; ``most``: parts of an edge. Areas: 2 x 2 Gauss points in each cell."""
    chosen, (columns, rows) = _divisions(surface, faces, spacing, most)
    face, column, row = _cells(chosen, columns, rows)
    across, up = np.repeat(columns, columns * rows), np.repeat(rows, columns * rows)
    u, v = (column + 0.5) / across, (row + 0.5) / up
    normals = surface.area_vectors(face, u, v)
    areas = np.zeros(len(face))
    for a in _GAUSS:
        for b in _GAUSS:
            areas += np.linalg.norm(surface.area_vectors(face, (column + a) / across, (row + b) / up), axis=1)
    areas /= 4.0 * across * up
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    parts = (frozen(face), frozen(u), frozen(v))
    return SurfaceSamples(*parts, surface.operator(face, u, v), frozen(areas), frozen(normals))


def surface_lattice(
    surface: SmoothSurface | FacetSurface, faces: ArrayLike, spacing: float
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Faces and parameters (u, v), (k,) each, of points on ``faces``, edges and corners among them.

    Each face is divided into its longer rest edge / spacing parts, rounded up, at most 40; a point of an edge counts in
    both its faces.

    Raises:
        InputError: an unknown face, or a spacing that is not positive.
    """
    chosen, (columns, rows) = _divisions(surface, faces, spacing, LARGEST_LATTICE)
    face, column, row = _cells(chosen, columns + 1, rows + 1)
    count = (columns + 1) * (rows + 1)
    return face, column / np.repeat(columns, count), row / np.repeat(rows, count)


def _divisions(
    surface: SmoothSurface | FacetSurface, faces: ArrayLike, spacing: float, most: int
) -> tuple[IntArray, tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """The faces, and into how many parts, up to ``most``, each is divided along u and along v."""
    chosen = int_array(faces, "faces")
    if not (np.isfinite(spacing) and spacing > 0.0):
        raise InputError(f"spacing must be a positive length in m, got {spacing!r}")
    if len(chosen) and chosen.max() >= len(surface.quads):
        raise InputError(f"there is no face {chosen.max()}; the surface has {len(surface.quads)} (from 0)")
    corners = surface.nodes[surface.quads[chosen]]
    lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    longest = spacing * (1.0 + ROUNDING)
    along_u, along_v = (
        np.clip(np.ceil(np.maximum(lengths[:, k], lengths[:, k + 2]) / longest), 1, most).astype(np.int64)
        for k in (0, 1)
    )
    return chosen, (along_u, along_v)


def _cells(
    faces: IntArray, columns: NDArray[np.int64], rows: NDArray[np.int64]
) -> tuple[IntArray, NDArray[np.int64], NDArray[np.int64]]:
    """Face, column and row of each of the places that faces of so many columns and rows have, row by row."""
    count = columns * rows
    place = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    row, column = np.divmod(place, np.repeat(columns, count))
    return np.repeat(faces, count), column, row


def surface_triangulation(surface: SmoothSurface, divisions: int) -> tuple[sparse.csr_array, IntArray]:
    """See ``SmoothSurface.triangulation``. Each cell of a face is cut along its diagonal that is shorter at rest."""
    try:
        d = index(divisions)
    except TypeError:
        raise InputError(f"divisions: {divisions!r} is not a whole number") from None
    if d < 1:
        raise InputError(f"divisions must be at least 1, got {d}")
    lattice, faces, u, v = _lattice(surface, d)
    nodes = np.unique(surface.quads)
    at_nodes = sparse.csr_array(
        (np.ones(len(nodes)), (np.arange(len(nodes)), nodes)), shape=(len(nodes), len(surface.nodes))
    )
    weights = sparse.vstack([at_nodes, surface.operator(faces, u, v)], format="csr")
    cells = np.stack([lattice[:, :-1, :-1], lattice[:, 1:, :-1], lattice[:, 1:, 1:], lattice[:, :-1, 1:]], axis=-1)
    cells = cells.reshape(-1, 4)
    corners = (weights @ surface.nodes)[cells]
    diagonals = np.linalg.norm(corners[:, 2:] - corners[:, :2], axis=2)
    # Diagonals equal but for rounding are cut alike. Two faces around one node share both neighbours of that node: a
    # cut between these would be the same edge in either face, so the cut goes through the node.
    other = diagonals[:, 1] < diagonals[:, 0] * (1.0 - 1e-9)
    valence = np.zeros(weights.shape[0], dtype=np.int64)
    valence[: len(nodes)] = np.bincount(surface.quads.ravel())[nodes]
    paired = valence[cells] == 2
    other = np.where(paired.any(axis=1), paired[:, 1] | paired[:, 3], other)
    cells = np.where(other[:, None], np.roll(cells, -1, axis=1), cells)
    return weights, frozen(cells[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3).astype(np.int32))


def _lattice(surface: SmoothSurface, d: int) -> tuple[NDArray[np.int64], IntArray, FloatArray, FloatArray]:
    """(q, d + 1, d + 1) vertices at (u, v) = (i, j) / d of each face; face and parameters of those at no node."""
    mesh, count = surface.mesh, len(surface.quads)
    nodes = np.unique(surface.quads)
    lattice = np.empty((count, d + 1, d + 1), dtype=np.int64)
    owner = np.flatnonzero(np.arange(4 * count) < mesh.twin)
    edge = np.empty(4 * count, dtype=np.int64)
    edge[owner] = edge[mesh.twin[owner]] = np.arange(len(owner))
    inside = np.arange(1, d)
    on_edge = len(nodes) + edge[:, None] * (d - 1) + inside - 1
    turned = np.arange(4 * count) > mesh.twin
    on_edge[turned] = on_edge[turned, ::-1]
    for corner in range(4):
        half_edges = slice(corner, None, 4)
        i, j = face_coordinates(corner, np.arange(d + 1) / d, np.zeros(d + 1))
        i, j = np.rint(i * d).astype(int), np.rint(j * d).astype(int)
        lattice[:, i[0], j[0]] = np.searchsorted(nodes, mesh.start[half_edges])
        lattice[:, i[1:d], j[1:d]] = on_edge[half_edges]
    in_face = len(nodes) + len(owner) * (d - 1) + np.arange(count * (d - 1) ** 2)
    lattice[:, 1:d, 1:d] = in_face.reshape(count, d - 1, d - 1)
    s = np.tile(inside / d, len(owner))
    along = [face_coordinates(corner, s, np.zeros_like(s)) for corner in range(4)]
    side = np.repeat(owner % 4, d - 1)
    u_edge, v_edge = (np.choose(side, [pair[axis] for pair in along]) for axis in range(2))
    u_face, v_face = (np.tile(part.ravel(), count) for part in np.meshgrid(inside / d, inside / d, indexing="ij"))
    faces = np.concatenate([np.repeat(owner // 4, d - 1), np.repeat(np.arange(count), (d - 1) ** 2)])
    return lattice, faces.astype(np.int32), np.concatenate([u_edge, u_face]), np.concatenate([v_edge, v_face])
