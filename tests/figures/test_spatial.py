"""Pictures in three dimensions."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from mpl_toolkits.mplot3d.art3d import Line3DCollection  # type: ignore[import-untyped]

from glossa import InputError, Posture, Speaker
from glossa.figures import cavity, frontal_views, muscles, surfaces
from glossa.figures.facets import node_normals, quad_edges, rounded, view_frame
from glossa.figures.interactive import view
from glossa.figures.spatial import ANTERIOR, FRONT, POSTERIOR
from glossa.studies import rest_posture


def sphere_quads() -> tuple[np.ndarray, np.ndarray]:
    """A cube blown up to the unit sphere: nodes and outward quads."""
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) / np.sqrt(3.0)
    quads = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    return corners, quads


def test_normals_of_a_sphere_point_outwards() -> None:
    nodes, quads = sphere_quads()
    assert node_normals(nodes, quads) == pytest.approx(nodes)


def test_rounding_keeps_nodes_and_bulges_outwards() -> None:
    nodes, quads = sphere_quads()
    pieces, normals = rounded(nodes[quads], node_normals(nodes, quads)[quads], 2)
    assert pieces.shape == (24, 4, 3)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(24))
    assert pieces[0, 0] == pytest.approx(nodes[0])
    middle = np.linalg.norm(pieces[0, 2])
    flat = 1 / np.sqrt(3.0)
    assert flat + 0.1 < middle < 1.0
    edges = quad_edges(nodes[quads], node_normals(nodes, quads)[quads], 2)
    assert edges.shape == (48, 2, 3)
    corners_of_pieces = pieces.reshape(-1, 3)
    away = np.linalg.norm(corners_of_pieces[None] - edges.reshape(-1, 1, 3), axis=2).min(axis=1)
    assert away.max() < 1e-12  # edges lie on the rounded surface


@pytest.mark.parametrize("angles", [ANTERIOR, POSTERIOR])
def test_front_is_on_the_left(angles: tuple[float, float]) -> None:
    right, up, towards = view_frame(*angles)
    assert np.stack([right, up, towards]) @ np.stack([right, up, towards]).T == pytest.approx(np.eye(3))
    assert right[0] > 0.5  # x runs from front to back
    assert up[2] > 0.5
    assert (towards[0] < 0) == (angles is ANTERIOR)


def test_surfaces_have_two_views_of_each_posture(postures: dict[str, Posture], tmp_path: Path) -> None:
    figure = surfaces(postures)
    assert len(figure.axes) == 4
    assert {axes.get_title() for axes in figure.axes} == {"/i/", "/a/", ""}
    assert {text.get_text() for axes in figure.axes for text in axes.texts} == {"anterior oblique", "posterior oblique"}
    facets = len(postures["i"].speaker.surface_quads) * 9
    for axes in figure.axes:
        (surface,) = axes.collections
        assert len(surface.get_facecolor()) > facets
    figure.savefig(tmp_path / "surfaces.png", dpi=40)
    assert (tmp_path / "surfaces.png").stat().st_size > 5_000


def test_frontal_views_look_along_x_and_end_with_the_shape_at_rest(
    postures: dict[str, Posture], tmp_path: Path
) -> None:
    right, up, towards = view_frame(*FRONT)
    assert right == pytest.approx([0.0, -1.0, 0.0], abs=1e-12)
    assert up == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
    assert towards == pytest.approx([-1.0, 0.0, 0.0], abs=1e-12)
    figure = frontal_views(postures, columns=2)
    assert [axes.get_title() for axes in figure.axes] == ["/i/", "/a/", "rest"]
    assert [axes.get_title() for axes in frontal_views(postures, rest=False).axes] == ["/i/", "/a/"]
    figure.savefig(tmp_path / "front.png", dpi=40)
    assert (tmp_path / "front.png").stat().st_size > 5_000
    with pytest.raises(InputError, match="at least one"):
        frontal_views({})


def test_the_cavity_holds_every_wall_hyoid_and_spring(reference: Speaker, tmp_path: Path) -> None:
    figure = cavity(rest_posture(reference))
    (axes,) = figure.axes
    painted, springs = axes.collections
    hyoid = reference.hyoid
    assert hyoid is not None
    assert hyoid.surface is not None
    solids = [*reference.walls.values(), hyoid.surface]
    count = len(reference.smooth_surface.triangulation()[1]) + sum(len(wall.triangles) for wall in solids)
    assert len(painted.get_facecolor()) == count
    assert springs.get_gid() == "springs"
    figure.savefig(tmp_path / "cavity.png", dpi=40)
    assert isinstance(springs, Line3DCollection)
    assert len(springs.get_segments()) == len(hyoid.springs)
    assert (tmp_path / "cavity.png").stat().st_size > 5_000


def test_muscles_have_a_panel_each_with_fibres_and_ends(tmp_path: Path) -> None:
    speaker = Speaker.reference()
    figure = muscles(speaker)
    panels = {axes.get_title(loc="left"): axes for axes in figure.axes if axes.get_title(loc="left")}
    assert list(panels) == list(speaker.muscles)
    labels = {name: {line.get_label() for line in axes.lines} for name, axes in panels.items()}
    assert labels["GGp"] == {"jaw"}
    assert labels["HG"] == {"hyoid"}
    assert labels["GH"] == {"jaw", "hyoid"}
    assert labels["Vert"] == set()
    figure.savefig(tmp_path / "muscles.png", dpi=40)
    assert (tmp_path / "muscles.png").stat().st_size > 5_000


def test_a_body_without_muscles_is_refused() -> None:
    speaker = Speaker.reference()
    bare = Speaker(speaker.nodes[:-2], speaker.hexahedra)
    with pytest.raises(InputError, match="no muscles"):
        muscles(bare)


def test_the_view_says_what_is_missing(postures: dict[str, Posture], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ImportError, match=r"pip install 'glossa\[view\]'"):
        view(postures["i"])
    with pytest.raises(InputError, match="no muscle 'XYZ'"):
        view(postures["i"], muscle="XYZ")
