"""What makes an adapted speaker unusable: each check on a body whose faults are known."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from glossa import InputError
from glossa.anatomy import Speaker, landmark_points
from glossa.anatomy.adaptation_checks import Moves, check_elements, check_map, check_overlap, check_surface
from glossa.anatomy.walls import Wall
from glossa.anatomy.warp import Warp

DOWN = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def points(reference: Speaker) -> np.ndarray:
    """(n, 3) landmarks."""
    return np.array(list(landmark_points(reference).values()))


@pytest.fixture
def moves() -> Moves:
    return Moves(("far", "near"), np.array([[0.1, 0.0, 0.0], [0.02, 0.01, 0.02]]), np.array([[0.1, 0, 0], [0.02] * 3]))


@pytest.mark.parametrize(
    ("share", "message"),
    [
        (0.40, r"turn hexahedron 7 inside out, at \(15.0, 5.0, 15.0\) mm; nearest to it, 9 mm away, is near"),
        (
            0.32,
            r"distort hexahedron 7 to a scaled Jacobian of 0.0\d+ \(before: 1.000; .*which moved by \(0.0, 10.0, 0.0",
        ),
    ],
)
def test_distorted_elements(block: Speaker, moves: Moves, share: float, message: str) -> None:
    """A corner of a cube on its way to the opposite corner passes the plane of its neighbours at a third."""
    check_elements(block, block.nodes, moves)
    with pytest.raises(InputError, match=message):
        check_elements(block, _dented(block, share), moves)


def _dented(block: Speaker, share: float) -> np.ndarray:
    nodes = block.nodes.copy()
    corner, opposite = np.array([0.02, 0.01, 0.02]), np.array([0.01, 0.0, 0.01])
    nodes[((nodes - corner) ** 2).sum(axis=1).argmin()] += share * (opposite - corner)
    return nodes


def test_a_mesh_that_gets_worse_is_warned_of(block: Speaker, moves: Moves, caplog: pytest.LogCaptureFixture) -> None:
    check_elements(block, _dented(block, 0.1), moves)
    assert not caplog.records
    check_elements(block, _dented(block, 0.25), moves)
    (record,) = caplog.records
    assert "scaled Jacobian 0." in record.getMessage()
    assert "nearest to it, 9 mm away, is near" in record.getMessage()


def test_a_poor_mesh_may_stay_as_poor(block: Speaker, moves: Moves) -> None:
    poor = Speaker(_dented(block, 0.32), block.hexahedra)
    check_elements(poor, poor.nodes * 1.1, moves)
    with pytest.raises(InputError, match="distort hexahedron 7"):
        check_elements(poor, _dented(block, 0.33), moves)


def test_folded_walls(reference: Speaker, points: np.ndarray, moves: Moves) -> None:
    nothing = Warp(points, points, reference.nodes, symmetric=True)
    wall = reference.walls["hard_palate"]
    check_surface("wall 'hard_palate'", wall, wall, nothing, moves)
    vertices = wall.vertices.copy()
    vertices[1000, 0] += 4e-3  # beyond its neighbours
    with pytest.raises(InputError, match="fold wall 'hard_palate' over at"):
        check_surface("wall 'hard_palate'", wall, Wall(vertices, wall.faces), nothing, moves)


def test_a_map_that_folds(reference: Speaker, points: np.ndarray, moves: Moves) -> None:
    turned = points * [-1.0, 1.0, 1.0]
    with pytest.raises(InputError, match="folds over at"):
        check_map(Warp(points, turned, reference.nodes, symmetric=True), reference, moves)


@pytest.mark.parametrize(("down", "fault"), [(0.1e-3, ""), (1.7e-3, "warned"), (4e-3, "refused")])
def test_a_tongue_in_the_palate(
    reference: Speaker, moves: Moves, caplog: pytest.LogCaptureFixture, down: float, fault: str
) -> None:
    walls = dict(reference.walls)
    palate = walls["hard_palate"]
    walls["hard_palate"] = Wall(palate.vertices + down * DOWN, palate.faces)
    parts: dict[str, Any] = {key: getattr(reference, key) for key in ("muscles", "node_sets", "contact_faces")}
    lower = Speaker(reference.nodes, reference.hexahedra, walls=walls, **parts)
    message = r"stands \d\.\d mm deep in wall 'hard_palate', at .* mm; nearest to it"
    if fault == "refused":
        with pytest.raises(InputError, match=message + ".*at most 2 mm can be cleared"):
            check_overlap(reference, lower, 1.0, moves)
    else:
        check_overlap(reference, lower, 1.0, moves)
        assert len(caplog.records) == (fault == "warned")
        assert all(re.search(message, record.getMessage()) for record in caplog.records)
    check_overlap(lower, lower, 1.0, moves)  # no deeper than before
