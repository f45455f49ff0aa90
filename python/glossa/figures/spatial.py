"""Pictures in three dimensions: muscles (as fig. 1) and tongue surfaces (as figs 6 and 7)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection  # type: ignore[import-untyped]

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.hexahedra import boundary_quads
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError
from glossa.figures import style
from glossa.figures.facets import depth_fade, node_normals, quad_edges, rounded, shades, view_frame
from glossa.figures.midsagittal import one_speaker
from glossa.results import Posture
from glossa.studies.rest import rest_posture

ANTERIOR = (24.0, -128.0)
"""Elevation and azimuth in degrees of the anterior oblique view; tongue tip on the left."""

POSTERIOR = (24.0, -38.0)
"""The posterior oblique view."""

FRONT = (0.0, 180.0)
"""From the front, seen along x; the tongue's right side on the left."""

DIVISIONS = 3
"""Pieces along each side of a surface quad, for round shapes and smooth shading."""

HAZE = 0.35
"""Share of white in the colour of the farthest point."""

LIFT = 1.2e-3
"""How far lines lie in front of their surface, m."""


@style.styled
def surfaces(postures: Mapping[str, Posture]) -> Figure:
    """Shaded tongue surfaces: a column for each posture, anterior oblique view above, posterior below, on one scale.

    Raises:
        InputError: no posture, or several speakers.
    """
    one_speaker(postures)
    box = _box(np.concatenate([_body(posture) for posture in postures.values()]))
    sheet = style.new_sheet(2.7 * len(postures) + 0.3, 4.9)
    colours = style.colours_of(postures)
    for column, (name, posture) in enumerate(postures.items()):
        for row, (view, words) in enumerate(((ANTERIOR, "anterior"), (POSTERIOR, "posterior"))):
            axes = spatial_axes(sheet, (2, len(postures), row * len(postures) + column + 1), view, box)
            draw_surface(axes, posture.speaker.surface_quads, posture.positions, colour=style.TISSUE, view=view)
            if row == 0:
                axes.set_title(style.title_of(name), color=colours[name], pad=-4)
            if column == 0:
                axes.text2D(0.02, 0.02, f"{words} oblique", transform=axes.transAxes, fontsize=8, color=style.WALL)
    return sheet


