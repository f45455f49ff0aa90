"""Midsagittal outlines and cuts."""

from __future__ import annotations

import numpy as np
import pytest

from glossa import InputError, Speaker, Wall
from glossa.figures.sections import enclosed_area, midsagittal_cut, midsagittal_outline, smooth_closed

CUBE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]


def two_cubes() -> Speaker:
    """Two cubes of 1 m side by side, sharing the face y = 0."""
    nodes = np.array([[x, y, z] for y in (-1, 0, 1) for z in (0, 1) for x in (0, 1)], dtype=float)
    lower = [0, 1, 5, 4, 2, 3, 7, 6]
    return Speaker(nodes, [lower, [k + 4 for k in lower]])


def test_outline_of_two_cubes_is_the_shared_square() -> None:
    speaker = two_cubes()
    outline = midsagittal_outline(speaker)
    assert sorted(outline.tolist()) == [4, 5, 6, 7]
    assert np.linalg.norm(np.diff(speaker.nodes[outline], axis=0), axis=1) == pytest.approx([1.0, 1.0, 1.0])


def test_outline_of_the_reference_encloses_its_section() -> None:
    speaker = Speaker.reference()
    outline = midsagittal_outline(speaker)
    assert len(set(outline.tolist())) == len(outline)
    assert np.abs(speaker.nodes[outline, 1]).max() == 0.0
    assert speaker.node_sets["tip"][0] in outline
    assert np.isin(speaker.contours["dorsum"], outline).all()
    # Area of the section: that of all faces in y = 0, each counted once.
    flat = np.isin(speaker.hexahedra, speaker.midsagittal_nodes)
    right = flat.sum(axis=1) == 4
    right &= speaker.nodes[speaker.hexahedra, 1].mean(axis=1) > 0
    total = 0.0
    for corners, mask in zip(speaker.hexahedra[right], flat[right], strict=True):
        x, z = speaker.nodes[corners[mask]][:, [0, 2]].T
        order = np.argsort(np.arctan2(z - z.mean(), x - x.mean()))
        total += enclosed_area(np.stack([x[order], z[order]], axis=1))
    assert enclosed_area(speaker.nodes[outline][:, [0, 2]]) == pytest.approx(total, rel=1e-12)


def test_outline_of_pb(pb: Speaker) -> None:
    outline = midsagittal_outline(pb)
    assert np.isin(pb.contours["dorsum"], outline).mean() > 0.9
    assert np.isin(outline, pb.midsagittal_nodes).all()


def test_a_body_off_the_midplane_has_no_outline() -> None:
    speaker = Speaker(np.add(CUBE, (0.0, 0.5, 0.0)), [list(range(8))])
    with pytest.raises(InputError, match="no face of a hexahedron lies in the plane"):
        midsagittal_outline(speaker)


def test_smooth_curve_passes_through_its_points_and_stays_near() -> None:
    angle = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    curve = smooth_closed(circle, divisions=5)
    assert curve.shape == (80, 2)
    assert curve[::5] == pytest.approx(circle)
    # A cubic arc over 22.5 degrees leaves the circle by about 1e-3.
    assert np.linalg.norm(curve, axis=1) == pytest.approx(np.ones(80), abs=2e-3)
    assert np.abs(np.linalg.norm(curve, axis=1) - 1.0).max() > 0.0


def test_cut_of_a_closed_wall_is_one_closed_line() -> None:
    vertices = np.array(CUBE, dtype=float) - [0.0, 0.4, 0.0]
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [3, 7, 6, 2], [0, 4, 7, 3], [1, 2, 6, 5]]
    (line,) = midsagittal_cut(Wall(vertices, faces))
    assert line[0] == pytest.approx(line[-1])
    assert enclosed_area(line[:-1]) == pytest.approx(1.0)


@pytest.mark.parametrize("shift", [0.0, 1.0])
def test_edges_in_the_plane_are_cut_once(shift: float) -> None:
    """Two quads that meet in an edge at y = 0, and one whose edge only touches the plane."""
    vertices = [[0, -1, 0], [1, -1, 0], [1, 0, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0]]
    wall = Wall(np.add(vertices, (0.0, shift, 0.0)), [[0, 1, 2, 3], [3, 2, 4, 5]])
    lines = midsagittal_cut(wall)
    assert len(lines) == (1 if shift == 0.0 else 0)
    for line in lines:
        assert np.ptp(line[:, 0]) == pytest.approx(1.0)


def test_a_wall_beside_the_plane_has_no_cut() -> None:
    assert midsagittal_cut(Wall([[0, 1, 0], [1, 1, 0], [0, 2, 0]], [[0, 1, 2]])) == []


def test_cuts_of_pb(pb: Speaker) -> None:
    assert pb.hyoid is not None
    assert pb.hyoid.surface is not None
    (bone,) = midsagittal_cut(pb.hyoid.surface)
    assert bone[0] == pytest.approx(bone[-1])
    (palate,) = midsagittal_cut(pb.walls["hard_palate"])
    highest_node = pb.nodes[midsagittal_outline(pb), 2].max()
    assert palate[:, 1].max() > highest_node
