"""A body and its division in eight: nodes and hexahedra found again, fields carried over, other bodies refused."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block

from glossa import InputError, Speaker
from glossa.anatomy.division import Division


def shuffled(speaker: Speaker, seed: int = 3) -> Speaker:
    """The same body, nodes and hexahedra in another order."""
    random = np.random.default_rng(seed)
    order = random.permutation(len(speaker.nodes))
    number = np.argsort(order)
    return Speaker(speaker.nodes[order], number[speaker.hexahedra][random.permutation(len(speaker.hexahedra))])


@pytest.mark.parametrize("distortion", [0.0, 0.2])
def test_finds_nodes_and_children_in_any_order(distortion: float) -> None:
    coarse = block((3, 2, 2), distortion=distortion)
    finer = shuffled(coarse.refined())
    division = Division(coarse, finer)
    assert np.allclose(finer.nodes[division.nodes], coarse.nodes, rtol=0.0, atol=1e-12)
    assert sorted(division.children.ravel().tolist()) == list(range(len(finer.hexahedra)))
    assert finer.element_volumes[division.children].sum(axis=1) == pytest.approx(coarse.element_volumes, rel=1e-9)
    assert np.allclose(division.carried(coarse.nodes), finer.nodes, rtol=0.0, atol=1e-12)
    values = np.arange(12.0)
    assert np.array_equal(division.inherited(values)[division.children], np.repeat(values[:, None], 8, axis=1))


def test_new_nodes_may_lie_off_the_middle(reference: Speaker) -> None:
    finer = Speaker.reference(2)
    division = Division(reference, finer)
    away = np.linalg.norm(division.carried(reference.nodes) - finer.nodes, axis=1)
    assert np.allclose(finer.nodes[division.nodes], reference.nodes, rtol=0.0, atol=1e-12)
    assert 1e-3 < away.max() < 2e-3  # m: more than the distance of some neighbours, so that the nearest would be wrong
    children = finer.element_volumes[division.children].sum(axis=1)
    assert np.abs(children / reference.element_volumes - 1.0).max() < 0.5
    assert children.sum() == pytest.approx(finer.volume)
    node = division.nodes[reference.node_sets["tip"]]
    assert node.tolist() == finer.node_sets["tip"].tolist()


def test_other_bodies_are_refused() -> None:
    coarse = block((3, 2, 2))
    with pytest.raises(InputError, match=r"in eight has 96 hexahedra and 175 nodes, got 12 and 36"):
        Division(coarse, coarse)
    with pytest.raises(InputError, match="no node at that of node"):
        Division(coarse, block((6, 4, 4), (0.05, 0.04, 0.04)))
    fine = coarse.refined()
    swapped = fine.hexahedra[:, [1, 2, 3, 0, 5, 6, 7, 4]]  # the same cells, corners turned
    assert Division(coarse, Speaker(fine.nodes, swapped)).children.shape == (12, 8)
    long = block((12, 4, 2), (0.06, 0.04, 0.04))  # as many cells, not divided alike
    with pytest.raises(InputError, match="in eight"):
        Division(coarse, long)
    nodes = np.array(fine.nodes)
    taken = Division(coarse, fine).nodes
    middle = np.setdiff1d(np.arange(len(nodes)), taken)[:2]
    renumbered = fine.hexahedra.copy()
    place = np.arange(len(nodes))
    place[middle] = middle[::-1]
    assert np.array_equal(Division(coarse, Speaker(nodes[place], place[renumbered])).nodes, taken)
