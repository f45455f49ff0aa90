"""Building blocks of swept surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from glossa.anatomy.swept_surface import cubic_spline, evenly_spaced, grid_quads, mirrored_wall


def test_cubic_spline_agrees_with_scipy() -> None:
    interpolate = pytest.importorskip("scipy.interpolate")
    knots = np.array([0.0, 1.0, 2.5, 3.0, 4.0, 6.0])
    values = np.array([[0.0, 1.0, 0.5, 0.5, 2.0, 9.0], [3.0, 2.0, 4.0, 1.0, 1.5, -1.0]])
    at = np.linspace(-0.2, 6.2, 101)
    expected = interpolate.CubicSpline(knots, values, axis=-1)(at)
    assert np.allclose(cubic_spline(knots, values, at), expected, rtol=0, atol=1e-12)
    assert np.allclose(cubic_spline(knots, values[0], knots), values[0], rtol=0, atol=1e-14)


def test_evenly_spaced_points() -> None:
    """Along quarter circles of two radii, given at an uneven parameter."""

    def quarters(at: np.ndarray) -> np.ndarray:
        angle, radius = np.pi / 2.0 * at**2, np.array([[1.0], [3.0]])
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros_like(angle)], axis=2)

    points = evenly_spaced(quarters, 2, 10)
    steps = np.linalg.norm(np.diff(points, axis=1), axis=2)
    assert steps == pytest.approx(np.outer([1.0, 3.0], np.full(10, 2.0 * np.sin(np.pi / 40.0))), rel=2e-3)


def test_mirrored_wall_shares_the_midline() -> None:
    half = np.array([[x, y, 0.0] for x in (0.0, 1.0, 2.0) for y in (0.0, 1.0)])
    wall = mirrored_wall(half, np.concatenate([grid_quads(3, 2), [[0, 1, 3, 3]]])[:3])
    assert len(wall.vertices) == 9
    with_triangle = mirrored_wall(half, np.array([[0, 1, 3, 3]]))
    assert len(with_triangle.triangles) == 2
    a, b, c = np.moveaxis(with_triangle.vertices[with_triangle.triangles], 1, 0)
    assert np.unique(np.sign(np.cross(b - a, c - a)[:, 2])).tolist() == [-1.0]
