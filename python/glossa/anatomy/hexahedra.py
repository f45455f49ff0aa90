"""Geometry and topology of trilinear hexahedra in VTK corner order, vectorised over elements."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from glossa.anatomy.arrays import FloatArray, IntArray

#: (8, 3) corner coordinates in the reference cube [-1, 1]^3, VTK order.
CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float
)
#: (12, 2) edges, four per local direction: rows 0-3 along the first, 4-7 the second, 8-11 the third direction.
EDGES = np.array(
    [[0, 1], [3, 2], [4, 5], [7, 6], [0, 3], [1, 2], [4, 7], [5, 6], [0, 4], [1, 5], [2, 6], [3, 7]], dtype=np.int32
)
#: (6, 4) faces, corners in cyclic order, normals outwards.
FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [3, 7, 6, 2], [0, 4, 7, 3], [1, 2, 6, 5]], dtype=np.int32)
#: (12, 2) diagonals of the faces, two per face in the order of FACES.
FACE_DIAGONALS = np.array([pair for f in FACES for pair in ((f[0], f[2]), (f[1], f[3]))], dtype=np.int32)
#: (4, 2) diagonals of the body.
BODY_DIAGONALS = np.array([[0, 6], [1, 7], [2, 4], [3, 5]], dtype=np.int32)
#: (8, 3) the three neighbours of a corner, ordered so that the unit cube gives a determinant of +1.
CORNER_NEIGHBOURS = np.array(
    [[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]], dtype=np.int32
)

_BLOCK = 4096


def shape_gradients(points: FloatArray) -> FloatArray:
    """(p, 8, 3) derivatives of the trilinear shape functions at ``points`` (p, 3) of the reference cube."""
    factors = 1.0 + points[:, None, :] * CORNERS
    gradients = np.empty((len(points), 8, 3))
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        gradients[:, :, axis] = CORNERS[:, axis] * factors[:, :, others[0]] * factors[:, :, others[1]] / 8.0
    return gradients


_GAUSS = CORNERS / np.sqrt(3.0)
_GAUSS_GRADIENTS = shape_gradients(_GAUSS)
_CORNER_GRADIENTS = shape_gradients(CORNERS)
#: (8 points, 8 corners) trilinear shape functions at the 2 x 2 x 2 Gauss points.
GAUSS_WEIGHTS = np.prod(1.0 + _GAUSS[:, None, :] * CORNERS, axis=2) / 8.0


def _determinants(nodes: FloatArray, hexahedra: IntArray, gradients: FloatArray) -> FloatArray:
    """(m, p) Jacobian determinants; the tensor contraction is done block by block to bound memory."""
    result = np.empty((len(hexahedra), len(gradients)))
    for start in range(0, len(hexahedra), _BLOCK):
        corners = nodes[hexahedra[start : start + _BLOCK]]
        jacobians = np.einsum("mia,pib->mpab", corners, gradients, optimize=True)
        result[start : start + _BLOCK] = np.linalg.det(jacobians)
    return result


def gauss_determinants(nodes: FloatArray, hexahedra: IntArray) -> FloatArray:
    """(m, 8) determinants of dx/dxi at the 2 x 2 x 2 Gauss points, m3 per unit of the reference cube [-1, 1]^3."""
    return _determinants(nodes, hexahedra, _GAUSS_GRADIENTS)


def gauss_gradients(nodes: FloatArray, field: FloatArray, hexahedra: IntArray) -> FloatArray:
    """(m, 8, 3, 3) gradients of a nodal field (n, 3) at the 2 x 2 x 2 Gauss points; last index: direction."""
    result = np.empty((len(hexahedra), 8, 3, 3))
    for start in range(0, len(hexahedra), _BLOCK):
        chosen = hexahedra[start : start + _BLOCK]
        jacobians, slopes = (
            np.einsum("mia,pib->mpab", values[chosen], _GAUSS_GRADIENTS, optimize=True) for values in (nodes, field)
        )
        result[start : start + _BLOCK] = slopes @ np.linalg.inv(jacobians)
    return result


def corner_determinants(nodes: FloatArray, hexahedra: IntArray) -> FloatArray:
    """(m, 8) determinants of dx/dxi at the corners."""
    return _determinants(nodes, hexahedra, _CORNER_GRADIENTS)


def volumes(nodes: FloatArray, hexahedra: IntArray) -> FloatArray:
    """(m,) volumes, m3. Exact: the determinant is quadratic in each direction, the Gauss rule exact to degree 3."""
    result: FloatArray = gauss_determinants(nodes, hexahedra).sum(axis=1)
    return result


def scaled_jacobians(nodes: FloatArray, hexahedra: IntArray) -> FloatArray:
    """(m,) smallest determinant of the three unit edge vectors over the eight corners; 1 for a cuboid."""
    result = np.full(len(hexahedra), np.inf)
    for corner in range(8):
        origin = nodes[hexahedra[:, corner]]
        edges = nodes[hexahedra[:, CORNER_NEIGHBOURS[corner]]] - origin[:, None, :]
        edges = edges / np.maximum(np.linalg.norm(edges, axis=2, keepdims=True), np.finfo(float).tiny)
        result = np.minimum(result, np.linalg.det(edges))
    return result


def pair_keys(pairs: NDArray[np.integer], n_nodes: int) -> NDArray[np.int64]:
    """One int64 per unordered node pair; ``pairs`` (..., 2)."""
    low, high = pairs.min(axis=-1).astype(np.int64), pairs.max(axis=-1).astype(np.int64)
    keys: NDArray[np.int64] = low * n_nodes + high
    return keys


def face_keys(hexahedra: IntArray, n_nodes: int) -> tuple[IntArray, NDArray[np.int64]]:
    """Faces (m, 6, 4) of the hexahedra and one int64 number per face (m, 6), equal for equal faces.

    The number is an index into the sorted list of distinct faces, so it is below 6 m.
    """
    faces = hexahedra[:, FACES]
    # Two hexahedra share a face when they share its lowest node and the node opposite, and the pair beside it.
    ordered = np.sort(faces, axis=2).astype(np.int64).reshape(-1, 4)
    first = ordered[:, 0] * n_nodes + ordered[:, 1]
    second = ordered[:, 2] * n_nodes + ordered[:, 3]
    order = np.lexsort((second, first))
    a, b = first[order], second[order]
    new = np.concatenate([[0], np.cumsum((a[1:] != a[:-1]) | (b[1:] != b[:-1]))]) if len(a) else np.zeros(0, int)
    keys = np.empty(len(first), dtype=np.int64)
    keys[order] = new
    return faces, keys.reshape(-1, 6)


def matching_faces(quads: IntArray, faces: IntArray) -> NDArray[np.int64]:
    """(k,) index into ``faces`` (f, 4) of the face with the same four corners as each of ``quads`` (k, 4).

    -1 where there is none. The order of the corners does not matter; no two ``faces`` share all four.
    """
    corners = np.sort(np.concatenate([faces, quads]), axis=1)
    place = np.unique(corners, axis=0, return_inverse=True)[1].ravel()
    index = np.full(len(corners), -1, dtype=np.int64)
    index[place[: len(faces)]] = np.arange(len(faces))
    return index[place[len(faces) :]]


def boundary_quads(hexahedra: IntArray, n_nodes: int) -> IntArray:
    """(q, 4) faces that belong to one hexahedron only, corners so that the normal points outwards."""
    faces, keys = face_keys(hexahedra, n_nodes)
    single = np.bincount(keys.ravel(), minlength=1)[keys] == 1
    return np.ascontiguousarray(faces[single])
