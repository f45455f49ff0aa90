"""Midsagittal figures: tongue outlines between the walls, tongue tip on the left.

Outlines are drawn as a centripetal Catmull-Rom curve through the surface nodes: every node lies on its curve, the
corners between hexahedra are rounded. Walls and bones are drawn as cut, a hyoid that moved at its pose. Red dots are
points of the surface under pressure, near the midline.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Wall
from glossa.errors import InputError
from glossa.figures import style
from glossa.figures.sections import midsagittal_cut, midsagittal_outline, smooth_closed
from glossa.results import Posture
from glossa.surroundings import hyoid_of, springs_of, walls_of

ATTACHMENTS = {"jaw": style.JAW, "hyoid": style.HYOID}
"""Node sets that hold the tongue, and their colours."""

HYOID_NAME = "wall:hyoid bone"
"""Of the lines of the hyoid."""

NEAR_MIDLINE = 2e-3
"""Distance from the midplane within which points under pressure are marked, m."""

MARGIN = 14.0
"""Room around the tongue at rest, mm."""

Dash = Literal["-", "--"] | tuple[float, tuple[float, ...]]

DOTTED: Dash = (0, (1.0, 1.6))
"""Of what is at rest."""


@style.styled
def midsagittal(postures: Posture | Mapping[str, Posture], *, rest: bool = True, springs: bool = False) -> Figure:
    """One picture of one or several postures of one speaker, with walls and hyoid; rest dotted.

    Args:
        postures: what to draw.
        rest: with the outline at rest.
        springs: with the springs that hold the hyoid, projected.

    Raises:
        InputError: no posture, several speakers, or a speaker without a midsagittal section.
    """
    named = {"posture": postures} if isinstance(postures, Posture) else dict(postures)
    speaker = one_speaker(named)
    sheet = style.new_sheet(5.4, 4.8)
    axes = sheet.add_subplot()
    draw_surroundings(axes, named, springs=springs)
    handles = draw_postures(axes, named, rest=rest)
    draw_attachment_names(axes, speaker)
    set_axes(axes, speaker)
    if springs:
        _widen(axes, springs_of(next(iter(named.values())))[:, :, [0, 2]].reshape(-1, 2) * 1e3)
    axes.legend(handles=handles, loc="upper left", handlelength=1.8, borderaxespad=0.0)
    return sheet


@style.styled
def midsagittal_panels(postures: Mapping[str, Posture], *, columns: int = 2) -> Figure:
    """One panel for each posture against the dotted rest outline, walls in every panel, on the same scale.

    Raises:
        InputError: as :func:`midsagittal`.
    """
    speaker = one_speaker(postures)
    rows = math.ceil(len(postures) / columns)
    sheet = style.new_sheet(0.4 + 3.5 * columns, 0.4 + 3.2 * rows)
    grid = sheet.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes in grid.ravel()[len(postures) :]:
        axes.remove()
    draw_panels(list(grid.ravel()[: len(postures)]), postures)
    for axes in sheet.axes:
        axes.label_outer()
    draw_attachment_names(sheet.axes[0], speaker)
    return sheet


def draw_panels(panels: list[Axes], postures: Mapping[str, Posture]) -> None:
    """Draw each posture in its own axes; the caller arranges and labels them."""
    colours = style.colours_of(postures)
    for axes, (name, posture) in zip(panels, postures.items(), strict=True):
        draw_surroundings(axes, {name: posture})
        draw_outline(axes, posture.speaker, posture.speaker.nodes, colour=style.REST, dotted=True)
        draw_outline(axes, posture.speaker, posture.positions, colour=colours[name], fill=True)
        draw_attachments(axes, posture)
        draw_touching(axes, posture)
        set_axes(axes, posture.speaker)
        axes.set_title(style.title_of(name), color=colours[name])


def one_speaker(postures: Mapping[str, Posture]) -> Speaker:
    """The speaker of all postures.

    Raises:
        InputError: no posture, or several speakers.
    """
    if not postures:
        raise InputError("a figure needs at least one posture")
    speaker = next(iter(postures.values())).speaker
    if any(posture.speaker.fingerprint != speaker.fingerprint for posture in postures.values()):
        raise InputError("the postures of one figure must belong to one speaker")
    return speaker


def outline_mm(speaker: Speaker, positions: FloatArray) -> FloatArray:
    """(k, 2) smoothed closed outline of the tongue in x and z, mm."""
    return smooth_closed(positions[midsagittal_outline(speaker)][:, [0, 2]] * 1e3)


def draw_postures(axes: Axes, postures: Mapping[str, Posture], *, rest: bool = True) -> list[Line2D]:
    """Outlines of several postures in one picture; returns what a legend needs."""
    colours = style.colours_of(postures)
    handles = []
    if rest:
        speaker = one_speaker(postures)
        handles.append(draw_outline(axes, speaker, speaker.nodes, colour=style.REST, dotted=True))
        handles[-1].set_label("rest")
    for name, posture in postures.items():
        single = len(postures) == 1
        handles.append(draw_outline(axes, posture.speaker, posture.positions, colour=colours[name], fill=single))
        handles[-1].set_label(style.title_of(name))
        draw_touching(axes, posture)
    draw_attachments(axes, next(iter(postures.values())))
    return handles


def draw_outline(
    axes: Axes, speaker: Speaker, positions: FloatArray, *, colour: str, dotted: bool = False, fill: bool = False
) -> Line2D:
    """Closed outline of the tongue at ``positions`` (n, 3) m; returns the line."""
    curve = outline_mm(speaker, positions)
    if fill:
        axes.add_patch(Polygon(curve, closed=True, facecolor=colour, alpha=0.13, edgecolor="none", zorder=2))
    closed = np.concatenate([curve, curve[:1]])
    dash = DOTTED if dotted else "-"
    width, order = (1.0, 3) if dotted else (1.9, 4)
    (line,) = axes.plot(*closed.T, color=colour, linewidth=width, linestyle=dash, zorder=order)
    return line


def draw_attachments(axes: Axes, posture: Posture) -> None:
    """Where jaw and hyoid hold the outline, as a thick line inside it: yellow and blue, as in fig. 1."""
    for name, colour in ATTACHMENTS.items():
        lines = posture.positions[_held_edges(posture.speaker, name)][:, :, [0, 2]] * 1e3
        held = LineCollection(list(lines), colors=colour, linewidths=4.0, alpha=0.75, capstyle="round", zorder=3.5)
        held.set_gid(f"held:{name}")
        axes.add_collection(held)


def draw_attachment_names(axes: Axes, speaker: Speaker) -> None:
    """The words "jaw" and "hyoid" beside the attachments at rest."""
    for name, offset, rotation in (("jaw", (-9, 0), 90), ("hyoid", (5, -18), 0)):
        edges = _held_edges(speaker, name)
        if len(edges):
            x, _, z = speaker.nodes[edges].mean(axis=(0, 1)) * 1e3
            axes.annotate(
                name,
                (x, z),
                xytext=offset,
                textcoords="offset points",
                rotation=rotation,
                ha="center",
                va="center",
                color=style.WALL,
                fontsize=8.0,
            )


def _held_edges(speaker: Speaker, name: str) -> IntArray:
    """(e, 2) edges of the outline with both nodes in a node set."""
    outline = midsagittal_outline(speaker)
    held = np.isin(outline, speaker.node_sets.get(name, ()))
    return np.stack([outline, np.roll(outline, -1)], axis=1)[held & np.roll(held, -1)]


def draw_touching(axes: Axes, posture: Posture) -> None:
    """Points of the tongue's surface under pressure, near the midline."""
    if posture.contact is None:
        return
    shown = posture.contact.touching & (np.abs(posture.contact.points[:, 1]) < NEAR_MIDLINE)
    x, z = posture.contact.points[shown][:, [0, 2]].T * 1e3
    dots = axes.scatter(x, z, s=9.0, color=style.TOUCH, zorder=5)
    dots.set_linewidth(0.0)
    dots.set_gid("touching")


