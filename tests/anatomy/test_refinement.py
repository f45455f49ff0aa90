"""Refinement: volume, counts, sets, and fibres that multiply."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.blocks import hyoid_block

from glossa import Scene
from glossa.anatomy import Muscle, Speaker, Wall
from glossa.anatomy.mirror import half_body
from glossa.anatomy.muscle_topology import largest_fibre_count


def test_block(block: Speaker) -> None:
    fine = block.refined()
    assert len(fine.hexahedra) == 64
    assert len(fine.nodes) == 125
    assert fine.volume == pytest.approx(block.volume, rel=1e-14)
    assert np.allclose(fine.element_volumes, 1e-6 / 8, rtol=1e-12)
    assert np.array_equal(fine.nodes[:27], block.nodes)
    assert len(fine.node_sets["left"]) == 25
    assert (fine.nodes[fine.node_sets["left"], 0] == 0).all()
    assert len(fine.node_sets["line"]) == 5
    assert len(fine.contours["top"]) == 5
    assert (np.diff(fine.nodes[fine.contours["top"], 0]) > 0).all()


def test_contact_faces_become_their_children(block: Speaker) -> None:
    palate = Wall([[0, 0, 0.03], [0, 0.01, 0.03], [0.02, 0, 0.03]], [[0, 1, 2]])
    top = block.surface_quads[(block.nodes[block.surface_quads, 2] == 0.02).all(axis=1)]
    parts: dict[str, Any] = {"walls": {"palate": palate}, "contact_faces": {"palate": top[[2, 0, 3]]}}
    fine = Speaker(block.nodes, block.hexahedra, **parts).refined()
    faces = fine.contact_faces["palate"]
    assert len(faces) == 12
    for parent, children in zip(top[[2, 0, 3]], faces.reshape(3, 4, 4), strict=True):
        corners = fine.nodes[children]
        assert corners.min() == pytest.approx(block.nodes[parent].min())
        areas = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2
        assert np.allclose(areas, [0, 0, 0.005**2], rtol=0, atol=1e-18)
        for c in range(4):
            assert parent[c] in children[c]


def test_fibres_multiply_in_both_directions(block: Speaker) -> None:
    fine = block.refined()
    muscle = fine.muscles["bundle"]
    assert len(muscle.fibres) == 25  # 3 x 3 lines become (2 * 3 - 1) x (2 * 3 - 1)
    assert {tuple(np.round(fine.nodes[f[0], 1:] * 200).astype(int)) for f in muscle.fibres} == {
        (y, z) for y in range(-2, 3) for z in range(5)
    }
    assert np.allclose(fine.fibre_rest_lengths("bundle"), 0.02, rtol=1e-13)
    assert len(muscle.elements) == 64
    assert muscle.fibres_per_element == 4
    assert muscle.force_capacity == 10.0
    assert largest_fibre_count(fine.hexahedra, muscle) == 4
    assert len(fine.refined().muscles["bundle"].fibres) == 81


def test_refined_bodies_are_touched_symmetrically() -> None:
    """Edges of 2.5 mm, the distance of contact points, but for rounding."""
    fine = hyoid_block(between_walls=True).refined()
    assert "mirror" in Scene(fine, mirror=True, fixed=[]).effects


def test_face_diagonals_beside_each_other(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, node = make_block(1, 1, 1)
    fibres = [[node(0, j, 0), node(1, j, 1)] for j in (0, 1)]
    fine = Speaker(nodes, hexahedra, muscles={"m": Muscle([0], fibres, 1.0)}).refined()
    paths = [fine.nodes[f] * 100 for f in fine.muscles["m"].fibres]
    assert [len(p) for p in paths] == [3, 3, 3]
    assert np.allclose(sorted(p[0, 1] for p in paths), [-0.5, 0.0, 0.5])
    for path in paths:
        assert np.allclose(path[:, 0], path[:, 2])


def test_face_diagonals_in_line_and_four_together(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, node = make_block(2, 1, 3)
    fibres = [[node(i, j, e + i) for i in range(3)] for j in (0, 1) for e in (0, 1)]
    fine = Speaker(nodes, hexahedra, muscles={"m": Muscle(range(6), fibres, 1.0)}).refined()
    new = fine.muscles["m"].fibres
    starts = {tuple(np.round(fine.nodes[f[0]] * [100, 100, 100], 6)) for f in new}
    assert starts == {(0.0, y, z) for y in (-0.5, 0.0, 0.5) for z in (0.0, 0.5, 1.0)}
    assert np.allclose(fine.fibre_rest_lengths("m"), 0.02 * np.sqrt(2), rtol=1e-12)


def test_outside_point_is_shared(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, node = make_block(2, 1, 1)
    nodes = np.concatenate([nodes, [[0.05, 0.0, 0.03]]])
    outside = len(nodes) - 1
    fibres = [[*(node(i, j, 0) for i in range(3)), outside] for j in (0, 1)]
    speaker = Speaker(nodes, hexahedra, muscles={"Sty": Muscle([0, 1], fibres, 1.0)}, node_sets={"styloid": [outside]})
    fine = speaker.refined()
    assert len(fine.muscles["Sty"].fibres) == 3
    assert all(outside in (f[0], f[-1]) for f in fine.muscles["Sty"].fibres)
    assert fine.outside_points.tolist() == [outside]
    assert fine.node_sets["styloid"].tolist() == [outside]


def test_fibres_that_meet_at_the_midline_stay_two(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, node = make_block(1, 2, 1)
    fibres = [[node(i, j, 0), node(i, 1, 0)] for i in (0, 1) for j in (0, 2)]
    fine = Speaker(nodes, hexahedra, muscles={"Trans": Muscle([0, 1], fibres, 1.0)}).refined()
    assert len(fine.muscles["Trans"].fibres) == 6
    assert np.allclose(fine.fibre_rest_lengths("Trans"), 0.01)


def test_reference_refined_has_the_fibres_of_resolution_two(reference: Speaker) -> None:
    fine, generated = reference.refined(), Speaker.reference(2)
    for name in ("GGa", "GGm", "GGp", "HG", "Vert", "Trans", "IL", "SL"):
        assert len(fine.muscles[name].fibres) == len(generated.muscles[name].fibres)
        assert fine.fibre_rest_lengths(name).sum() == pytest.approx(generated.fibre_rest_lengths(name).sum(), rel=0.04)
    assert len(fine.nodes) == len(generated.nodes)
    assert fine.volume == pytest.approx(reference.volume, rel=1e-12)
    half_body(fine)  # refuses what is not symmetric


def test_pb_refined(pb: Speaker) -> None:
    fine = pb.refined()
    assert len(fine.hexahedra) == 8 * 740
    assert fine.volume == pytest.approx(pb.volume, rel=1e-12)
    assert fine.outside_points.tolist() == pb.outside_points.tolist()
    for name, muscle in pb.muscles.items():
        assert len(fine.muscles[name].fibres) > len(muscle.fibres)
        assert len(fine.muscles[name].elements) == 8 * len(muscle.elements)
        assert fine.fibre_rest_lengths(name).max() <= 1.05 * pb.fibre_rest_lengths(name).max()
    assert set(fine.walls) == set(pb.walls)
    assert fine.hyoid is pb.hyoid
    boundary = {tuple(face) for face in fine.surface_quads.tolist()}
    for name, faces in pb.contact_faces.items():
        assert len(fine.contact_faces[name]) == 4 * len(faces)
        assert {tuple(face) for face in fine.contact_faces[name].tolist()} <= boundary
    half_body(fine)
