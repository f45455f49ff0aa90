"""Planes, columns, contours and the midline, each alone."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from glossa import InputError, Speaker
from glossa.studies import rest_posture
from glossa.tract import cut_tract
from glossa.tract.airway import Channel
from glossa.tract.columns import column_row, cross, cut
from glossa.tract.contour import contour, joined
from glossa.tract.midline import centre_line, midsagittal_sides, rest_midline
from glossa.tract.planes import planes_along
from glossa.tract.rest_tract import rest_tract

TETRAHEDRON = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) * 1e-2
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def upright_planes(count: int = 5) -> object:
    """Planes across x, from behind to the front, t upwards."""
    line = np.stack([np.linspace(5e-3, -5e-3, 50), np.full(50, 2e-3)], axis=1)
    return planes_along(line, count)


def test_planes_are_perpendicular_to_the_line_with_t_towards_the_palate() -> None:
    planes = planes_along(np.stack([np.linspace(0.1, 0.0, 30), np.full(30, 0.05)], axis=1), 11)
    assert planes.origins[:, 0] == pytest.approx(np.linspace(0.1, 0.0, 11))
    assert planes.normals == pytest.approx(np.tile([-1.0, 0.0], (11, 1)), abs=1e-12)
    assert planes.outwards == pytest.approx(np.tile([0.0, 1.0], (11, 1)), abs=1e-12)
    assert planes.to_space(3, np.array([2e-3, 1e-3])) == pytest.approx([0.07, 2e-3, 0.051])


def test_a_cut_closed_surface_has_the_area_of_the_plane_figure() -> None:
    planes = upright_planes(4)
    segments, plane, _ = cut(TETRAHEDRON, FACES, planes)  # type: ignore[arg-type]
    for k, x in enumerate(np.linspace(5e-3, -5e-3, 4)):
        figure = shapely.polygonize(shapely.linestrings(segments[plane == k]))
        corners = tetrahedron_section(x)
        assert figure.area == pytest.approx(shapely.Polygon(corners).area, rel=1e-9)


def tetrahedron_section(x: float) -> list[tuple[float, float]]:
    """Corners (y, z) of the convex section at x."""
    points = []
    for a, b in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)):
        p, q = TETRAHEDRON[a], TETRAHEDRON[b]
        if (p[0] - x) * (q[0] - x) < 0.0:
            crossing = p + (x - p[0]) / (q[0] - p[0]) * (q - p)
            points.append((crossing[1], crossing[2]))
    return list(shapely.MultiPoint(points).convex_hull.exterior.coords)


def test_columns_meet_a_closed_surface_in_pairs_that_face_in_and_out() -> None:
    row = column_row(12e-3)
    found = cross(TETRAHEDRON, FACES, upright_planes(), row)  # type: ignore[arg-type]
    cells = found.plane * len(row) + found.column
    assert set(np.bincount(cells)) == {0, 2}
    assert found.facing_out.sum() * 2 == len(cells)
    for cell in np.unique(cells):
        heights, out = found.heights[cells == cell], found.facing_out[cells == cell]
        assert bool(out[heights.argmax()])
        assert not out[heights.argmin()]


def test_the_columns_leave_out_the_midplane_and_are_symmetric() -> None:
    row = column_row(3e-3)
    assert row == pytest.approx(-row[::-1])
    assert np.abs(row).min() > 0.0
    assert np.diff(row) == pytest.approx(np.diff(row)[0])


def test_a_single_column_of_a_slit_has_no_area() -> None:
    """Seen in a /u/: what is left in front of a narrow channel, in a slit that goes on at both sides."""
    row = np.linspace(-0.01, 0.01, 21)
    gap = np.full(21, 1e-5)
    shape, at_end = contour(Channel(10, 10, reached=False), row, gap, np.zeros(21), np.array([-0.01, 0.01]), 0)
    assert shape.is_empty
    assert not at_end
    two, _ = contour(Channel(10, 11, reached=False), row, gap, np.zeros(21), np.array([-0.01, 0.01]), 0)
    assert two.area == pytest.approx(1e-5 * 0.001)


def test_a_contour_between_half_ellipses_has_their_area() -> None:
    a, b = 8e-3, 3e-3
    row = column_row(10e-3)
    inside = np.abs(row) < a
    top = np.where(inside, b * np.sqrt(np.clip(1.0 - (row / a) ** 2, 0.0, 1.0)), np.nan)
    here = np.flatnonzero(inside)
    shape, at_end = contour(Channel(here[0], here[-1]), row, top, -top, np.array([-a, a]), 2)
    assert at_end
    assert shape.is_valid
    assert shape.area == pytest.approx(np.pi * a * b, rel=0.003)
    assert shape.centroid.y == pytest.approx(0.0, abs=1e-6)
    assert shape.bounds[0] == pytest.approx(-a)


def test_a_wedge_keeps_its_edge_and_a_slit_does_not() -> None:
    row = column_row(10e-3)
    flat = np.zeros(len(row))
    wedge = np.abs(row) - 5e-3  # gaps end at 5 mm, at 45 degrees
    slit = np.where(np.abs(row) < 4e-3, -2e-3, -0.3e-3)
    ends = np.array([-10e-3, 10e-3])
    for inner, area, width in ((wedge, 25e-6, 10e-3), (slit, 16e-6 + 2 * 0.5e-3 * 0.3e-3, 9e-3)):
        wide = np.flatnonzero(-inner >= 0.5e-3)
        shape, at_end = contour(Channel(wide[0], wide[-1]), row, flat, inner, ends, 2)
        assert not at_end
        assert shape.area == pytest.approx(area, rel=0.04)
        assert shape.bounds[2] - shape.bounds[0] == pytest.approx(width, abs=0.3e-3)


def test_shapes_that_overlap_count_once() -> None:
    one, other = shapely.box(0.0, 0.0, 2.0, 1.0), shapely.box(1.0, 0.0, 3.0, 1.0)
    assert joined([one, other]).area == pytest.approx(3.0)
    assert joined([one]) is one
    assert joined([]).is_empty


def test_the_centre_line_between_two_arcs_is_the_arc_between() -> None:
    angle = np.linspace(0.0, np.pi / 2, 200)
    outer, inner = (r * np.stack([np.cos(angle), np.sin(angle)], axis=1) for r in (50e-3, 36e-3))
    line = centre_line(outer, inner)
    radius = np.linalg.norm(line, axis=1)
    assert radius[20:-20] == pytest.approx(np.full(len(line) - 40, 43e-3), abs=1.2e-3)
    with pytest.raises(InputError, match="nothing faces the outer walls"):
        centre_line(outer, inner + 1.0)


def test_the_midline_of_the_built_in_speaker_runs_midway(reference: Speaker) -> None:
    """Between the outer walls and what faces them, from glottis to incisors; smoothing over 8 mm cuts its bends."""
    line = rest_midline(reference)
    outer, inner = midsagittal_sides(reference)
    above = shapely.distance(shapely.points(line), shapely.LineString(outer))
    below = np.linalg.norm(inner[:, None] - line, axis=2).min(axis=0)
    off = (above - below) / 2.0
    assert np.abs(off).max() < 1.8e-3
    assert np.sqrt((off**2).mean()) < 1e-3
    assert np.linalg.norm(line[-1] - outer[-1]) < 3e-3
    assert line[0, 1] == pytest.approx(outer[0, 1], abs=1e-3)
    length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    assert length < np.linalg.norm(np.diff(outer, axis=0), axis=1).sum()
    assert length > np.linalg.norm(np.diff(reference.nodes[reference.contours["dorsum"]], axis=0), axis=1).sum()


def test_planes_do_not_cross_within_the_depth_of_a_section(reference: Speaker) -> None:
    planes = rest_tract(reference, 45).planes
    for k in range(len(planes) - 1):
        system = np.stack([planes.outwards[k], -planes.outwards[k + 1]], axis=1)
        if abs(np.linalg.det(system)) > 1e-6:
            crossing = np.linalg.solve(system, planes.origins[k + 1] - planes.origins[k])
            assert np.abs(crossing).min() > 20e-3, k


def test_lateral_ends_lie_one_inside_the_other_on_the_dental_arch(reference: Speaker) -> None:
    fixed = rest_tract(reference, 45)
    lingual, crest, outer = (np.diff(fixed.ends[name], axis=1)[:, 0] for name in ("lingual", "crest", "outer"))
    assert fixed.arch.sum() > 5
    assert (lingual[fixed.arch] < crest[fixed.arch]).all()
    assert (crest[fixed.arch] < outer[fixed.arch]).all()
    assert (lingual[~fixed.arch] == outer[~fixed.arch]).all()
    assert np.flatnonzero(fixed.arch).min() > 20, "the pharynx has no teeth"
    posture = rest_posture(reference)
    areas = [cut_tract(posture, lateral_end=end).areas for end in ("lingual", "crest", "outer")]
    assert (areas[0] <= areas[1] + 1e-12).all()
    assert (areas[1] <= areas[2] + 1e-12).all()
    assert areas[0].sum() < 0.99 * areas[2].sum()
