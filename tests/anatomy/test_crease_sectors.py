"""Tangents of creases around one node, and gradients between them."""

from __future__ import annotations

import numpy as np
import pytest

from glossa.anatomy.crease_sectors import Sector, crease_sectors, crease_tangents, sector_gradient
from glossa.anatomy.quad_mesh import QuadMesh


def star(*angles: float, lengths: tuple[float, ...]) -> np.ndarray:
    turns = np.radians(angles)
    directions = np.stack([np.cos(turns), np.sin(turns), np.zeros(len(turns))], axis=1)
    return np.asarray(np.array(lengths)[:, None] * directions)


def test_sectors_go_round() -> None:
    assert crease_sectors(np.array([0, 2, 3]), 5) == [Sector(0, [1], 2), Sector(2, [], 3), Sector(3, [4], 0)]


def test_creases_that_continue_each_other_are_one_parabola() -> None:
    lengths = (1.0, 0.7, 4.0, 0.7)
    edges = star(0, 80, 180, 270, lengths=lengths)
    rows, partner = crease_tangents(edges, np.array([0, 2]))
    assert partner.tolist() == [2, -1, 0, -1]
    for bend in (0.0, -2.0):
        values = np.array([3.0 + bend, 99.0, -12.0 + 16.0 * bend, 99.0])
        assert rows[0] @ values == pytest.approx(3.0, rel=1e-14)
        assert rows[2] @ values == pytest.approx(-12.0, rel=1e-14)


@pytest.mark.parametrize(
    ("angles", "creases", "partners"),
    [
        ((0, 60, 110, 200), [0, 2], [-1, -1, -1, -1]),  # a turn of 70 degrees is a corner
        ((0, 130, 200, 280), [0, 1], [-1, -1, -1, -1]),  # so is a face alone between two creases
        ((0, 90, 175, 270), [0, 1, 2, 3], [2, 3, 0, 1]),  # two lines that cross
        ((0, 40, 175, 200, 270), [0, 2, 4], [2, -1, 0, -1, -1]),
        ((0, 40, 150, 180, 210, 320), [0, 2, 4], [-1, -1, -1, -1, -1, -1]),  # 150 and 210: no choice between them
    ],
)
def test_which_creases_continue(angles: tuple[float, ...], creases: list[int], partners: list[int]) -> None:
    edges = star(*angles, lengths=(1.0,) * len(angles))
    rows, partner = crease_tangents(edges, np.array(creases))
    assert partner.tolist() == partners
    for crease in creases:
        if partner[crease] < 0:
            assert np.array_equal(rows[crease], np.eye(len(angles))[crease])


def test_gradient_reproduces_planes() -> None:
    tilt = np.array([[1.0, 0.0, 0.0], [0.0, 0.8, 0.6], [0.0, -0.6, 0.8]])
    for angles, creases, first in (((0, 50, 120, 180, 270), [0, 3], 0), ((0, 30, 60, 100, 200), [0, 3], 0)):
        edges = star(*angles, lengths=(1.0, 3.0, 0.5, 2.0, 1.0)) @ tilt
        rows, partner = crease_tangents(edges, np.array(creases))
        sector = crease_sectors(np.array(creases), 5)[first]
        gradient = sector_gradient(edges, tilt[2], sector, rows, bool(partner[0] == 3))
        assert gradient is not None
        values = edges @ np.array([0.3, -0.7, 0.2])
        slopes = gradient.rows @ values
        members = [sector.first, *sector.inner, sector.last]
        assert np.allclose(gradient.places[members] @ slopes, values[members], rtol=0, atol=1e-14)


def test_no_gradient_without_a_plane() -> None:
    folded = star(0, 5, 10, 200, lengths=(1.0, 1.0, 1.0, 1.0))
    rows, partner = crease_tangents(folded, np.array([0, 2]))
    assert partner[0] == -1
    assert sector_gradient(folded, np.array([0, 0, 1.0]), Sector(0, [1], 2), rows, False) is None
    upright = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, 1.0, 0], [-1.0, -1.0, 0]])
    rows, _ = crease_tangents(upright, np.array([0, 2]))
    assert sector_gradient(upright, np.array([0, 0, 1.0]), Sector(0, [1], 2), rows, False) is None


def test_half_edges_of_a_cube() -> None:
    quads = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [3, 7, 6, 2], [0, 4, 7, 3], [1, 2, 6, 5]], np.int32)
    mesh = QuadMesh(quads, 8)
    every = np.arange(24)
    assert np.array_equal(mesh.twin[mesh.twin], every)
    assert np.array_equal(mesh.start[mesh.twin], mesh.end)
    assert np.array_equal(mesh.cw[mesh.ccw], every)
    assert np.array_equal(mesh.start[mesh.ccw], mesh.start)
    assert sorted(set(mesh.fan.tolist())) == sorted(min(np.flatnonzero(mesh.start == node)) for node in range(8))
    assert [int(mesh.end[h]) for h in mesh.around(4)] == [5, 7, 0]  # counter-clockwise around node 4 from outside
