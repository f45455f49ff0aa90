"""One smooth surface through the nodes of a body's surface: where contact samples, areas and pictures take it from.

A point of the surface is a weighted mean of nodes with weights that depend on the rest geometry only, so the surface of
a posture is one sparse matrix times its node positions. The surface passes through the nodes; a point of a face depends
only on the faces around its four corners; what is flat stays flat. Off creases it has one tangent plane at every node,
and along every edge but the few whose faces are too skew for it. Tangents: glossa.anatomy.surface_tangents; patches
(Coons 1967, with joints in the manner of Gregory 1974): glossa.anatomy.surface_patch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from glossa.anatomy import surface_patch as patch
from glossa.anatomy.arrays import FloatArray, IntArray, float_array, frozen, int_array
from glossa.anatomy.quad_mesh import QuadMesh
from glossa.anatomy.surface_tangents import Tangents, surface_tangents
from glossa.errors import InputError

if TYPE_CHECKING:
    from glossa.anatomy.surface_sampling import SurfaceSamples

CREASE_ANGLE = float(np.radians(75.0))
_VALUE, _BY_U, _BY_V = range(3)
_SKEW = np.sin(np.radians(15.0))  # a face whose corner is sharper, or straighter, has no joint at the edges there


@dataclass(frozen=True, eq=False, init=False, repr=False)
class SmoothSurface:
    """A smooth surface through the nodes of a closed mesh of quadrilaterals.

    Parameters (u, v) in [0, 1] run over each face, its corners at (0, 0), (1, 0), (1, 1), (0, 1).

    Attributes:
        nodes: (n, 3) m, at rest; nodes of no face are allowed.
        quads: (q, 4) node indices, normals outwards.
        crease_angle: rad; edges stay sharp where the mean normals of their faces differ by more.
        creases: (k, 2) nodes of these edges; without those that meet no other at either end.
        mesh: half-edges of ``quads``.

    Raises:
        InputError: not a closed, outward surface, or an edge or a face without extent.
    """

    nodes: FloatArray
    quads: IntArray
    crease_angle: float
    creases: IntArray
    mesh: QuadMesh
    _joints: FloatArray  # (4, 4 q) alpha at start and end, beta at start and end; zeros for no joint
    _controls: sparse.csr_array  # (n + 8 q, n) nodes, then tangents along and across the half-edges

    def __init__(self, nodes: ArrayLike, quads: ArrayLike, crease_angle: float = CREASE_ANGLE) -> None:
        rest, faces = float_array(nodes, "nodes", 3), int_array(quads, "quads", 4)
        _check(rest, faces, crease_angle)
        mesh = QuadMesh(faces, len(rest))
        tangents = surface_tangents(rest, faces, mesh, crease_angle)
        sharp = (tangents.creased | tangents.creased[mesh.twin]) & (mesh.start < mesh.end)
        identity = sparse.eye_array(len(rest), format="csr")
        parts = {
            "nodes": rest,
            "quads": faces,
            "crease_angle": float(crease_angle),
            "creases": frozen(np.stack([mesh.start[sharp], mesh.end[sharp]], axis=1).astype(np.int32)),
            "mesh": mesh,
            "_joints": _joints(mesh, tangents),
            "_controls": sparse.vstack([identity, tangents.along, tangents.across], format="csr"),
        }
        for name, part in parts.items():
            object.__setattr__(self, name, part)

    def __repr__(self) -> str:
        return f"SmoothSurface({len(self.quads)} faces, {len(self.creases)} creases)"

    # Points

    def operator(self, faces: ArrayLike, u: ArrayLike, v: ArrayLike) -> sparse.csr_array:
        """(k, n) weights of the nodes at the points (u, v) of ``faces``, (k,) each; every row sums to 1.

        Raises:
            InputError: different lengths, an unknown face, or parameters outside [0, 1].
        """
        return _compact(self._functions(self._checked(faces, u, v), _VALUE)[0] @ self._controls)

    def derivatives(self, faces: ArrayLike, u: ArrayLike, v: ArrayLike) -> tuple[sparse.csr_array, sparse.csr_array]:
        """Weights as of ``operator`` for the derivatives by u and by v, m per unit; every row sums to 0."""
        by_u, by_v = self._functions(self._checked(faces, u, v), _BY_U, _BY_V)
        return _compact(by_u @ self._controls), _compact(by_v @ self._controls)

    def points(self, faces: ArrayLike, u: ArrayLike, v: ArrayLike, positions: ArrayLike) -> FloatArray:
        """(k, 3) m: points of the surface when the nodes are at ``positions`` (n, 3) m."""
        places = float_array(positions, "positions", 3)
        if len(places) != len(self.nodes):
            raise InputError(f"positions: expected one row for each of {len(self.nodes)} nodes, got {len(places)}")
        result: FloatArray = self._functions(self._checked(faces, u, v), _VALUE)[0] @ (self._controls @ places)
        return result

    def area_vectors(self, faces: ArrayLike, u: ArrayLike, v: ArrayLike) -> FloatArray:
        """(k, 3) m2 per unit of u and v: outward normal at rest, as long as the area it stands for."""
        rest = self._controls @ self.nodes
        by_u, by_v = self._functions(self._checked(faces, u, v), _BY_U, _BY_V)
        result: FloatArray = np.cross(by_u @ rest, by_v @ rest)
        return result

    # Sets of points

    def samples(self, faces: ArrayLike, spacing: float) -> SurfaceSamples:
        """Points about ``spacing`` m apart on ``faces`` (k,), with area and normal.

        Each face gets the centres of a division of its square of parameters, in each direction into its longer rest
        edge / spacing parts, rounded up, from 1 to 6; face by face in the order given.

        Raises:
            InputError: an unknown face, or a spacing that is not positive.
        """
        from glossa.anatomy.surface_sampling import surface_samples

        return surface_samples(self, faces, spacing)

    def triangulation(self, divisions: int = 4) -> tuple[sparse.csr_array, IntArray]:
        """The whole surface as triangles: weights (k, n) of the vertices, and (t, 3) vertices, outward and closed.

        Vertices: the surface's nodes in ascending order, then those inside edges, then those inside faces; each edge
        in ``divisions`` pieces.

        Raises:
            InputError: divisions not a whole number from 1.
        """
        from glossa.anatomy.surface_sampling import surface_triangulation

        return surface_triangulation(self, divisions)

    # Inside

    def _checked(self, faces: ArrayLike, u: ArrayLike, v: ArrayLike) -> tuple[IntArray, FloatArray, FloatArray]:
        chosen, first, second = int_array(faces, "faces"), float_array(u, "u"), float_array(v, "v")
        if not len(chosen) == len(first) == len(second):
            raise InputError(f"faces, u and v differ in length: {len(chosen)}, {len(first)}, {len(second)}")
        if len(chosen) and chosen.max() >= len(self.quads):
            raise InputError(f"there is no face {chosen.max()}; the surface has {len(self.quads)} (from 0)")
        for name, values in (("u", first), ("v", second)):
            if len(values) and (values.min() < 0.0 or values.max() > 1.0):
                bad = values.min() if values.min() < 0.0 else values.max()
                raise InputError(f"{name} runs from 0 to 1 over a face, got {bad}")
        return chosen, first, second

    def _functions(self, points: tuple[IntArray, FloatArray, FloatArray], *kinds: int) -> tuple[sparse.csr_array, ...]:
        """Weights (k, n + 8 q) of the controls at (faces, u, v) for each of ``kinds``: _VALUE, _BY_U, _BY_V."""
        faces, u, v = points
        mesh, n = self.mesh, len(self.nodes)
        columns, values = [], []
        for corner in range(4):
            h = 4 * faces.astype(np.int64) + corner
            s, r = patch.corner_coordinates(corner, u, v)
            by_uv = np.eye(3)
            by_uv[1:, 1:] = patch.ROTATIONS[corner].T
            turned = by_uv @ np.concatenate(
                [patch.corner_functions(s, r), patch.joint_functions(s, r, self._joints[:, h])]
            )
            along, across = n + h, n + self.quads.size + h
            twin_along, twin_across = n + mesh.twin[h], n + self.quads.size + mesh.twin[h]
            columns += [mesh.start[h], along, n + mesh.ccw[h], across, twin_across, mesh.start[h], mesh.end[h]]
            columns += [along, twin_along]
            # The tangents at an edge's end point the other way in its twin.
            values += [*turned[:3], turned[3], turned[3], turned[4], -turned[4], turned[5], -turned[6]]
        rows = np.tile(np.arange(len(faces)), len(columns))
        indices = np.concatenate(columns)
        return tuple(
            sparse.csr_array(
                (np.concatenate([value[kind] for value in values]), (rows, indices)),
                shape=(len(faces), self._controls.shape[0]),
            )
            for kind in kinds
        )


def _compact(weights: sparse.csr_array) -> sparse.csr_array:
    """The same matrix without stored zeros, columns ascending in each row."""
    weights.eliminate_zeros()
    weights.sort_indices()
    return weights


def _joints(mesh: QuadMesh, tangents: Tangents) -> FloatArray:
    """(4, 4 q) how the face on the left leaves each half-edge; zeros where the two faces are not joined."""
    alpha, beta = np.stack([tangents.left, -tangents.right[mesh.twin]], axis=1).transpose(2, 1, 0)
    sines = alpha / np.maximum(np.hypot(alpha, beta), np.finfo(float).tiny)
    fit = (sines > _SKEW).all(axis=0) & tangents.planar
    joined = fit & fit[mesh.twin]
    return np.where(joined, np.concatenate([alpha, beta]), 0.0)


def _check(nodes: FloatArray, quads: IntArray, crease_angle: float) -> None:
    if not 0.0 < crease_angle <= np.pi:
        raise InputError(f"crease_angle must be above 0 and at most pi (rad), got {crease_angle!r}")
    if len(quads) == 0:
        raise InputError("a surface needs faces; got none")
    if quads.max() >= len(nodes):
        face = int((quads >= len(nodes)).any(axis=1).argmax())
        raise InputError(f"face {face} names node {quads[face].max()}; there are {len(nodes)} nodes (from 0)")
    corners = nodes[quads]
    lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    areas = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2.0
    for face, corner in np.argwhere(lengths == 0.0)[:1]:
        a, b = quads[face, [corner, (corner + 1) % 4]]
        raise InputError(f"face {face}: its neighbouring corners {a} and {b} are at the same place")
    for face in np.flatnonzero((areas == 0.0).all(axis=1))[:1]:
        raise InputError(f"face {face} with the nodes {quads[face].tolist()} has no area")
    if (corners.mean(axis=1) * areas).sum() <= 0.0:
        raise InputError("the faces' normals point inwards; reverse the corners of every face")
