"""The mirror plane: pairing, the half body, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from glossa.anatomy import Muscle, Speaker
from glossa.anatomy.mirror import half_body, mirror_pairs
from glossa.errors import InputError


def test_pairs_of_a_block(block: Speaker) -> None:
    partner = mirror_pairs(block.nodes)
    assert np.array_equal(partner[partner], np.arange(27))
    assert np.array_equal(block.nodes[partner], block.nodes * [1, -1, 1])


def test_pairs_within_the_tolerance(block: Speaker) -> None:
    moved = block.nodes.copy()
    moved[5] += 4e-10
    assert np.array_equal(mirror_pairs(moved), mirror_pairs(block.nodes))
    moved[5] += 1e-6
    with pytest.raises(InputError, match=r"node \d+ at .* has no mirror image about y = 0"):
        mirror_pairs(moved)


def test_half_of_a_block(block: Speaker) -> None:
    half = half_body(block)
    assert half.nodes.shape == (18, 3)
    assert half.hexahedra.shape == (4, 8)
    assert half.midplane.sum() == 9
    assert (half.nodes[:, 1] >= 0).all()
    assert np.array_equal(half.expand(half.nodes), block.nodes)
    shares = [(f.force_share, f.length_factor) for f in half.fibres]
    assert sorted(shares) == [(0.5, 1.0)] * 3 + [(1.0, 1.0)] * 3
    assert np.array_equal(np.sort(half.fibre_index["bundle"]), np.repeat(np.arange(6), [2, 2, 2, 1, 1, 1])) or (
        set(half.fibre_index["bundle"].tolist()) == set(range(6))
    )
    assert np.allclose(block.element_volumes[half.kept_elements][half.element_index], block.element_volumes)
    speaker_half = Speaker(half.nodes, half.hexahedra)
    assert speaker_half.volume == pytest.approx(0.5 * block.volume)


@pytest.mark.parametrize("name", ["reference", "pb"])
def test_half_speakers(request: pytest.FixtureRequest, name: str) -> None:
    speaker: Speaker = request.getfixturevalue(name)
    half = half_body(speaker)
    assert np.allclose(half.expand(half.nodes), speaker.nodes, rtol=0, atol=1e-12)
    for muscle, places in half.fibre_index.items():
        lengths = speaker.fibre_rest_lengths(muscle)
        for index, place in enumerate(places):
            fibre = half.fibres[place]
            steps = np.diff(half.nodes[fibre.nodes], axis=0)
            assert fibre.muscle == muscle
            assert np.linalg.norm(steps, axis=1).sum() * fibre.length_factor == pytest.approx(lengths[index])
    in_plane = [f for f in half.fibres if f.force_share == 0.5]
    assert in_plane
    assert all(half.midplane[f.nodes].all() for f in in_plane)
    assert len(speaker.outside_points) == 2 * (~np.isin(np.arange(len(half.nodes)), half.hexahedra)).sum()


def test_fibre_across_the_midplane(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, node = make_block(1, 2, 1)
    across = [node(0, j, 0) for j in range(3)]
    half = half_body(Speaker(nodes, hexahedra, muscles={"T": Muscle([0, 1], [across], 1.0)}))
    (fibre,) = half.fibres
    assert (fibre.length_factor, fibre.force_share) == (2.0, 1.0)
    assert half.midplane[fibre.nodes].sum() == 1
    assert len(fibre.nodes) == 2


def _speaker(make_block: Callable[..., Any], **parts: Any) -> Speaker:
    nodes, hexahedra, _ = make_block(2, 2, 1)
    return Speaker(nodes, hexahedra, **parts)


@pytest.mark.parametrize(
    ("elements", "fibres", "message"),
    [
        ([0, 1], [[(0, 0, 0), (1, 0, 0)]], "muscle 'm', fibre 0 has no mirror image"),
        ([0], [[(0, 1, 0), (1, 1, 0)]], "muscle 'm' is not symmetric: it lacks element 1"),
        ([0, 1], [[(0, 0, 0), (0, 2, 0)]], "muscle 'm', fibre 0 crosses the midplane y = 0 between two nodes"),
        (
            [0, 1],
            [[(0, 0, 0), (0, 1, 0), (1, 2, 0)], [(0, 2, 0), (0, 1, 0), (1, 0, 0)]],
            "muscle 'm', fibre 0 crosses the midplane and is not its own mirror image",
        ),
        (
            [0, 1],
            [[(0, 0, 0), (1, 2, 0), (0, 1, 0), (1, 0, 0), (0, 2, 0)]],
            "muscle 'm', fibre 0 crosses the midplane y = 0 more than once",
        ),
    ],
)
def test_asymmetric_muscles(
    make_block: Callable[..., Any], elements: list[int], fibres: list[list[tuple[int, int, int]]], message: str
) -> None:
    nodes, hexahedra, node = make_block(2, 2, 1)
    paths = [[node(*place) for place in fibre] for fibre in fibres]
    speaker = Speaker(nodes, hexahedra, muscles={"m": Muscle(elements, paths, 1.0)})
    with pytest.raises(InputError, match=message):
        half_body(speaker)


def test_asymmetric_bodies(make_block: Callable[..., Any]) -> None:
    half_body(_speaker(make_block, node_sets={"landmark": [0]}))  # a set that nothing holds may be lopsided
    nodes, hexahedra, _ = make_block(1, 1, 1)
    with pytest.raises(InputError, match="hexahedron 0 crosses the midplane"):
        half_body(Speaker(nodes, hexahedra))
    nodes, hexahedra, node = make_block(1, 2, 2)
    with pytest.raises(InputError, match=r"node \d+ at .* has no mirror image"):
        half_body(Speaker(nodes + np.array([0, 0.001, 0]), hexahedra))
    keep = Speaker(nodes, hexahedra[:3], muscles={"m": Muscle([0], [[node(0, 2, 2), node(1, 2, 2)]], 1.0)})
    assert len(keep.outside_points) == 2
    with pytest.raises(InputError, match=r"hexahedron \d has no mirror image|node \d+ at"):
        half_body(keep)
