"""Checks of a speaker at construction. Each failure names what, where, and what to do."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import FloatArray, IntArray, frozen, int_array
from glossa.anatomy.muscle import Muscle
from glossa.anatomy.walls import Hyoid, Wall
from glossa.errors import InputError


def check_hexahedra(nodes: FloatArray, hexahedra: IntArray) -> None:
    """At least one element, known nodes, eight different corners, no element twice."""
    if len(nodes) == 0 or len(hexahedra) == 0:
        raise InputError(f"a body needs nodes and hexahedra; got {len(nodes)} nodes and {len(hexahedra)} hexahedra")
    unknown = np.flatnonzero((hexahedra >= len(nodes)).any(axis=1))
    if len(unknown):
        e = int(unknown[0])
        raise InputError(
            f"hexahedron {e} names node {hexahedra[e].max()}, but there are {len(nodes)} nodes (0..{len(nodes) - 1})"
        )
    corners = np.sort(hexahedra, axis=1)
    repeated = np.argwhere(corners[:, 1:] == corners[:, :-1])
    if len(repeated):
        e, k = (int(i) for i in repeated[0])
        raise InputError(f"hexahedron {e} names node {corners[e, k]} more than once; its eight corners must differ")
    order = np.lexsort(corners.T)
    twice = np.flatnonzero((corners[order][1:] == corners[order][:-1]).all(axis=1))
    if len(twice):
        a, b = sorted((int(order[twice[0]]), int(order[twice[0] + 1])))
        raise InputError(f"hexahedra {a} and {b} have the same eight nodes; remove one of them")


def check_jacobians(nodes: FloatArray, hexahedra: IntArray) -> None:
    """Positive Jacobian determinant at the 8 corners and the 8 Gauss points of every hexahedron."""
    worst_corner = hexa.corner_determinants(nodes, hexahedra)
    worst_gauss = hexa.gauss_determinants(nodes, hexahedra)
    worst = np.minimum(worst_corner.min(axis=1), worst_gauss.min(axis=1))
    e = int(worst.argmin())
    if worst[e] > 0.0:
        return
    corner = int(worst_corner[e].argmin())
    where = "a Gauss point"
    if worst_corner[e, corner] <= worst_gauss[e].min():
        where = f"corner {corner} (node {hexahedra[e, corner]})"
    number = int((worst <= 0.0).sum())
    advice = (
        "the corners are not in VTK order (bottom face 0 1 2 3 counter-clockwise seen from the top face 4 5 6 7)"
        if (worst_gauss[e] <= 0.0).all()
        else "the element is too distorted; move its nodes"
    )
    raise InputError(
        f"hexahedron {e} has Jacobian determinant {worst[e]:.3g} m3 at {where}; it must be positive: {advice}. "
        f"{number} of {len(hexahedra)} hexahedra fail"
    )


def checked_muscles(muscles: Any, nodes: FloatArray, n_elements: int) -> Mapping[str, Muscle]:
    """Read-only copy; known elements and nodes, no element twice, no segment of zero length."""
    result = _named(muscles, "muscles")
    for name, muscle in result.items():
        if not isinstance(muscle, Muscle):
            raise InputError(f"muscle {name!r} must be a Muscle, got {type(muscle).__name__}")
        _check_muscle(name, muscle, nodes, n_elements)
    return MappingProxyType(result)


def _check_muscle(name: str, muscle: Muscle, nodes: FloatArray, n_elements: int) -> None:
    if muscle.elements.max() >= n_elements:
        raise InputError(
            f"muscle {name!r} names element {muscle.elements.max()}, but there are {n_elements} hexahedra "
            f"(0..{n_elements - 1})"
        )
    values, counts = np.unique(muscle.elements, return_counts=True)
    if counts.max() > 1:
        raise InputError(f"muscle {name!r} names element {values[counts.argmax()]} more than once")
    pieces = muscle.segments
    unknown = np.flatnonzero((pieces[:, :2] >= len(nodes)).any(axis=1))
    if len(unknown):
        piece = pieces[unknown[0]]
        raise InputError(
            f"muscle {name!r}, fibre {piece[2]} names node {piece[:2].max()}, but there are {len(nodes)} nodes "
            f"(0..{len(nodes) - 1})"
        )
    repeated = np.flatnonzero(pieces[:, 0] == pieces[:, 1])
    if len(repeated):
        piece = pieces[repeated[0]]
        raise InputError(f"muscle {name!r}, fibre {piece[2]} names node {piece[0]} twice in a row; name it once")
    lengths = np.linalg.norm(nodes[pieces[:, 1]] - nodes[pieces[:, 0]], axis=1)
    if lengths.min() <= 0.0:
        piece = pieces[lengths.argmin()]
        raise InputError(
            f"muscle {name!r}, fibre {piece[2]}: nodes {piece[0]} and {piece[1]} are at the same place "
            f"(segment of zero length)"
        )


def check_orphans(nodes: FloatArray, hexahedra: IntArray, muscles: Mapping[str, Muscle]) -> None:
    """Every node is a corner of a hexahedron or a point of a fibre."""
    used = np.zeros(len(nodes), dtype=bool)
    used[hexahedra] = True
    for muscle in muscles.values():
        used[muscle.segments[:, :2]] = True
    orphans = np.flatnonzero(~used)
    if len(orphans):
        raise InputError(
            f"node {orphans[0]} belongs to no hexahedron and no fibre ({len(orphans)} such node(s)); "
            f"remove it or pass a fibre through it"
        )


def checked_node_sets(node_sets: Any, n_nodes: int) -> Mapping[str, IntArray]:
    """Read-only copy; known nodes, none twice."""
    result = {
        name: _known_nodes(nodes, f"node set {name!r}", n_nodes)
        for name, nodes in _named(node_sets, "node_sets").items()
    }
    for name, nodes in result.items():
        values, counts = np.unique(nodes, return_counts=True)
        if len(counts) and counts.max() > 1:
            raise InputError(f"node set {name!r} names node {values[counts.argmax()]} more than once")
    return MappingProxyType(result)


def checked_contours(contours: Any, n_nodes: int) -> Mapping[str, IntArray]:
    """Read-only copy; known nodes, none twice in a row."""
    result = {
        name: _known_nodes(nodes, f"contour {name!r}", n_nodes) for name, nodes in _named(contours, "contours").items()
    }
    for name, nodes in result.items():
        repeated = np.flatnonzero(nodes[1:] == nodes[:-1])
        if len(repeated):
            raise InputError(f"contour {name!r} names node {nodes[repeated[0]]} twice in a row; name it once")
    return MappingProxyType(result)


def checked_walls(walls: Any) -> Mapping[str, Wall]:
    """Read-only copy; every value a Wall."""
    result = _named(walls, "walls")
    for name, wall in result.items():
        if not isinstance(wall, Wall):
            raise InputError(f"wall {name!r} must be a Wall, got {type(wall).__name__}")
    return MappingProxyType(result)


def checked_contact_faces(
    contact_faces: Any, walls: Mapping[str, Wall], hexahedra: IntArray, n_nodes: int
) -> Mapping[str, IntArray]:
    """Read-only copy, faces turned outwards; known walls, boundary faces only, none twice for one wall."""
    result: dict[str, IntArray] = {}
    named = _named(contact_faces, "contact_faces")
    boundary = hexa.boundary_quads(hexahedra, n_nodes) if named else hexahedra[:0, :4]
    for name, faces in named.items():
        if name not in walls:
            known = ", ".join(walls) or "none"
            raise InputError(f"contact_faces: there is no wall {name!r}; this speaker has {known}")
        what = f"contact faces of wall {name!r}"
        quads = int_array(faces, what, 4)
        for position in np.flatnonzero((quads >= n_nodes).any(axis=1))[:1]:
            raise InputError(
                f"{what}, face {position} names node {quads[position].max()}, but there are {n_nodes} nodes "
                f"(0..{n_nodes - 1})"
            )
        number = hexa.matching_faces(quads, boundary)
        for position in np.flatnonzero(number < 0)[:1]:
            raise InputError(
                f"{what}, face {position}: the nodes {quads[position].tolist()} are not the corners of a boundary face "
                f"of the body (see Speaker.surface_quads)"
            )
        values, first = np.unique(number, return_index=True)
        for position in np.setdiff1d(np.arange(len(number)), first)[:1]:
            earlier = int(first[values == number[position]][0])
            raise InputError(f"{what}: faces {earlier} and {position} are the same; name it once")
        result[name] = frozen(np.ascontiguousarray(boundary[number]))
    return MappingProxyType(result)


def check_hyoid_and_name(hyoid: Any, name: Any) -> None:
    """A Hyoid or None; a string."""
    if hyoid is not None and not isinstance(hyoid, Hyoid):
        raise InputError(f"hyoid must be a Hyoid or None, got {type(hyoid).__name__}")
    if not isinstance(name, str):
        raise InputError(f"name must be a string, got {type(name).__name__}")


def _named(mapping: Any, what: str) -> dict[str, Any]:
    if not isinstance(mapping, Mapping):
        raise InputError(f"{what} must be a mapping from names to values, got {type(mapping).__name__}")
    for name in mapping:
        if not isinstance(name, str) or not name:
            raise InputError(f"{what}: names must be non-empty strings, got {name!r}")
    return dict(mapping)


def _known_nodes(nodes: Any, what: str, n_nodes: int) -> IntArray:
    indices = int_array(nodes, what)
    if len(indices) and indices.max() >= n_nodes:
        raise InputError(f"{what} names node {indices.max()}, but there are {n_nodes} nodes (0..{n_nodes - 1})")
    return indices