def draw_surroundings(axes: Axes, postures: Mapping[str, Posture], *, springs: bool = False) -> None:
    """Walls and hyoid cut by y = 0: closed cuts as filled bone, open ones as lines.

    A hyoid that moved is filled at its pose and dotted at rest in a picture of one posture; among several it is filled
    at rest, with an outline in the colour of each posture at its pose.
    """
    shown = list(postures.values())
    drawn = set()
    for posture in shown:
        for name, wall in walls_of(posture).items():
            place = (name, tuple(posture.wall_displacements.get(name, ())))
            if place not in drawn:
                _draw_cut(axes, wall, f"wall:{name}")
            drawn.add(place)
    if springs:
        _draw_springs(axes, shown[0])
    hyoid = shown[0].speaker.hyoid
    if hyoid is None or hyoid.surface is None:
        return
    moved = {name: bone for name, posture in postures.items() if posture.hyoid and (bone := hyoid_of(posture))}
    if len(shown) == 1 and moved:
        _draw_cut(axes, next(iter(moved.values())), HYOID_NAME)
        outline_cut(axes, hyoid.surface, style.REST, dash=DOTTED)
        return
    _draw_cut(axes, hyoid.surface, HYOID_NAME)
    colours = style.colours_of(postures)
    for name, bone in moved.items():
        outline_cut(axes, bone, colours[name])