@style.styled
def frontal_views(postures: Mapping[str, Posture], *, columns: int = 4, rest: bool = True) -> Figure:
    """Shaded tongue surfaces from the front, a panel for each posture, on one scale; the shape at rest last.

    Raises:
        InputError: no posture, or several speakers.
    """
    speaker = one_speaker(postures)
    shown = {**postures, "rest": rest_posture(speaker)} if rest else dict(postures)
    box = _box(np.concatenate([_body(posture) for posture in shown.values()]))
    rows = -(-len(shown) // columns)
    sheet = style.new_sheet(2.2 * columns, 2.3 * rows)
    for number, (name, posture) in enumerate(shown.items(), start=1):
        axes = spatial_axes(sheet, (rows, columns, number), FRONT, box)
        draw_surface(axes, speaker.surface_quads, posture.positions, colour=style.TISSUE, view=FRONT)
        axes.set_title(style.title_of(name), pad=-4)
    return sheet


@style.styled
def muscles(speaker: Speaker, *, columns: int = 4) -> Figure:
    """A panel for each muscle: its elements grey, its fibres red, their ends on jaw (yellow) and hyoid (blue).

    Raises:
        InputError: a speaker without muscles.
    """
    if not speaker.muscles:
        raise InputError("this speaker has no muscles to draw")
    rows = -(-(len(speaker.muscles) + 1) // columns)
    box = _box(speaker.nodes)
    sheet = style.new_sheet(2.6 * columns, 2.2 * rows)
    for number, name in enumerate(speaker.muscles, start=1):
        axes = spatial_axes(sheet, (rows, columns, number), ANTERIOR, box, zoom=1.32)
        draw_muscle(axes, speaker, name)
        axes.set_title(name, loc="left", pad=-14)
    last = sheet.add_subplot(rows, columns, len(speaker.muscles) + 1)
    last.set_axis_off()
    last.legend(handles=_muscle_legend(), loc="center left")
    return sheet


def draw_surface(
    axes: Axes3D, quads: IntArray, positions: FloatArray, *, colour: str, view: tuple[float, float], lines: bool = True
) -> None:
    """Surface of quads, lit from the upper left, paler with depth; thin lines along the edges of the quads."""
    frame = view_frame(*view)
    corners, normals = positions[quads], node_normals(positions, quads)[quads]
    pieces, facing = rounded(corners, normals, DIVISIONS)
    faces = _hazy(shades(facing, frame)[:, None] * np.array(to_rgb(colour)), pieces.mean(axis=1), frame)
    polygons = list(pieces)
    if lines:
        nearer = quad_edges(corners, normals, DIVISIONS) + LIFT * frame[2]
        dark = np.broadcast_to(0.62 * np.array(to_rgb(colour)), (len(nearer), 3))
        faces = np.concatenate([faces, _hazy(dark, nearer.mean(axis=1), frame)])
        polygons += list(nearer[:, [0, 1, 1, 0]])
    surface = Poly3DCollection(polygons, facecolors=faces, edgecolors=faces, linewidths=0.3, zsort="average")
    axes.add_collection3d(surface)
    surface.set_clip_on(False)


def _hazy(colours: FloatArray, points: FloatArray, frame: FloatArray) -> FloatArray:
    """Colours (f, 3) mixed with white, more so for farther points (f, 3)."""
    share = HAZE * depth_fade(points, frame)[:, None]
    return np.asarray(colours * (1 - share) + share)


def draw_muscle(axes: Axes3D, speaker: Speaker, name: str) -> None:
    """One muscle in the faint body: elements, fibres, and the fibre ends held by jaw and hyoid."""
    muscle = speaker.muscles[name]
    ghost = {"facecolors": "#F4F4F4", "edgecolors": "#D4D4D4", "alpha": 0.30, "linewidths": 0.3, "zorder": 1}
    solid = {"facecolors": "#909090", "edgecolors": "#606060", "alpha": 0.30, "linewidths": 0.3, "zorder": 2}
    own = boundary_quads(speaker.hexahedra[muscle.elements], len(speaker.nodes))
    for quads, look in ((speaker.surface_quads, ghost), (own, solid)):
        axes.add_collection3d(Poly3DCollection(list(speaker.nodes[quads]), **look))
    segments = speaker.nodes[muscle.segments[:, :2]]
    fibres = Line3DCollection(list(segments), colors=style.FIBRE, linewidths=0.9, capstyle="round", zorder=3)
    axes.add_collection3d(fibres)
    fibres.set_clip_on(False)
    ends = np.unique([fibre[[0, -1]] for fibre in muscle.fibres])
    for part, marker, colour in (("jaw", "s", style.JAW), ("hyoid", "o", style.HYOID)):
        x, y, z = speaker.nodes[np.intersect1d(ends, speaker.node_sets.get(part, ()))].T
        if len(x):
            axes.plot(x, y, z, linestyle="none", marker=marker, color=colour, markersize=3.0, zorder=4, label=part)


def _body(posture: Posture) -> FloatArray:
    return posture.positions[np.unique(posture.speaker.hexahedra)]


def _box(points: FloatArray) -> FloatArray:
    """(2, 3) lower and upper corner."""
    return np.stack([points.min(axis=0), points.max(axis=0)])


def spatial_axes(
    sheet: Figure, place: tuple[int, int, int], view: tuple[float, float], box: FloatArray, zoom: float = 1.4
) -> Axes3D:
    """Axes without frame at a place (rows, columns, number) of a sheet, for what lies in ``box`` (2, 3), m."""
    axes = sheet.add_subplot(*place, projection="3d", computed_zorder=False)
    assert isinstance(axes, Axes3D)
    axes.set_proj_type("ortho")
    axes.view_init(*view)
    axes.set(xlim=box[:, 0], ylim=box[:, 1], zlim=box[:, 2])
    axes.set_box_aspect(box[1] - box[0], zoom=zoom)
    axes.set_axis_off()
    return axes


def _muscle_legend() -> list[Line2D]:
    def mark(label: str, marker: str, colour: str, size: float) -> Line2D:
        return Line2D([], [], linestyle="none", marker=marker, color=colour, markersize=size, label=label)

    return [
        mark("elements of the muscle", "s", "#B5B5B5", 9.0),
        Line2D([], [], color=style.FIBRE, linewidth=1.5, label="fibres"),
        mark("ends on the jaw", "s", style.JAW, 5.0),
        mark("ends on the hyoid", "o", style.HYOID, 5.0),
    ]
