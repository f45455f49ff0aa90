"""A body's surface as it is: bilinear faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from glossa.anatomy.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class FacetSurface:
    """Bilinear faces; parameters (u, v) as in :class:`glossa.anatomy.smooth_surface.SmoothSurface`.

    Attributes:
        nodes: (n, 3) m, at rest.
        quads: (q, 4) node indices, normals outwards.
    """

    nodes: FloatArray
    quads: IntArray

    def operator(self, faces: IntArray, u: FloatArray, v: FloatArray) -> sparse.csr_array:
        """(k, n) weights of the nodes at the points (u, v) of ``faces``."""
        weights = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
        rows = np.repeat(np.arange(len(faces)), 4)
        result = sparse.csr_array(
            (weights.ravel(), (rows, self.quads[faces].ravel())), shape=(len(faces), len(self.nodes))
        )
        result.sort_indices()
        return result

    def area_vectors(self, faces: IntArray, u: FloatArray, v: FloatArray) -> FloatArray:
        """(k, 3) m2 per unit of u and v: outward normal at rest, as long as the area it stands for."""
        a, b, c, d = np.moveaxis(self.nodes[self.quads[faces]], 1, 0)
        by_u = (1 - v)[:, None] * (b - a) + v[:, None] * (c - d)
        by_v = (1 - u)[:, None] * (d - a) + u[:, None] * (c - b)
        return np.asarray(np.cross(by_u, by_v))
