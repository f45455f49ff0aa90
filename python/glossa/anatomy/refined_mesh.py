"""A hexahedral mesh and its division in eight: edges, faces, cells and the nodes they become."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray


class RefinedMesh:
    """Numbering of the refined mesh: old nodes, then edge midpoints, face centres, cell centres.

    Attributes:
        hexahedra: (m, 8) of the coarse mesh.
        edges: (e, 2) distinct edges; hex_edges: (m, 12) in the order of hexahedra.EDGES.
        faces: (f, 4) distinct faces, cyclic corners; hex_faces: (m, 6) in the order of hexahedra.FACES.
        first_edge, first_face, first_cell: number of the first new node of each kind.
    """

    def __init__(self, nodes: FloatArray, hexahedra: IntArray) -> None:
        self.nodes = nodes
        self.hexahedra = hexahedra
        self.n_nodes = len(nodes)
        edge_pairs = hexahedra[:, hexa.EDGES].reshape(-1, 2)
        self._edge_keys, first, inverse = np.unique(
            hexa.pair_keys(edge_pairs, self.n_nodes), return_index=True, return_inverse=True
        )
        self.edges: IntArray = edge_pairs[first]
        self.hex_edges = inverse.reshape(-1, 12)
        all_faces, keys = hexa.face_keys(hexahedra, self.n_nodes)
        _, first, inverse = np.unique(keys.ravel(), return_index=True, return_inverse=True)
        self.faces: IntArray = all_faces.reshape(-1, 4)[first]
        self.hex_faces = inverse.reshape(-1, 6)
        self.first_edge = self.n_nodes
        self.first_face = self.first_edge + len(self.edges)
        self.first_cell = self.first_face + len(self.faces)

    @cached_property
    def fine_nodes(self) -> FloatArray:
        """(n + e + f + m, 3) m."""
        means = [self.nodes[parents].mean(axis=1) for parents in (self.edges, self.faces, self.hexahedra)]
        return np.concatenate([self.nodes, *means])

    @cached_property
    def fine_hexahedra(self) -> IntArray:
        """(8 m, 8); the children of hexahedron e are 8 e .. 8 e + 7, in the order of its corners."""
        lattice = self._lattice()
        result = np.empty((len(self.hexahedra), 8, 8), dtype=np.int32)
        offsets = ((hexa.CORNERS + 1) // 2).astype(int)
        for child, base in enumerate(offsets):
            a, b, c = (base + offsets).T
            result[:, child] = lattice[:, a, b, c]
        return result.reshape(-1, 8)

    def _lattice(self) -> NDArray[np.int64]:
        """(m, 3, 3, 3) new node numbers on the 3 x 3 x 3 lattice of each hexahedron."""
        position = (hexa.CORNERS + 1).astype(int)  # 0 or 2 along each axis
        lattice = np.empty((len(self.hexahedra), 3, 3, 3), dtype=np.int64)
        for corner, (a, b, c) in enumerate(position):
            lattice[:, a, b, c] = self.hexahedra[:, corner]
        for number, pair in enumerate(hexa.EDGES):
            a, b, c = position[pair].sum(axis=0) // 2
            lattice[:, a, b, c] = self.first_edge + self.hex_edges[:, number]
        for number, face in enumerate(hexa.FACES):
            a, b, c = position[face].sum(axis=0) // 4
            lattice[:, a, b, c] = self.first_face + self.hex_faces[:, number]
        lattice[:, 1, 1, 1] = self.first_cell + np.arange(len(self.hexahedra))
        return lattice

    def children(self, elements: IntArray) -> IntArray:
        """(8 k,) fine elements of the coarse ``elements`` (k,)."""
        return (8 * elements[:, None] + np.arange(8)).ravel().astype(np.int32)

    def inherited(self, member: BoolArray) -> BoolArray:
        """(n + e + f + m,) who has a property: old nodes by ``member`` (n,), new ones if all parents have it."""
        new = [member[parents].all(axis=1) for parents in (self.edges, self.faces, self.hexahedra)]
        return np.concatenate([member, *new])

    def parents(self, node: int) -> list[int]:
        """The old nodes whose mean a new node is."""
        kinds = ((self.first_cell, self.hexahedra), (self.first_face, self.faces), (self.first_edge, self.edges))
        for first, parents in kinds:
            if node >= first:
                return [int(parent) for parent in parents[node - first]]
        return [node]

    @cached_property
    def face_edges(self) -> IntArray:
        """(f, 4) edge numbers, edge c between the corners c and c + 1 of the face."""
        return self.edge_numbers(np.stack([self.faces, np.roll(self.faces, -1, axis=1)], axis=2))

    def face_children(self, quads: IntArray) -> IntArray:
        """(4 k, 4) fine faces of the coarse faces ``quads`` (k, 4), four after each other, same side outwards.

        Child c of a face holds its corner c, then runs round as the face does.
        """
        number = hexa.matching_faces(quads, self.faces)
        edges = self.first_edge + self.edge_numbers(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2))
        centres = np.repeat((self.first_face + number)[:, None], 4, axis=1)
        children = np.stack([quads, edges, centres, np.roll(edges, 1, axis=1)], axis=2)
        return children.reshape(-1, 4).astype(np.int32)

    def edge_numbers(self, pairs: IntArray) -> IntArray:
        """Edge numbers of node pairs (..., 2); -1 where the pair is no edge."""
        keys = hexa.pair_keys(pairs, self.n_nodes)
        found = np.minimum(np.searchsorted(self._edge_keys, keys), len(self._edge_keys) - 1)
        return np.where(self._edge_keys[found] == keys, found, -1).astype(np.int32)

    @cached_property
    def _midpoints(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Sorted pair keys of edges, face diagonals and body diagonals, and the new node between each pair."""
        diagonals = self.faces[:, [[0, 2], [1, 3]]]
        bodies = self.hexahedra[:, hexa.BODY_DIAGONALS]
        keys = np.concatenate(
            [
                self._edge_keys,
                hexa.pair_keys(diagonals, self.n_nodes).ravel(),
                hexa.pair_keys(bodies, self.n_nodes).ravel(),
            ]
        )
        between = np.concatenate(
            [
                self.first_edge + np.arange(len(self.edges)),
                np.repeat(self.first_face + np.arange(len(self.faces)), 2),
                np.repeat(self.first_cell + np.arange(len(self.hexahedra)), 4),
            ]
        )
        order = np.argsort(keys, kind="stable")
        return keys[order], between[order]

    def midpoints(self, pairs: IntArray) -> IntArray:
        """New node between two nodes of one hexahedron, for pairs (..., 2); -1 where no hexahedron has both.

        Edge: its midpoint; face diagonal: the face centre; body diagonal: the cell centre.
        """
        keys, between = self._midpoints
        wanted = hexa.pair_keys(np.asarray(pairs), self.n_nodes)
        found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        return np.where(keys[found] == wanted, between[found], -1).astype(np.int32)

    def with_midpoints(self, path: IntArray) -> IntArray:
        """A node list with the new nodes between consecutive nodes inserted where there are such."""
        if len(path) < 2:
            return path
        result = np.full(2 * len(path) - 1, -1, dtype=np.int32)
        result[::2] = path
        result[1::2] = self.midpoints(np.stack([path[:-1], path[1:]], axis=1))
        return result[result >= 0]
