"""Eq. 4 shares and eq. 1 topology on blocks where they can be counted by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from glossa.anatomy import Muscle, Speaker
from glossa.anatomy.muscle_topology import capacity_shares, fibre_passes, largest_fibre_count, stiffening_gain
from glossa.errors import InputError


def test_inside_face_and_edge_of_a_block(block: Speaker) -> None:
    muscle = block.muscles["bundle"]
    passes = dict(zip([tuple(f) for f in muscle.fibres], fibre_passes(block.hexahedra, muscle), strict=True))
    counts = {len(p): {fraction for _, fraction in p} for p in passes.values()}
    assert counts == {2: {0.25}, 4: {0.5}, 8: {1.0}}  # block edges, faces, centre
    shares = capacity_shares(block.nodes, block.hexahedra, muscle)
    weights = np.array([len(p) * p[0][1] for p in passes.values()])
    assert np.allclose(shares, weights / weights.sum(), rtol=1e-12)
    assert largest_fibre_count(block.hexahedra, muscle) == 4


def test_shares_follow_element_volume(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, node = make_block(1, 3, 1)
    nodes = nodes * [1.0, 1.0, 1.0]
    nodes[nodes[:, 1] > 0.01, 1] += 0.02  # the last cell is three times as wide
    fibres = [[node(0, 0, 0), node(1, 0, 0)], [node(0, 3, 0), node(1, 3, 0)]]
    shares = capacity_shares(nodes, hexahedra, Muscle([0, 2], fibres, 1.0))
    assert shares == pytest.approx([0.25, 0.75])


def test_face_diagonals(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, node = make_block(1, 2, 1)
    inner = [node(0, 1, 0), node(1, 1, 1)]
    outer = [node(0, 0, 0), node(1, 0, 1)]
    muscle = Muscle([0, 1], [inner, outer], 1.0)
    assert fibre_passes(hexahedra, muscle) == [[(0, 1.0), (1, 1.0)], [(0, 0.5)]]
    assert capacity_shares(nodes, hexahedra, muscle) == pytest.approx([0.8, 0.2])


def test_several_segments_in_one_element_take_the_mean(make_block: Callable[..., Any]) -> None:
    _, hexahedra, node = make_block(1, 2, 1)
    bent = [node(0, 0, 0), node(0, 1, 0), node(1, 1, 0)]  # one corner edge (0.25), one face edge (0.5)
    assert fibre_passes(hexahedra, Muscle([0, 1], [bent], 1.0)) == [[(0, 0.375), (1, 0.5)]]


def test_fibre_that_touches_no_element_gets_the_smallest_weight(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, node = make_block(3, 1, 1)
    fibres = [[node(0, 0, 0), node(1, 0, 0)], [node(2, 0, 0), node(3, 0, 0)]]
    muscle = Muscle([0], fibres, 1.0)
    assert fibre_passes(hexahedra, muscle)[1] == []
    assert capacity_shares(nodes, hexahedra, muscle) == pytest.approx([0.5, 0.5])
    untouched = Muscle([1], fibres, 1.0)
    assert capacity_shares(nodes, hexahedra, untouched) == pytest.approx([0.5, 0.5])


def test_stiffening_gain(block: Speaker) -> None:
    muscle = block.muscles["bundle"]
    saturation = np.log(2.0) / 40.0
    assert stiffening_gain(block.hexahedra, muscle, saturation) == pytest.approx(9.0 / (4 * saturation))
    fixed = Muscle(muscle.elements, muscle.fibres, 1.0, 6)
    assert stiffening_gain(block.hexahedra, fixed, saturation, 20.0) == pytest.approx(19.0 / (6 * saturation))
    with pytest.raises(InputError, match="saturation_activation must be positive"):
        stiffening_gain(block.hexahedra, muscle, 0.0)
    with pytest.raises(InputError, match="peak_multiplier must be at least 1"):
        stiffening_gain(block.hexahedra, muscle, saturation, 0.5)
