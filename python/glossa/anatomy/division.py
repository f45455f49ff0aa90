"""A body and the same body with every hexahedron divided in eight: what lies where, and fields carried over."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.refined_mesh import RefinedMesh
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError

TOLERANCE = 1e-9
"""Distance between a node and the same node of the finer body, m: rounding."""


class Division:
    """Where nodes and hexahedra of a body are in a finer one; n nodes, m hexahedra, N nodes of the finer body.

    The finer body holds the nodes of the coarse one where they are, in any order. Its new nodes need not lie in the
    middle between them, where :meth:`Speaker.refined` has them: they are found by what they are joined to.

    Args:
        coarse: a body.
        finer: the same, every hexahedron divided in eight.

    Attributes:
        nodes: (n,) numbers in the finer body.
        children: (m, 8) hexahedra of the finer body in each hexahedron.

    Raises:
        InputError: ``finer`` is another body, or divided otherwise.
    """

    nodes: IntArray
    children: IntArray

    def __init__(self, coarse: Speaker, finer: Speaker) -> None:
        self._mesh = mesh = RefinedMesh(coarse.nodes, coarse.hexahedra)
        cells, count = mesh.fine_hexahedra, mesh.first_cell + len(mesh.hexahedra)
        if len(finer.nodes) != count or len(finer.hexahedra) != len(cells):
            raise InputError(
                f"finer: {coarse.name or 'the speaker'!r} with every hexahedron divided in eight has {len(cells)} "
                f"hexahedra and {count} nodes, got {len(finer.hexahedra)} and {len(finer.nodes)}"
            )
        away, self.nodes = cKDTree(finer.nodes).query(coarse.nodes)
        if away.max() > TOLERANCE:
            raise InputError(
                f"finer: no node at that of node {away.argmax()} of {coarse.name or 'the speaker'!r}; this is another "
                "body"
            )
        joined = _joined(finer)
        edges = _between(joined, self.nodes[mesh.edges])
        faces = _between(joined, edges[mesh.face_edges])
        middles = _between(joined, faces[mesh.hex_faces])
        self._node = np.concatenate([self.nodes, edges, faces, middles]).astype(np.int32)
        mine, theirs = np.sort(self._node[cells], axis=1), np.sort(finer.hexahedra, axis=1)
        order, other = np.lexsort(mine.T), np.lexsort(theirs.T)
        if not np.array_equal(mine[order], theirs[other]):
            raise _other_division()
        child = np.empty(len(cells), dtype=np.int32)
        child[order] = other
        self.children = child.reshape(-1, 8)

    def carried(self, field: FloatArray) -> FloatArray:
        """(N, …) values at the nodes of the finer body: trilinear between those at the nodes (n, …)."""
        mesh = self._mesh
        means = [field[parents].mean(axis=1) for parents in (mesh.edges, mesh.faces, mesh.hexahedra)]
        result = np.empty((len(self._node), *field.shape[1:]))
        result[self._node] = np.concatenate([field, *means])
        return result

    def inherited(self, values: FloatArray) -> FloatArray:
        """(8 m,) values of the finer body's hexahedra: those of the hexahedra (m,) that they divide."""
        result = np.empty(8 * len(values))
        result[self.children] = values[:, None]
        return result


def _joined(speaker: Speaker) -> sparse.csr_array:
    """(N, N) one where an edge joins two nodes."""
    pairs = np.unique(np.sort(speaker.hexahedra[:, hexa.EDGES].reshape(-1, 2), axis=1), axis=0)
    both = np.concatenate([pairs, pairs[:, ::-1]])
    size = len(speaker.nodes)
    return sparse.csr_array((np.ones(len(both), np.int32), both.T), shape=(size, size))


def _between(joined: sparse.csr_array, around: IntArray) -> IntArray:
    """(k,) the node that edges join to each of the nodes ``around`` (k, c)."""
    rows = np.repeat(np.arange(len(around)), around.shape[1])
    chosen = sparse.csr_array(
        (np.ones(around.size, np.int32), (rows, around.ravel())), shape=(len(around), joined.shape[0])
    )
    counts = sparse.coo_array(chosen @ joined)
    row, node = (index[counts.data == around.shape[1]] for index in counts.coords)
    order = np.argsort(row, kind="stable")
    if not np.array_equal(row[order], np.arange(len(around))):
        raise _other_division()
    return np.asarray(node[order], dtype=np.int32)


def _other_division() -> InputError:
    return InputError("finer: this is not the same body with every hexahedron divided in eight")
