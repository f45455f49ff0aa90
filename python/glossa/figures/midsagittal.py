"""Midsagittal figures: tongue outlines between the walls, tongue tip on the left.

Outlines are drawn as a centripetal Catmull-Rom curve through the surface nodes: every node lies on its curve, the
corners between hexahedra are rounded. Walls and bones are drawn as cut.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError
from glossa.figures import style
from glossa.figures.sections import midsagittal_cut, midsagittal_outline, smooth_closed
from glossa.results import Posture

ATTACHMENTS = {"jaw": style.JAW, "hyoid": style.HYOID}
"""Node sets that hold the tongue, and their colours."""

MARGIN = 14.0
"""Room around the tongue at rest, mm."""


@style.styled
def midsagittal(postures: Posture | Mapping[str, Posture], *, rest: bool = True) -> Figure:
    """One picture of one or several postures of one speaker, with the walls; rest dotted.

    Raises:
        InputError: no posture, several speakers, or a speaker without a midsagittal section.
    """
    named = {"posture": postures} if isinstance(postures, Posture) else dict(postures)
    speaker = one_speaker(named)
    sheet = style.new_sheet(5.4, 4.8)
    axes = sheet.add_subplot()
    draw_surroundings(axes, speaker)
    handles = draw_postures(axes, named, rest=rest)
    draw_attachment_names(axes, speaker)
    set_axes(axes, speaker)
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
        draw_surroundings(axes, posture.speaker)
        draw_outline(axes, posture.speaker, posture.speaker.nodes, colour=style.REST, dotted=True)
        draw_outline(axes, posture.speaker, posture.positions, colour=colours[name], fill=True)
        draw_attachments(axes, posture)
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
    dash: str | tuple[float, tuple[float, ...]] = (0, (1.0, 1.6)) if dotted else "-"
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


def draw_surroundings(axes: Axes, speaker: Speaker) -> None:
    """Walls and hyoid cut by y = 0: closed cuts as filled bone, open ones as lines."""
    walls = dict(speaker.walls)
    if speaker.hyoid is not None and speaker.hyoid.surface is not None:
        walls["hyoid bone"] = speaker.hyoid.surface
    for name, wall in walls.items():
        for cut in midsagittal_cut(wall):
            if np.allclose(cut[0], cut[-1]):
                axes.add_patch(Polygon(cut * 1e3, facecolor=style.BONE, edgecolor="none", zorder=0.5))
            (line,) = axes.plot(*(cut * 1e3).T, color=style.WALL, linewidth=1.1, zorder=1, solid_joinstyle="round")
            line.set_gid(f"wall:{name}")


def set_axes(axes: Axes, speaker: Speaker) -> None:
    """Millimetres, equal aspect, room around the tongue at rest for its movements and the walls near it."""
    outline = speaker.nodes[midsagittal_outline(speaker)][:, [0, 2]] * 1e3
    low, high = outline.min(axis=0) - MARGIN, outline.max(axis=0) + MARGIN
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_xlabel("x, front to back (mm)")
    axes.set_ylabel("z, up (mm)")
