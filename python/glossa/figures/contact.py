"""Contact seen from above, front at the top: faces of the tongue that touch the walls, and palatograms.

The first is the view of fig. 10 of Buchaillard, Perrier & Payan (2009); its colours are red, yellow and blue, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.spatial import cKDTree

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.contact_samples import contact_samples, contact_surface
from glossa.anatomy.facet_surface import FacetSurface
from glossa.anatomy.smooth_surface import SmoothSurface
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.wall_checks import triangle_edges
from glossa.errors import InputError
from glossa.figures import style
from glossa.figures.facets import shades, view_frame
from glossa.figures.midsagittal import one_speaker
from glossa.palatogram import ROWS, palatogram
from glossa.results import Posture
from glossa.surroundings import walls_of

ROOF = ("hard_palate", "soft_palate", "pharynx")
"""Walls above and behind the tongue, as far as a speaker has them: those of fig. 10."""

CLOSE = 1e-3
"""Gap under which a face is close to a wall, m."""

LOOKS = {"touching": style.VERMILION, "close": style.YELLOW, "apart": style.SKY}
"""Colours of the faces that may touch a wall."""

DIVISIONS = 3
"""Pieces along each side of a face, for round shapes."""

ABOVE = (90.0, 0.0)
"""Elevation and azimuth of the view, for shading."""

EDGE = (0.35, 0.33, 0.33, 0.6)
"""Colour of the edges of faces."""

LIFT = 3e-4
"""How far these edges lie above their faces, m."""

OTHER = "#F1ECEA"
"""Faces that can touch none of the walls."""

MARGIN = 3.0
"""Around the picture, mm."""

_SAME = 1e-7  # m


@style.styled
def contact_map(postures: Posture | Mapping[str, Posture], walls: Sequence[str] | None = None) -> Figure:
    """The tongue from above, a panel for each posture; walls are translucent.

    Faces that may touch a wall are red where some point of theirs is under pressure, yellow where one is nearer than
    ``CLOSE``, else blue.

    Args:
        postures: of one speaker, from scenes with contact.
        walls: names of the walls that count; None: those of ``ROOF`` that the speaker has, or all where it has none.

    Raises:
        InputError: no posture, several speakers, no contact, or an unknown wall.
    """
    named = {"contact": postures} if isinstance(postures, Posture) else dict(postures)
    speaker = one_speaker(named)
    chosen = _chosen_walls(speaker, walls)
    sheet = style.new_sheet(0.5 + 2.9 * len(named), 4.9)
    panels = sheet.subplots(1, len(named), sharex=True, sharey=True, squeeze=False)[0]
    colours = style.colours_of(named)
    for axes, (name, posture) in zip(panels, named.items(), strict=True):
        draw_tongue_from_above(axes, posture, chosen)
        draw_walls_from_above(axes, posture, chosen)
        _set_axes(axes, speaker, chosen)
        axes.set_title(style.title_of(name), color=colours[name])
        axes.label_outer()
    sheet.legend(handles=_legend(), loc="outside lower center", ncols=len(LOOKS), handlelength=1.0)
    return sheet


@style.styled
def electropalatogram(postures: Posture | Mapping[str, Posture]) -> Figure:
    """Palatograms side by side as the device shows them: a square for each electrode, filled where it is touched.

    Front at the top, the left side of the tongue on the left.

    Raises:
        InputError: no posture, several speakers, or as :func:`glossa.palatogram.palatogram`.
    """
    named = {"palatogram": postures} if isinstance(postures, Posture) else dict(postures)
    one_speaker(named)
    sheet = style.new_sheet(0.4 + 2.0 * len(named), 2.5)
    colours = style.colours_of(named)
    for axes, (name, posture) in zip(sheet.subplots(1, len(named), squeeze=False)[0], named.items(), strict=True):
        draw_palatogram(axes, posture, colour=colours[name])
        axes.set_title(style.title_of(name), color=colours[name])
    return sheet


def draw_palatogram(axes: Axes, posture: Posture, *, colour: str) -> None:
    """One palatogram; the share of touched electrodes stands below."""
    gram = palatogram(posture)
    on = gram.rows
    row, column = np.nonzero(~np.ma.getmaskarray(on))
    filled = np.array(on)[row, column]
    faces = np.where(filled[:, None], to_rgb(colour), to_rgb("white"))
    corners = np.array([[-0.4, -0.4], [0.4, -0.4], [0.4, 0.4], [-0.4, 0.4]])
    squares = np.stack([column, row], axis=1)[:, None] + corners
    axes.add_collection(PolyCollection(list(squares), facecolors=faces, edgecolors=style.FAINT, linewidths=0.6))
    axes.set(xlim=(-0.7, max(ROWS) - 0.3), ylim=(len(ROWS) - 0.3, -0.7), aspect="equal", xticks=[], yticks=[])
    axes.set_xlabel(f"{gram.percent:.0f} %")
    for spine in axes.spines.values():
        spine.set_visible(False)


def draw_tongue_from_above(axes: Axes, posture: Posture, walls: Sequence[str]) -> None:
    """All faces of the tongue, those that may touch ``walls`` coloured by what they touch; mm."""
    speaker = posture.speaker
    surface = contact_surface(speaker)
    states = face_states(posture, walls)
    looks = np.array([to_rgb(OTHER), *(to_rgb(colour) for colour in LOOKS.values())])
    cells, edges = _cells(surface, posture.positions)
    normals = np.cross(cells[:, 2] - cells[:, 0], cells[:, 3] - cells[:, 1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    light = shades(normals, view_frame(*ABOVE))
    colours = light[:, None] * looks[np.repeat(states + 1, DIVISIONS**2)]
    polygons = [*_from_above(cells), *_from_above(edges)]
    paints = np.concatenate([np.column_stack([colours, np.ones(len(colours))]), np.tile(EDGE, (len(edges), 1))])
    heights = np.concatenate([cells[:, :, 2].mean(axis=1), edges[:, :, 2].mean(axis=1) + LIFT])
    order = np.argsort(heights)
    faces = PolyCollection([polygons[k] for k in order], facecolors=paints[order], edgecolors=paints[order], zorder=2)
    faces.set_linewidth(0.35)
    faces.set_gid("tongue")
    axes.add_collection(faces)


def draw_walls_from_above(axes: Axes, posture: Posture, walls: Sequence[str]) -> None:
    """Walls as a translucent veil with their rims; mm."""
    placed = walls_of(posture)
    for name in walls:
        wall = placed[name]
        corners, rim = wall.vertices[wall.triangles], wall.vertices[_rim(wall.triangles)]
        veil = PolyCollection(list(_from_above(corners)), facecolors=style.WALL, alpha=0.05, zorder=3)
        veil.set(edgecolors="none", antialiaseds=False, rasterized=True)
        rims = LineCollection(list(_from_above(rim)), colors=style.WALL, zorder=4)
        rims.set(linewidths=0.9, alpha=0.8)
        veil.set_gid(f"wall:{name}")
        axes.add_collection(veil)
        axes.add_collection(rims)


def face_states(posture: Posture, walls: Sequence[str]) -> IntArray:
    """(q,) of the speaker's surface faces: -1 cannot touch any of the walls, 0 touching, 1 close, 2 apart.

    Raises:
        InputError: a posture without contact.
    """
    contact = posture.contact
    if contact is None:
        raise InputError("a contact map needs postures with contact; one comes from a scene without")
    speaker = posture.speaker
    held = np.zeros(len(speaker.nodes), dtype=bool)
    held[contact.held] = True
    states = np.full(len(speaker.surface_quads), -1, np.int32)
    of_walls = np.isin(contact.wall, [contact.walls.index(name) for name in walls])
    if not of_walls.any():
        return states
    samples = [contact_samples(speaker, name, held, contact.spacing) for name in walls]
    places = np.concatenate([own.operator @ posture.positions for own in samples])
    away, place = cKDTree(places).query(contact.points[of_walls])
    found = away < _SAME
    face = np.concatenate([own.faces for own in samples])[place[found]]
    states[face] = 2
    states[face[contact.gaps[of_walls][found] < CLOSE]] = 1
    states[face[contact.touching[of_walls][found]]] = 0
    return states


def _chosen_walls(speaker: Speaker, walls: Sequence[str] | None) -> list[str]:
    if walls is None:
        return [name for name in ROOF if name in speaker.walls] or list(speaker.walls)
    unknown = [name for name in walls if name not in speaker.walls]
    if unknown:
        raise InputError(f"no wall {unknown[0]!r}; this speaker has {', '.join(speaker.walls) or 'none'}")
    return list(walls)


def _cells(surface: SmoothSurface | FacetSurface, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Pieces of all faces (q d², 4, 3), and their edges as flat polygons (4 q d, 2, 3)."""
    d, count = DIVISIONS, len(surface.quads)
    u, v = (part.ravel() for part in np.meshgrid(np.arange(d + 1) / d, np.arange(d + 1) / d, indexing="ij"))
    faces = np.repeat(np.arange(count, dtype=np.int32), (d + 1) ** 2)
    points = surface.operator(faces, np.tile(u, count), np.tile(v, count)) @ positions
    lattice = points.reshape(count, d + 1, d + 1, 3)
    corners = (lattice[:, :-1, :-1], lattice[:, 1:, :-1], lattice[:, 1:, 1:], lattice[:, :-1, 1:])
    cells = np.stack(corners, axis=3).reshape(-1, 4, 3)
    sides = (lattice[:, 0], lattice[:, -1], lattice[:, :, 0], lattice[:, :, -1])
    edges = np.stack([np.stack([side[:, :-1], side[:, 1:]], axis=2) for side in sides], axis=1)
    return cells, edges.reshape(-1, 2, 3)


def _rim(triangles: IntArray) -> IntArray:
    """(e, 2) edges that belong to one triangle only."""
    edges, _, count = triangle_edges(triangles)
    return np.asarray(edges[count == 1])


def _from_above(points: FloatArray) -> FloatArray:
    """In mm: y, then x."""
    return np.asarray(points[..., [1, 0]] * 1e3)


def _set_axes(axes: Axes, speaker: Speaker, walls: Sequence[str]) -> None:
    """The same for all postures of a speaker."""
    parts = [speaker.nodes[np.unique(speaker.hexahedra)], *(speaker.walls[name].vertices for name in walls)]
    seen = _from_above(np.concatenate(parts))
    low, high = seen.min(axis=0) - MARGIN, seen.max(axis=0) + MARGIN
    axes.set(xlim=(low[0], high[0]), ylim=(high[1], low[1]), aspect="equal")
    axes.set(xlabel="y, left to right (mm)", ylabel="x, front to back (mm)")


def _legend() -> list[Line2D]:
    return [
        Line2D([], [], linestyle="none", marker="s", markersize=8.0, mec=style.FAINT, color=colour, label=name)
        for name, colour in LOOKS.items()
    ]
