"""Surfaces swept along a curve, built on the side y >= 0 and mirrored: what walls and hyoid have in common."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.walls import Wall

_DECIMALS = 9  # coordinates are multiples of 1 nm: equal on every machine, whatever the last bit of its arithmetic
_REFLECTION = np.array([1.0, -1.0, 1.0])
_DENSE = 400  # samples that measure the length of a row


def chord_lengths(points: FloatArray) -> FloatArray:
    """(n,) lengths along the polyline ``points`` (n, d), from 0."""
    steps = np.sqrt(((points[1:] - points[:-1]) ** 2).sum(axis=1))
    return np.concatenate([[0.0], np.cumsum(steps)])


def cubic_spline(knots: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """The twice continuously differentiable cubic through ``values`` (..., n) at ``knots`` (n,), at ``at`` (m,).

    Not-a-knot ends: one cubic over the first two and one over the last two intervals. n >= 4; (..., m).
    """
    n, h = len(knots), np.diff(knots)
    secants = np.diff(values, axis=-1) / h
    matrix = np.zeros((n, n))  # for the slopes at the knots
    right = np.empty_like(values)
    rows = np.arange(1, n - 1)
    matrix[rows, rows - 1], matrix[rows, rows], matrix[rows, rows + 1] = h[1:], 2.0 * (h[1:] + h[:-1]), h[:-1]
    right[..., 1:-1] = 3.0 * (h[1:] * secants[..., :-1] + h[:-1] * secants[..., 1:])
    for end, inner, a, b in ((0, 1, 0, 1), (n - 1, n - 2, n - 2, n - 3)):
        span = h[a] + h[b]
        matrix[end, end], matrix[end, inner] = h[b], span
        right[..., end] = ((h[a] + 2.0 * span) * h[b] * secants[..., a] + h[a] ** 2 * secants[..., b]) / span
    slopes = np.linalg.solve(matrix, np.moveaxis(right, -1, 0)).reshape(n, *values.shape[:-1])
    slopes = np.moveaxis(slopes, 0, -1)
    left = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, n - 2)
    d, u = h[left], at - knots[left]
    secant, start, end_slope = secants[..., left], slopes[..., left], slopes[..., left + 1]
    square, cube = (3.0 * secant - 2.0 * start - end_slope) / d, (start + end_slope - 2.0 * secant) / d**2
    result: FloatArray = values[..., left] + u * (start + u * (square + u * cube))
    return result


def evenly_spaced(curves: Callable[[FloatArray], FloatArray], rows: int, steps: int) -> FloatArray:
    """(rows, steps + 1, 3) points in equal steps of length along each of several curves.

    Args:
        curves: parameters (rows, k) in [0, 1] to points (rows, k, 3).
        rows: number of curves.
        steps: steps along each.
    """
    dense = np.linspace(0.0, 1.0, _DENSE + 1)
    points = curves(np.broadcast_to(dense, (rows, len(dense))))
    lengths = np.array([chord_lengths(row) for row in points])
    wanted = np.linspace(0.0, 1.0, steps + 1)
    return curves(np.array([np.interp(wanted, row / row[-1], dense) for row in lengths]))


def grid_quads(rows: int, columns: int, *, closed: bool = False) -> IntArray:
    """(q, 4) quadrilaterals of a grid of ``rows`` x ``columns`` vertices, row by row; normal = column x row direction.

    Args:
        rows: vertices along the sweep.
        columns: vertices across it.
        closed: the last column is joined to the first.
    """
    number = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    if closed:
        number = np.concatenate([number, number[:, :1]], axis=1)
    corners = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    return np.stack(corners, axis=2).reshape(-1, 4)


def mirrored_wall(vertices: FloatArray, faces: IntArray) -> Wall:
    """The half surface y >= 0 and its exact mirror image as one wall; vertices with y = 0 are shared.

    A mirrored face starts at the image of the first corner, so that triangles of split quadrilaterals are mirror images
    too. Coordinates are rounded to 1 nm.

    Args:
        vertices: (n, 3) m, y = 0 exactly on the midplane.
        faces: (m, 4), a triangle repeats its last vertex.
    """
    vertices = np.round(vertices, _DECIMALS)
    beside = np.flatnonzero(vertices[:, 1] != 0.0)
    image = np.arange(len(vertices), dtype=np.int32)
    image[beside] = len(vertices) + np.arange(len(beside))
    a, b, c, d = image[faces].T
    triangle = c == d
    reversed_faces = np.stack([a, np.where(triangle, c, d), np.where(triangle, b, c), b], axis=1)
    return Wall(np.concatenate([vertices, vertices[beside] * _REFLECTION]), np.concatenate([faces, reversed_faces]))
