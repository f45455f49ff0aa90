"""Hertz (1881): a rigid sphere pressed into a half space, F = 4/3 E* sqrt(R) d^1.5, E* = E / (1 - nu^2).

A quarter of the half space is meshed, with cells that grow away from the contact. On its outer faces nodes are moved as
under the point load F of that formula (Boussinesq 1885), which is the field of Hertz's pressure up to (a / r)^2, a the
radius of contact, r the distance. Without that a block of ten radii is 20 % too stiff. Formula and problem are those of
small strain: a / R is 0.1 at most.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from tests.blocks import PASSIVE, FloatArray, face_sets, lattice, sheet, wall_force

from glossa import Posture, Scene, Speaker

RADIUS = 0.06
DEPTH = 0.06
FINE = 0.0105
"""m, within which cells have the finest size."""

SHEAR = 2.0 * PASSIVE.c10
NU = PASSIVE.poissons_ratio
REDUCED = 2.0 * SHEAR / (1.0 - NU)
"""E* = E / (1 - nu^2), Pa."""


def hertz_force(approach: float) -> float:
    return float(4.0 / 3.0 * REDUCED * np.sqrt(RADIUS) * approach**1.5)


def boussinesq(points: FloatArray, force: float) -> FloatArray:
    """(n, 3) displacements in the half space z < 0 under a force along -z at the origin (Johnson 1985, eq. 3.18)."""
    x, y, z = points.T
    depth, r, distance = -z, np.hypot(x, y), np.linalg.norm(points, axis=1)
    outwards = r * depth / distance**3 - (1.0 - 2.0 * NU) * r / (distance * (distance + depth))
    down = 2.0 * (1.0 - NU) / distance + depth**2 / distance**3
    share = np.divide(outwards, r, out=np.zeros_like(r), where=r > 0.0)
    return np.asarray(force / (4.0 * np.pi * SHEAR) * np.stack([share * x, share * y, -down], axis=1))


def graded(cell: float) -> FloatArray:
    """From 0 to DEPTH: equal cells up to FINE, then each at most 1.6 times as large as the one before."""
    fine = np.arange(round(FINE / cell) + 1) * cell
    for number in range(2, 40):
        growth = np.linspace(1.0, 1.6, 6001)
        reach = fine[-1] + cell * sum(growth**k for k in range(1, number + 1))
        if reach[-1] >= DEPTH:
            ratio = float(np.interp(DEPTH, reach, growth))
            coarse = fine[-1] + cell * np.cumsum(ratio ** np.arange(1, number + 1))
            coarse[-1] = DEPTH
            return np.concatenate([fine, coarse])
    raise AssertionError


@lru_cache
def indented(approach: float, cell: float) -> Posture:
    edges = graded(cell)
    n = len(edges) - 1
    unit, hexahedra, number = lattice((n, n, n))
    i, j, k = np.rint(unit * n).astype(int).T
    nodes = np.stack([edges[i], edges[j], -edges[n - k]], axis=1)
    faces = face_sets(number)
    outer = np.unique(np.concatenate([faces[name] for name in ("right", "back", "bottom")]))
    sets = {"outer": outer, "x0": np.setdiff1d(faces["left"], outer), "y0": np.setdiff1d(faces["front"], outer)}
    half = 0.25 * RADIUS  # quadrilaterals of 0.4 mm sag by 0.7 um
    ball = sheet(
        lambda x, y: RADIUS - np.sqrt(RADIUS**2 - x**2 - y**2), (-half, -half), (half, half), (75, 75), facing=-1
    )
    speaker = Speaker(nodes, hexahedra, node_sets=sets, walls={"ball": ball})
    scene = Scene(speaker, gravity=None, fixed=[], tissue=PASSIVE, friction=None)
    far = boussinesq(nodes[outer], hertz_force(approach))
    return scene.equilibrate(
        prescribed={
            "outer": far,
            "x0": (0.0, None, None),
            "y0": (None, 0.0, None),
            "wall:ball": (0.0, 0.0, -approach),
        },
        accuracy="reference",
    )


def force(posture: Posture) -> float:
    """N, of the whole sphere."""
    return float(-4.0 * wall_force(posture, "ball")[2])


def test_converges_to_hertz() -> None:
    """Radius of contact 6 mm, over which there are 2, 3, 4 and 6 cells: 3.5, 2.6, 1.1 and 0.2 % too stiff."""
    wanted = hertz_force(0.6e-3)
    errors = [force(indented(0.6e-3, cell)) / wanted - 1.0 for cell in (3e-3, 2e-3, 1.5e-3, 1e-3)]
    assert errors[0] > errors[1] > errors[2] > errors[3]
    assert errors[0] < 0.04
    assert abs(errors[2]) < 0.015
    # What is left: penetration of 1 um (0.25 % of the force), finite strain.
    assert abs(errors[3]) < 0.006


def test_pressure() -> None:
    """p = p0 sqrt(1 - r^2 / a^2), p0 = 3 F / (2 pi a^2), a = sqrt(R d)."""
    contact = indented(0.6e-3, 1e-3).contact
    assert contact is not None
    a = np.sqrt(RADIUS * 0.6e-3)
    p0 = 3.0 * hertz_force(0.6e-3) / (2.0 * np.pi * a**2)
    r = np.hypot(*contact.points[:, :2].T)
    inside = (np.abs(contact.points[:, :2]) > 1e-9).all(axis=1) & (contact.gaps < 0.5e-3) & (r < 0.8 * a)
    expected = p0 * np.sqrt(1.0 - (r[inside] / a) ** 2)
    assert inside.sum() >= 15
    assert (
        np.sqrt(np.mean((contact.pressures[inside] - expected) ** 2)) < 0.1 * p0
    )  # 0.077 seen: six cells over the radius
    assert not contact.pressures[r > 1.2 * a].any()
    assert contact.penetration < 2e-6


def test_force_grows_with_approach_to_the_power_of_three_halves() -> None:
    approaches = np.array([0.4e-3, 0.6e-3, 1.0e-3])
    forces = np.array([force(indented(d, 1.5e-3)) for d in approaches])
    assert forces / [hertz_force(d) for d in approaches] == pytest.approx(np.ones(3), abs=0.025)
    exponent = np.polyfit(np.log(approaches), np.log(forces), 1)[0]
    assert exponent == pytest.approx(1.5, abs=0.03)
