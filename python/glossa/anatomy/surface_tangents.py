"""Tangents of a smooth surface through the nodes of a closed quadrilateral mesh, linear in the nodes.

Edges whose faces meet at rest under more than a given angle are creases. They cut the fan of faces around a node into
sectors; a single crease that ends at a node does not cut. In each sector the surface has one gradient with respect to
coordinates of the rest tangent plane, hence one tangent plane in every posture:

* Rest coordinates of an edge: its projection on the plane, stretched to the edge's own length h.
* A sector all around the node: least squares over its edges, weights 1 / h^3. On a line that is the slope of the
  parabola through three points, however unequal the two edges.
* Two creases that continue each other are one smooth line with that slope, and the slope across it is fitted to the
  edges inside the sector. Other creases leave in the direction of their edge; two of them determine the gradient.

Where the rest geometry determines no gradient (see ``Tangents.planar``), tangents are the plain edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray
from glossa.anatomy.crease_sectors import Sector, crease_sectors, crease_tangents, sector_gradient
from glossa.anatomy.quad_mesh import IndexArray, QuadMesh

_SLENDER = np.sin(np.radians(15.0))  # directions closer than this to one line determine no plane
_TIE = 1e-9  # rad; angles that equal the limit but for rounding fall on the same side left and right


@dataclass(frozen=True, eq=False)
class Tangents:
    """Tangents at the starts of the 4 q half-edges of a mesh with n nodes; an edge is parametrised over [0, 1].

    Attributes:
        creased: (4 q,) whether the edge is a crease at its start.
        along: (4 q, n) weights: tangent of the edge.
        across: (4 q, n) weights: the same gradient in the direction 90 degrees to the left, over the same length.
        left, right: (4 q, 2) the tangents of the next edges counter-clockwise and clockwise, as multiples of
            ``across`` and ``along``.
        planar: (4 q,) whether ``across``, ``left`` and ``right`` are given: not for creases, nor where the gradient
            is undetermined.
    """

    creased: BoolArray
    along: sparse.csr_array
    across: sparse.csr_array
    left: FloatArray
    right: FloatArray
    planar: BoolArray


def surface_tangents(nodes: FloatArray, quads: IntArray, mesh: QuadMesh, crease_angle: float) -> Tangents:
    """Tangents of the surface with rest ``nodes`` (n, 3) m and outward faces ``quads`` (q, 4); angle in radians."""
    builder = _Builder(nodes, quads, mesh, crease_angle)
    builder.whole_fans()
    builder.cut_fans()
    return builder.result()


class _Builder:
    """Collects tangents as weights of edge vectors, fan by fan."""

    def __init__(self, nodes: FloatArray, quads: IntArray, mesh: QuadMesh, crease_angle: float) -> None:
        self.mesh = mesh
        self.n_nodes = len(nodes)
        self.count = quads.size
        corners = nodes[quads]
        areas = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2.0
        self.areas = np.repeat(areas, 4, axis=0)  # of the face on the left: mean normal x area
        self.edges = nodes[mesh.end] - nodes[mesh.start]
        self.lengths = np.linalg.norm(self.edges, axis=1)
        self.weights = self.lengths**-3
        unit = self.areas / np.linalg.norm(self.areas, axis=1)[:, None]
        sharp = (unit * unit[mesh.twin]).sum(axis=1) < np.cos(min(crease_angle + _TIE, np.pi))
        self.creased: BoolArray = sharp & (self._per_fan(sharp) > 1.0)
        self.left, self.right = np.zeros((self.count, 2)), np.zeros((self.count, 2))
        self.planar = np.zeros(self.count, dtype=bool)
        none = (np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0))
        self._entries: dict[str, list[tuple[IndexArray, IndexArray, FloatArray]]] = {"along": [none], "across": [none]}

    def result(self) -> Tangents:
        along, across = self._operator("along"), self._operator("across")
        return Tangents(self.creased, along, across, self.left, self.right, self.planar)

    def _operator(self, kind: str) -> sparse.csr_array:
        rows, edges, values = (np.concatenate(part) for part in zip(*self._entries[kind], strict=True))
        of_edges = sparse.csr_array((values, (rows, edges)), shape=(self.count, self.count))
        every, ones = np.arange(self.count), np.ones(self.count)
        ends, starts = (
            sparse.csr_array((ones, (every, nodes)), shape=(self.count, self.n_nodes))
            for nodes in (self.mesh.end, self.mesh.start)
        )
        return of_edges @ (ends - starts)

    def _add(self, kind: str, rows: IndexArray, edges: IndexArray, values: FloatArray) -> None:
        self._entries[kind].append((rows, edges, values))

    def _per_fan(self, values: FloatArray | BoolArray) -> FloatArray:
        """Sum over the fan of each half-edge; ``values`` (4 q, ...)."""
        flat = values.reshape(self.count, -1).T
        sums = [np.bincount(self.mesh.fan, weights=column, minlength=self.count)[self.mesh.fan] for column in flat]
        return np.asarray(np.stack(sums, axis=1).reshape(values.shape), dtype=np.float64)

    def whole_fans(self) -> None:
        """Tangents of all fans without creases at once."""
        normals = self._per_fan(self.areas)
        normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
        places = _flattened(self.edges, normals, self.lengths)
        aside = np.cross(normals, places)
        size = self._per_fan(np.ones(self.count))
        out_of_plane = normals[:, :, None] * normals[:, None, :]
        directions = places / self.lengths[:, None]
        spread = self._per_fan(directions[:, :, None] * directions[:, None, :]) + out_of_plane
        whole = self._per_fan(self.creased) == 0.0
        # For directions along two lines the determinant is (size / 2)^2 sin^2 of the angle between them.
        good = whole & (np.linalg.det(spread) > (size / 2.0 * _SLENDER) ** 2)
        moments = self._per_fan((self.weights[:, None] * places)[:, :, None] * places[:, None, :])
        # A moment along the normal makes the matrix regular and changes nothing in the plane.
        moments += np.trace(moments, axis1=1, axis2=2)[:, None, None] * out_of_plane
        chosen = np.flatnonzero(good)
        for kind, vectors in (("along", places), ("across", aside)):
            solved = np.linalg.solve(moments[chosen], vectors[chosen, :, None])[:, :, 0]
            row, other, turns = np.arange(len(chosen)), chosen, 0
            while len(row):
                values = self.weights[other] * (solved[row] * places[other]).sum(axis=1)
                self._add(kind, chosen[row], other, values)
                turns += 1
                more = size[other] > turns
                row, other = row[more], self.mesh.ccw[other[more]]
        for table, near in ((self.left, self.mesh.ccw), (self.right, self.mesh.cw)):
            parts = [(places[near[chosen]] * vectors[chosen]).sum(axis=1) for vectors in (aside, places)]
            table[chosen] = np.stack(parts, axis=1) / self.lengths[chosen, None] ** 2
        self.planar[chosen] = True
        plain = np.flatnonzero(whole & ~good)
        self._add("along", plain, plain, np.ones(len(plain)))

    def cut_fans(self) -> None:
        """Tangents of the fans that creases cut, one after the other."""
        for first in np.unique(self.mesh.fan[self.creased]):
            fan = np.array(self.mesh.around(int(first)))
            fan = np.roll(fan, -int(np.flatnonzero(self.creased[fan])[0]))
            creases = np.flatnonzero(self.creased[fan])
            rows, partner = crease_tangents(self.edges[fan], creases)
            for crease in creases:
                self._add("along", np.full(len(fan), fan[crease]), fan, rows[crease])
            for sector in crease_sectors(creases, len(fan)):
                if sector.inner:
                    self._sector(fan, sector, rows, partner[sector.first] == sector.last)

    def _sector(self, fan: IndexArray, sector: Sector, rows: FloatArray, smooth: bool) -> None:
        inner = fan[sector.inner]
        area = self.areas[fan[[sector.first, *sector.inner]]].sum(axis=0)
        gradient = sector_gradient(self.edges[fan], area, sector, rows, smooth)
        if gradient is None:
            self._add("along", inner, inner, np.ones(len(inner)))
            return
        for k, h in zip(sector.inner, inner, strict=True):
            x, y = gradient.places[k]
            every = np.full(len(fan), h)
            self._add("along", every, fan, x * gradient.rows[0] + y * gradient.rows[1])
            self._add("across", every, fan, x * gradient.rows[1] - y * gradient.rows[0])
            for table, near in ((self.left, (k + 1) % len(fan)), (self.right, k - 1)):
                a, b = gradient.places[near]
                table[h] = np.array([b * x - a * y, a * x + b * y]) / (x * x + y * y)
        self.planar[inner] = True


def _flattened(edges: FloatArray, normals: FloatArray, lengths: FloatArray) -> FloatArray:
    """Edges (k, 3) projected on the planes of the unit ``normals`` and stretched to their own lengths."""
    flat = edges - (edges * normals).sum(axis=1)[:, None] * normals
    result: FloatArray = flat * (lengths / np.maximum(np.linalg.norm(flat, axis=1), 1e-12 * lengths))[:, None]
    return result