def _draw_cut(axes: Axes, wall: Wall, name: str) -> None:
    for cut in midsagittal_cut(wall):
        if np.allclose(cut[0], cut[-1]):
            axes.add_patch(Polygon(cut * 1e3, facecolor=style.BONE, edgecolor="none", zorder=0.5))
        (line,) = axes.plot(*(cut * 1e3).T, color=style.WALL, linewidth=1.1, zorder=1, solid_joinstyle="round")
        line.set_gid(name)


def outline_cut(axes: Axes, bone: Wall, colour: str, *, dash: Dash = "-") -> None:
    """Outline of a bone cut by y = 0, thinner where it is dotted."""
    for cut in midsagittal_cut(bone):
        outline = Polygon(cut * 1e3, closed=False, fill=False, edgecolor=colour, linestyle=dash, zorder=1.5)
        outline.set_linewidth(1.0 if dash == DOTTED else 1.3)
        outline.set_gid("hyoid")
        axes.add_patch(outline)


def _draw_springs(axes: Axes, posture: Posture) -> None:
    """Springs of the hyoid, projected; a dot at each fixed end."""
    for ends in springs_of(posture) * 1e3:
        x, z = ends[:, [0, 2]].T
        (line,) = axes.plot(x, z, color=style.HYOID, linewidth=0.9, marker=".", markevery=[1], zorder=1.4)
        line.set_gid("spring")


def set_axes(axes: Axes, speaker: Speaker) -> None:
    """Millimetres, equal aspect, room around the tongue at rest for its movements and the walls near it."""
    outline = speaker.nodes[midsagittal_outline(speaker)][:, [0, 2]] * 1e3
    low, high = outline.min(axis=0) - MARGIN, outline.max(axis=0) + MARGIN
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_xlabel("x, front to back (mm)")
    axes.set_ylabel("z, up (mm)")


def _widen(axes: Axes, points: FloatArray) -> None:
    """Limits that also hold points (k, 2) in mm."""
    if len(points):
        low, high = points.min(axis=0) - 2.0, points.max(axis=0) + 2.0
        axes.set_xlim(min(axes.get_xlim()[0], low[0]), max(axes.get_xlim()[1], high[0]))
        axes.set_ylim(min(axes.get_ylim()[0], low[1]), max(axes.get_ylim()[1], high[1]))
