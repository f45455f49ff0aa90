"""Geometry of walls and closed surfaces, independent of the package's own distance field."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from glossa.anatomy import Speaker, Wall


class Front:
    """Signed distance to a wall, from points all over it with interpolated normals; positive in front."""

    def __init__(self, wall: Wall, divisions: int = 4) -> None:
        corners = wall.triangles
        a, b, c = np.moveaxis(wall.vertices[corners], 1, 0)
        normal = np.cross(b - a, c - a)
        at_vertex = np.zeros_like(wall.vertices)
        np.add.at(at_vertex, corners.ravel(), np.repeat(normal, 3, axis=0))
        at_vertex /= np.linalg.norm(at_vertex, axis=1, keepdims=True)
        n = divisions
        weights = np.array([[i, j, n - i - j] for i in range(n + 1) for j in range(n + 1 - i)]) / n
        self.points = np.einsum("pb,tbc->tpc", weights, wall.vertices[corners]).reshape(-1, 3)
        self.normals = np.einsum("pb,tbc->tpc", weights, at_vertex[corners]).reshape(-1, 3)
        self.tree = cKDTree(self.points)
        self.rim = cKDTree(wall.vertices[np.unique(edges_used_once(corners))])

    def heights(self, points: np.ndarray) -> np.ndarray:
        """(k,) m above the tangent plane of the nearest point; NaN where that lies at the rim: nothing is in front."""
        _, nearest = self.tree.query(points)
        height = ((points - self.points[nearest]) * self.normals[nearest]).sum(axis=1)
        at_rim = self.rim.query(self.points[nearest])[0] < 1e-9
        return np.where(at_rim, np.nan, height)


def directed_edges(triangles: np.ndarray) -> np.ndarray:
    """(e, 2) start and end of each side of each triangle."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def edges_used_once(triangles: np.ndarray) -> np.ndarray:
    """(e, 2) edges of one triangle only: the rim."""
    edges, count = np.unique(np.sort(directed_edges(triangles), axis=1), axis=0, return_counts=True)
    return np.asarray(edges[count == 1])


def surface_of(speaker: Speaker, name: str) -> Wall:
    """A wall by name, or the surface of the hyoid."""
    if name != "hyoid":
        return speaker.walls[name]
    assert speaker.hyoid is not None
    assert speaker.hyoid.surface is not None
    return speaker.hyoid.surface


def turned(triangle: list[int]) -> tuple[int, ...]:
    """The same triangle, smallest vertex first."""
    first = triangle.index(min(triangle))
    return tuple(triangle[first:] + triangle[:first])


def winding(surface: Wall, point: np.ndarray) -> float:
    """1 inside a closed surface, 0 outside: its solid angle over 4 pi (Van Oosterom & Strackee 1983)."""
    a, b, c = np.moveaxis(surface.vertices[surface.triangles] - point, 1, 0)
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    top = (a * np.cross(b, c)).sum(axis=1)
    bottom = la * lb * lc + (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
    return float(np.arctan2(top, bottom).sum() / (2.0 * np.pi))
