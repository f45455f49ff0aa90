"""Fibres multiply under refinement: new fibres run between neighbouring parallel fibres of a muscle.

Between two fibres (graph ``pairs``):
  two opposite edges of a face are segments        rung midpoint - face centre - rung midpoint
  parallel diagonals of two opposite faces are     rung midpoint - cell centre - rung midpoint
  parallel diagonals of two faces in line, which
  share an edge, are                               rung midpoint - midpoint of the shared edge - rung midpoint
Between four fibres (graph ``quartets``):
  four parallel edges of a hexahedron are          face centre - cell centre - face centre
  four parallel diagonals of two hexahedra in line rung face centre - centre of the shared face - rung face centre

The pieces are chained into maximal paths, cut where other than two pieces meet and between fibre ends, so that fibres
that meet at the midline stay two. Where fibres fan or branch, short pieces are left over; those shorter than half the
shortest old fibre are dropped, because activation grows with a fibre's own length.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import BoolArray, IntArray
from glossa.anatomy.muscle import Muscle
from glossa.anatomy.refined_mesh import RefinedMesh

_Pair = tuple[int, int]
_Triple = tuple[_Pair, _Pair, _Pair]
#: faces at the ends of the four edges that run along each local direction
_END_FACES = ((4, 5), (2, 3), (0, 1))
#: parallel diagonals (a, c) and (b, d) of opposite faces; a-b and c-d are edges
_PARALLEL_DIAGONALS = np.array(
    [
        [[0, 2], [4, 6]], [[1, 3], [5, 7]], [[0, 5], [3, 6]],
        [[1, 4], [2, 7]], [[0, 7], [1, 6]], [[4, 3], [5, 2]],
    ]
)  # fmt: skip


def refined_fibres(mesh: RefinedMesh, muscle: Muscle) -> list[IntArray]:
    """Old fibres with midpoints inserted, then the new fibres between them."""
    old = [mesh.with_midpoints(fibre) for fibre in muscle.fibres]
    segments = np.unique(np.sort(muscle.segments[:, :2], axis=1), axis=0)
    numbers = mesh.edge_numbers(segments)
    is_segment = np.zeros(len(mesh.edges), dtype=bool)
    is_segment[numbers[numbers >= 0]] = True
    diagonals = _Diagonals(mesh, segments[numbers < 0])
    pairs = [_between_edges(mesh, is_segment), diagonals.between_opposite(), diagonals.in_line()]
    quartets = [_between_four_edges(mesh, is_segment), diagonals.in_line_quartets()]
    is_end = np.zeros(mesh.n_nodes, dtype=bool)
    is_end[[fibre[end] for fibre in muscle.fibres for end in (0, -1)]] = True
    cuts = set(np.flatnonzero(mesh.inherited(is_end)).tolist())
    anchors = _Anchors(mesh, muscle, old)
    new = [anchors.attached(path) for kind in (pairs, quartets) for path in _chains(np.concatenate(kind), cuts)]
    shortest = min(_length(mesh, fibre) for fibre in old)
    return old + [fibre for fibre in new if _length(mesh, fibre) >= 0.5 * shortest]


def _length(mesh: RefinedMesh, path: IntArray) -> float:
    return float(np.linalg.norm(np.diff(mesh.fine_nodes[path], axis=0), axis=1).sum())


def _triples(first: NDArray[Any], middle: NDArray[Any], last: NDArray[Any]) -> IntArray:
    """(k, 3) pieces of new fibres: rung, middle, rung."""
    return np.stack([first, middle, last], axis=-1).astype(np.int32)


def _between_edges(mesh: RefinedMesh, is_segment: BoolArray) -> IntArray:
    found = is_segment[mesh.face_edges]
    pieces = []
    for side in (0, 1):
        face = np.flatnonzero(found[:, side] & found[:, side + 2])
        rungs = mesh.face_edges[face][:, [(side + 1) % 4, (side + 3) % 4]] + mesh.first_edge
        pieces.append(_triples(rungs[:, 0], face + mesh.first_face, rungs[:, 1]))
    return np.concatenate(pieces)


def _between_four_edges(mesh: RefinedMesh, is_segment: BoolArray) -> IntArray:
    found = np.all(is_segment[mesh.hex_edges].reshape(-1, 3, 4), axis=2)
    pieces = []
    for direction, (start, end) in enumerate(_END_FACES):
        cell = np.flatnonzero(found[:, direction])
        faces = mesh.hex_faces[cell] + mesh.first_face
        pieces.append(_triples(faces[:, start], cell + mesh.first_cell, faces[:, end]))
    return np.concatenate(pieces)


class _Diagonals:
    """Fibre segments that are face diagonals, and the new segments between them."""

    def __init__(self, mesh: RefinedMesh, segments: IntArray) -> None:
        self.mesh = mesh
        keys = hexa.pair_keys(segments, mesh.n_nodes)
        self.keys = set(keys.tolist())
        on_face = np.isin(hexa.pair_keys(mesh.faces[:, [[0, 2], [1, 3]]], mesh.n_nodes), keys)
        self.at_node: dict[int, list[tuple[int, int]]] = defaultdict(list)
        for face, which in np.argwhere(on_face).tolist():
            a, c = int(mesh.faces[face, which]), int(mesh.faces[face, which + 2])
            self.at_node[a].append((c, face))
            self.at_node[c].append((a, face))
        self._cells = self._cells_of_faces({face for found in self.at_node.values() for _, face in found})

    def _cells_of_faces(self, faces: set[int]) -> dict[int, list[int]]:
        wanted = np.zeros(len(self.mesh.faces), dtype=bool)
        wanted[list(faces)] = True
        cells: dict[int, list[int]] = defaultdict(list)
        for cell, local in np.argwhere(wanted[self.mesh.hex_faces]).tolist():
            cells[int(self.mesh.hex_faces[cell, local])].append(cell)
        return cells

    def between_opposite(self) -> IntArray:
        pairs = self.mesh.hexahedra[:, _PARALLEL_DIAGONALS]  # (m, 6, 2, 2)
        keys = hexa.pair_keys(pairs, self.mesh.n_nodes)
        both = np.isin(keys, np.fromiter(self.keys, dtype=np.int64)).all(axis=2)
        cell, which = np.nonzero(both)
        found = pairs[cell, which]  # (k, 2 diagonals, 2 ends)
        first, last = self.mesh.midpoints(found[:, :, 0]), self.mesh.midpoints(found[:, :, 1])
        return _triples(first, cell + self.mesh.first_cell, last)

    def _shifted(self) -> Iterator[tuple[int, int, int, int, int, int]]:
        """Faces f1, f2 in line with diagonals p-q and r-s; r-q is their shared edge, p-r and q-s are the rungs."""
        corners = [set(face) for face in self.mesh.faces.tolist()] if self.keys else []
        for q, diagonals in self.at_node.items():
            for p, f1 in diagonals:
                for r in corners[f1] - {p, q}:
                    for s, f2 in self.at_node.get(r, []):
                        if f1 != f2 and q in corners[f2] and not set(self._cells[f1]) & set(self._cells[f2]):
                            yield f1, f2, p, q, r, s

    def in_line(self) -> IntArray:
        return self._three_points([((p, r), (r, q), (q, s)) for _, _, p, q, r, s in self._shifted()])

    def in_line_quartets(self) -> IntArray:
        return self._three_points([triple for shifted in self._shifted() for triple in self._quartets(*shifted)])

    def _quartets(self, f1: int, f2: int, p: int, q: int, r: int, s: int) -> Iterator[_Triple]:
        """Pairs across which the new fibre runs, where the same two diagonals stand on the opposite faces too."""
        for h1 in self._cells[f1]:
            across1 = self._across(h1, f1)
            for h2 in self._cells[f2]:
                across2 = self._across(h2, f2)
                if across1[r] != across2[r] or across1[q] != across2[q]:
                    continue
                if self._is_diagonal(across1[p], across1[q]) and self._is_diagonal(across2[r], across2[s]):
                    yield (p, across1[r]), (r, across1[q]), (q, across2[s])

    def _is_diagonal(self, a: int, b: int) -> bool:
        return min(a, b) * self.mesh.n_nodes + max(a, b) in self.keys

    def _across(self, cell: int, face: int) -> dict[int, int]:
        """Corner of ``face`` -> the corner of the opposite face of ``cell`` joined to it by an edge."""
        inside = set(self.mesh.faces[face].tolist())
        across = {}
        for a, b in self.mesh.hexahedra[cell][hexa.EDGES].tolist():
            if (a in inside) != (b in inside):
                across[a if a in inside else b] = b if a in inside else a
        return across

    def _three_points(self, triples: list[_Triple]) -> IntArray:
        if not triples:
            return np.zeros((0, 3), dtype=np.int32)
        points = self.mesh.midpoints(np.array(triples, dtype=np.int32))
        return _triples(points[:, 0], points[:, 1], points[:, 2])


def _chains(triples: IntArray, cuts: set[int]) -> list[list[int]]:
    """Maximal paths over pieces (k, 3), cut where other than two segments meet and at the rungs among ``cuts``."""
    cuts = cuts - set(triples[:, 1].tolist())
    segments = np.concatenate([triples[:, :2], triples[:, 1:]])
    neighbours: dict[int, list[int]] = defaultdict(list)
    for a, b in np.unique(np.sort(segments, axis=1), axis=0).tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    used: set[tuple[int, int]] = set()
    paths: list[list[int]] = []
    ends = {node for node, others in neighbours.items() if len(others) != 2 or node in cuts}
    for start in [*sorted(ends), *sorted(neighbours)]:  # the second part finds closed loops
        paths.extend(
            _walk(neighbours, used, ends, [start, following])
            for following in neighbours[start]
            if (start, following) not in used
        )
    return paths


def _walk(neighbours: dict[int, list[int]], used: set[tuple[int, int]], ends: set[int], path: list[int]) -> list[int]:
    """Extend ``path`` (two nodes) to the next end, or around a closed loop."""
    start, following = path
    used.update([(start, following), (following, start)])
    while path[-1] not in ends and path[-1] != start:
        a, b = neighbours[path[-1]]
        step = b if a == path[-2] else a
        used.update([(path[-1], step), (step, path[-1])])
        path.append(step)
    return path


class _Anchors:
    """Ties of the old fibres to outside points, from which new fibres take theirs."""

    def __init__(self, mesh: RefinedMesh, muscle: Muscle, old: list[IntArray]) -> None:
        self.mesh = mesh
        in_mesh = np.zeros(mesh.n_nodes, dtype=bool)
        in_mesh[mesh.hexahedra] = True
        self.outside_of: dict[int, set[int]] = defaultdict(set)
        self.tails: dict[int, list[int]] = {}
        for fibre, refined in zip(muscle.fibres, old, strict=True):
            for path, fine in ((fibre.tolist(), refined.tolist()), (fibre.tolist()[::-1], refined.tolist()[::-1])):
                if in_mesh[path[-1]]:
                    continue
                if in_mesh[path[-2]]:
                    self.outside_of[path[-2]].add(path[-1])
                for position, node in enumerate(fine[:-1]):
                    self.tails.setdefault(node, fine[position + 1 :])

    def attached(self, path: list[int]) -> IntArray:
        """The path continued at both ends to the outside point its neighbours are tied to."""
        if not self.outside_of:
            return np.array(path, dtype=np.int32)
        return np.array([*self._tail(path[0])[::-1], *path, *self._tail(path[-1])], dtype=np.int32)

    def _tail(self, node: int) -> list[int]:
        """An outside point shared by all parents of ``node``; else the rest of an old fibre that ``node`` lies on."""
        shared = self._common(self.mesh.parents(node))
        return [min(shared)] if shared else self.tails.get(node, [])

    def _common(self, parents: Iterable[int]) -> set[int]:
        return set.intersection(*(self.outside_of.get(parent, set()) for parent in parents))
