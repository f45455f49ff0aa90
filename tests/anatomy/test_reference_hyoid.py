"""Hyoid bone of the built-in speaker."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from tests.anatomy.wall_geometry import Front, directed_edges, surface_of, winding

from glossa.anatomy import Speaker, Wall
from glossa.anatomy.reference_block import Block
from glossa.anatomy.solid import solid


@pytest.fixture(scope="module", params=[1, 2, 3])
def at_resolution(request: pytest.FixtureRequest) -> Speaker:
    return Speaker.reference(request.param)


def test_hyoid_is_closed(reference: Speaker) -> None:
    surface = surface_of(reference, "hyoid")
    edges = directed_edges(surface.triangles)
    assert {(b, a) for a, b in edges.tolist()} == {(a, b) for a, b in edges.tolist()}
    assert len(surface.vertices) - len(edges) // 2 + len(surface.triangles) == 2
    assert set(surface.faces.ravel().tolist()) == set(range(len(surface.vertices)))


def test_mass_of_the_hyoid(reference: Speaker) -> None:
    hyoid = reference.hyoid
    assert hyoid is not None
    volume, centre = solid(surface_of(reference, "hyoid"))
    assert hyoid.mass == pytest.approx(2000.0 * volume, rel=1e-12)
    assert hyoid.mass == pytest.approx(6.8e-3, rel=0.02)  # measured, anatomy_facts.md
    assert np.allclose(hyoid.centre, centre, rtol=0, atol=1e-12)
    assert hyoid.centre * 1e3 == pytest.approx([119.5, 0.0, 58.5], abs=3.0)
    assert abs(hyoid.centre[1]) < 1e-12


def test_mass_of_known_solids() -> None:
    cube = (
        np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]) * 2.0 + 1.0
    )
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [3, 7, 6, 2], [0, 4, 7, 3], [1, 2, 6, 5]]
    volume, centre = solid(Wall(cube, faces))
    assert volume == pytest.approx(8.0, rel=1e-14)
    assert centre == pytest.approx([2.0, 2.0, 2.0], rel=1e-14)


def test_springs_of_the_hyoid(reference: Speaker) -> None:
    hyoid = reference.hyoid
    assert hyoid is not None
    springs = {spring.name: spring for spring in hyoid.springs}
    assert len(springs) == len(hyoid.springs) == 12
    surface = surface_of(reference, "hyoid")
    nearest = cKDTree(Front(surface, 8).points)
    for name, spring in springs.items():
        assert spring.stiffness == 220.0
        assert spring.rest_length == pytest.approx(np.linalg.norm(spring.fixed - spring.on_hyoid), rel=1e-12)
        muscle, side = name.rsplit(" ", 1)
        twin = springs[f"{muscle} {'right' if side == 'left' else 'left'}"]
        for end in ("on_hyoid", "fixed"):
            assert np.array_equal(getattr(spring, end) * [1, -1, 1], getattr(twin, end))
        assert winding(surface, spring.on_hyoid) > 0.5 or nearest.query(spring.on_hyoid)[0] < 0.5e-3
        assert abs(winding(surface, spring.fixed)) < 0.01
        assert (spring.on_hyoid[1] > 0) == (side == "right")


def test_hyoid_lies_at_its_nodes(at_resolution: Speaker) -> None:
    """Attached nodes of the outer surface stand off the bone about as far as measured ones (1.3, at most 3.8 mm)."""
    r = len(at_resolution.contours["floor"]) // 6
    block = Block(r)
    nodes = block.node_grid(block.span(15, 16), range(6 * r, 6 * r + 1), block.span(-4, 4))
    assert np.isin(nodes, at_resolution.node_sets["hyoid"]).all()
    distance, _ = cKDTree(Front(surface_of(at_resolution, "hyoid")).points).query(at_resolution.nodes[nodes])
    assert distance.max() < 4e-3
    assert np.mean(distance) < 2.5e-3
