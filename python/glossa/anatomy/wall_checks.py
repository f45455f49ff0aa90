"""Checks of a wall that the tongue may touch. Each failure names the wall, the place, and what to do."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from glossa import _core
from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray, frozen, place_mm
from glossa.anatomy.walls import Wall
from glossa.errors import InputError

WELDING_DISTANCE = 1e-7
"""Vertices nearer than this are one, m."""

LEAST_AREA = 1e-12
"""Of a triangle, m2."""

LEAST_HEIGHT = 1e-7
"""Of a triangle over its longest side, m."""

FACING_DISTANCE = 8e-3
"""A wall is checked where a point of the tongue at rest is nearer than this, m."""

DEEPEST_OVERLAP = 2e-3
"""By which the tongue at rest may overlap a wall, m."""

TOUCHING = 1e-5
"""Points nearer to a wall than this are on neither side of it, m."""

INTERIOR, _RIM, _INCONSISTENT = 0, 1, 2  # kinds of _core.nearest_features


def check_wall(name: str, wall: Wall) -> None:
    """A surface whose triangles have an area and meet two by two.

    Open walls and walls of several pieces are allowed, and so are faces that run the other way round than their
    neighbours, as long as the tongue does not face them (check_facing).

    Raises:
        InputError: a triangle without area, the same triangle twice, or an edge of three triangles and more.
    """
    triangles = welded_triangles(wall)
    _check_triangles(name, wall, triangles)
    _check_twice(name, wall, triangles)
    edges, of_side, count = triangle_edges(triangles)
    if count.max() > 2:
        edge = int(count.argmax())
        owners = np.flatnonzero((of_side == edge).any(axis=1))
        raise InputError(
            f"wall {name!r}: the edge at {place_mm(wall.vertices[edges[edge]].mean(axis=0))} belongs to "
            f"{count[edge]} triangles ({', '.join(map(str, owners))}); a surface has one or two at each edge: remove "
            f"the inner or the double ones, or split the wall in two"
        )


def check_facing(name: str, wall: Wall, points: FloatArray, directions: FloatArray | None = None) -> None:
    """Where the tongue faces it the wall has one side and no holes, and the tongue is in front of it.

    Args:
        name: of the wall, for messages.
        wall: accepted by check_wall.
        points: (k, 3) m, points of the tongue at rest that may touch the wall; a hole or a turned face far smaller
            than their distance from each other can be missed.
        directions: (k, 3) outward normals of the tongue there. With them a wall whose normals are reversed is told
            from a tongue that is behind the wall; without them the wall is blamed where most points are behind it.

    Raises:
        InputError: near a point the faces run different ways round, or there is a hole; the normals point away from
            the tongue; or the tongue starts behind the wall by more than DEEPEST_OVERLAP.
    """
    points = np.ascontiguousarray(points, dtype=np.float64)
    if len(points) == 0:
        return
    distances, nearest, kinds, loops = _core.nearest_features(wall.vertices, wall.triangles, points)
    near = np.abs(distances) < FACING_DISTANCE
    looked_at = near | (distances < -DEEPEST_OVERLAP)
    _check_orientation(name, wall, nearest[looked_at], kinds[looked_at] == _INCONSISTENT)
    _check_holes(name, wall, np.unique(loops[near & (kinds == _RIM)]))
    sided = kinds == INTERIOR
    if sided.any():
        against = None if directions is None else _against(wall, nearest[sided], np.asarray(directions)[sided])
        _check_side(name, points[sided], distances[sided], against)


@lru_cache(maxsize=16)
def welded_triangles(wall: Wall) -> IntArray:
    """(m, 3) triangles of a wall; vertices nearer than WELDING_DISTANCE carry the number of the first of them."""
    pairs = cKDTree(wall.vertices).query_pairs(WELDING_DISTANCE, output_type="ndarray")
    n = len(wall.vertices)
    links = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    _, cluster = connected_components(links, directed=False)
    _, first = np.unique(cluster, return_index=True)
    return frozen(np.asarray(first[cluster][wall.triangles], dtype=np.int32))


def triangle_normals(corners: FloatArray) -> FloatArray:
    """(m, 3) normals of triangles with ``corners`` (m, 3, 3), as long as twice their areas."""
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.asarray(np.cross(b - a, c - a))


def _check_triangles(name: str, wall: Wall, triangles: IntArray) -> None:
    corners = wall.vertices[triangles]
    sides = corners[:, [1, 2, 0]] - corners
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    repeated = (triangles == triangles[:, [1, 2, 0]]).any(axis=1)
    needle = 2.0 * area < LEAST_HEIGHT * longest
    bad = np.flatnonzero(repeated | needle | (area < LEAST_AREA))
    if len(bad) == 0:
        return
    t = int(bad[0])
    fault = "two of its corners are at the same place" if repeated[t] else f"its area is {area[t] * 1e6:.2g} mm2"
    raise InputError(
        f"wall {name!r}: triangle {t} at {place_mm(corners[t].mean(axis=0))} is degenerate: {fault}; remove it or move "
        f"its corners ({len(bad)} of {len(triangles)} triangles are degenerate)"
    )


def _check_twice(name: str, wall: Wall, triangles: IntArray) -> None:
    corners = np.sort(triangles, axis=1)
    order = np.lexsort(corners.T)
    twice = np.flatnonzero((corners[order][1:] == corners[order][:-1]).all(axis=1))
    if len(twice):
        a, b = sorted((int(order[twice[0]]), int(order[twice[0] + 1])))
        raise InputError(
            f"wall {name!r}: triangles {a} and {b} at {place_mm(wall.vertices[triangles[a]].mean(axis=0))} have "
            f"the same three corners; remove one of them"
        )


def _check_orientation(name: str, wall: Wall, nearest: IntArray, on_turned_edge: BoolArray) -> None:
    triangles = welded_triangles(wall)
    turned = np.asarray(_inconsistent_sides(triangles).any(axis=1))
    bad = np.flatnonzero(on_turned_edge | turned[nearest])
    if len(bad) == 0:
        return
    t = int(nearest[bad[0]])
    raise InputError(
        f"wall {name!r}: at {place_mm(wall.vertices[triangles[t]].mean(axis=0))}, where the tongue faces it, triangle "
        f"{t} and a neighbour run different ways round, so that the wall has no side; reverse the order of corners of "
        f"the turned faces, so that all normals point towards the tongue ({int(turned.sum())} of {len(triangles)} "
        f"triangles border on such an edge)"
    )


def _check_holes(name: str, wall: Wall, loops: IntArray) -> None:
    if len(loops) == 0:
        return
    rims = _core.rim_loops(wall.vertices, wall.triangles)
    for points, _, outer in (rims[number] for number in loops):
        if not outer:
            raise InputError(
                f"wall {name!r} has a hole of {np.ptp(points, axis=0).max() * 1e3:.1f} mm ({len(points)} edges) at "
                f"{place_mm(points.mean(axis=0))}, where the tongue faces it; close it, or keep the tongue's faces "
                f"there out of contact_faces"
            )


def _against(wall: Wall, nearest: IntArray, directions: FloatArray) -> BoolArray:
    """(k,) whether the tongue's normal turns against the wall's, as it does where the two face each other."""
    a, b, c = (wall.vertices[wall.triangles[nearest, k]] for k in range(3))
    return np.asarray((np.cross(b - a, c - a) * directions).sum(axis=1) < 0.0)


def _check_side(name: str, points: FloatArray, distances: FloatArray, against: BoolArray | None) -> None:
    near = np.abs(distances) < FACING_DISTANCE
    judged = near if near.any() else np.ones(len(points), dtype=bool)
    behind = judged & (distances < -TOUCHING)
    reversed_normals = 2 * behind.sum() > judged.sum()
    if against is not None:
        reversed_normals &= 2 * against[behind].sum() < behind.sum()
    worst = int(distances.argmin())
    where = f"{-distances[worst] * 1e3:.1f} mm at {place_mm(points[worst])}"
    if reversed_normals:
        raise InputError(
            f"wall {name!r}: {int(behind.sum())} of the {int(judged.sum())} points of the tongue nearest to it lie "
            f"behind it, up to {where}; its normals must point towards the tongue: reverse the order of corners of "
            f"its faces"
        )
    deep = int((distances < -DEEPEST_OVERLAP).sum())
    if deep:
        raise InputError(
            f"wall {name!r}: the tongue at rest starts behind it at {deep} of {len(points)} points, up to {where}; "
            f"at most {DEEPEST_OVERLAP * 1e3:g} mm can be cleared: move the wall or the tongue, or name in "
            f"contact_faces of the speaker which faces may touch it"
        )


def triangle_edges(triangles: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Edges (k, 2), number of the edge of each side (m, 3), and how many sides each edge has (k,)."""
    ends = np.sort(np.stack([triangles, triangles[:, [1, 2, 0]]], axis=2).reshape(-1, 2).astype(np.int64), axis=1)
    vertices = int(triangles.max(initial=0)) + 1
    keys, of_side, count = np.unique(ends[:, 0] * vertices + ends[:, 1], return_inverse=True, return_counts=True)
    edges = np.stack([keys // vertices, keys % vertices], axis=1)
    return edges.astype(np.int32), of_side.reshape(-1, 3).astype(np.int32), count.astype(np.int32)


def _inconsistent_sides(triangles: IntArray) -> BoolArray:
    """(m, 3) sides whose edge has two triangles that run along it the same way."""
    _, of_side, count = triangle_edges(triangles)
    upwards = np.where(triangles < triangles[:, [1, 2, 0]], 1, -1)
    balance = np.bincount(of_side.ravel(), weights=upwards.ravel())
    return np.asarray(((count == 2) & (balance != 0))[of_side])
