"""A speaker's anatomy on one sheet: midsagittal and frontal sections with the mesh, and the shape of its elements."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.hexahedra import EDGES, FACES
from glossa.anatomy.plane_cut import plane_cut
from glossa.anatomy.quality import GOOD_JACOBIAN
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Wall
from glossa.figures import style
from glossa.figures.sections import midsagittal_cut, midsagittal_outline

WALL_COLOURS = {
    "hard_palate": style.BLUE,
    "soft_palate": style.VERMILION,
    "pharynx": style.GREEN,
    "larynx": style.PURPLE,
    "mandible": style.ORANGE,
}
"""Other walls are grey."""

STATIONS = {"A": 0.25, "B": 0.5, "C": 0.75}
"""Frontal sections by letter: where between the front and the rear end of the tongue on the midline."""

MARGIN = 4.0
"""Around the anatomy, mm."""

BIN = 0.05
"""Width of the bars of scaled Jacobians."""


@style.styled
def speaker(body: Speaker) -> Figure:
    """Midsagittal section with mesh, walls, hyoid and its springs; three frontal sections; scaled Jacobians.

    Args:
        body: the speaker.

    Raises:
        InputError: no face of a hexahedron lies in the plane y = 0.
    """
    outline = body.nodes[midsagittal_outline(body)] * 1e3
    front, rear = outline[:, 0].min(), outline[:, 0].max()
    stations = {letter: front + share * (rear - front) for letter, share in STATIONS.items()}
    sheet = style.new_sheet(11.0, 6.4)
    grid = sheet.add_gridspec(2, 4, width_ratios=(1.25, 1.25, 1.15, 1.15), hspace=0.08)
    middle = sheet.add_subplot(grid[:, :2])
    _draw_midsagittal(middle, body, outline, stations)
    places = (grid[0, 2], grid[0, 3], grid[1, 2])
    panels = [sheet.add_subplot(place) for place in places]
    for axes, (letter, x) in zip(panels, stations.items(), strict=True):
        _draw_frontal(axes, body, letter, x)
    _set_frontal_axes(panels, body)
    _draw_jacobians(sheet.add_subplot(grid[1, 3]), body)
    sheet.legend(handles=_legend(body), loc="outside lower center", ncols=8, handlelength=1.4)
    sheet.suptitle(body.name, x=0.01, ha="left", fontsize=9, color=style.WALL)
    return sheet


def _draw_midsagittal(axes: Axes, body: Speaker, outline: FloatArray, stations: dict[str, float]) -> None:
    """The plane y = 0; springs are projected into it."""
    _fill(axes, [outline[:, [0, 2]]], style.TISSUE)
    in_plane = np.zeros(len(body.nodes), dtype=bool)
    in_plane[body.midsagittal_nodes] = True
    edges = np.unique(np.sort(body.hexahedra[:, EDGES].reshape(-1, 2), axis=1), axis=0)
    _add_mesh(axes, body.nodes[edges[in_plane[edges].all(axis=1)]][:, :, [0, 2]] * 1e3)
    _draw_walls(axes, ((name, midsagittal_cut(wall)) for name, wall in body.walls.items()))
    ends = np.zeros((0, 2, 2))
    if body.hyoid is not None:
        if body.hyoid.surface is not None:
            _draw_bone(axes, midsagittal_cut(body.hyoid.surface))
        springs = [[spring.on_hyoid, spring.fixed] for spring in body.hyoid.springs]
        ends = np.reshape(springs, (-1, 2, 3))[:, :, [0, 2]] * 1e3
        lines = LineCollection(list(ends), colors=style.SKY, linewidths=1.0, zorder=3.5)
        lines.set_gid("springs")
        axes.add_collection(lines)
        axes.plot(*ends[:, 1].T, linestyle="none", marker=".", markersize=4.0, color=style.SKY, zorder=3.5)
    shown = [outline[:, [0, 2]], ends.reshape(-1, 2)]
    shown += [line * 1e3 for wall in body.walls.values() for line in midsagittal_cut(wall)]
    low, high = np.concatenate(shown).min(axis=0) - MARGIN, np.concatenate(shown).max(axis=0) + MARGIN
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set(xlabel="x, front to back (mm)", ylabel="z, up (mm)")
    axes.set_title("midsagittal section")
    for letter, x in stations.items():
        axes.axvline(x, color=style.FAINT, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
        axes.annotate(
            letter, (x, 1.0), xycoords=("data", "axes fraction"), xytext=(3, -2), textcoords="offset points", va="top"
        )


def _draw_frontal(axes: Axes, body: Speaker, letter: str, x: float) -> None:
    """The plane at ``x`` mm, seen from the front."""
    at = x * 1e-3
    _fill(axes, [line * 1e3 for line in plane_cut(Wall(body.nodes, body.surface_quads), 0, at)], style.TISSUE)
    faces = body.hexahedra[:, FACES].reshape(-1, 4)
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    lines = plane_cut(Wall(body.nodes, faces[first]), 0, at)
    _add_mesh(axes, [line * 1e3 for line in lines])
    _draw_walls(axes, ((name, plane_cut(wall, 0, at)) for name, wall in body.walls.items()))
    if body.hyoid is not None and body.hyoid.surface is not None:
        _draw_bone(axes, plane_cut(body.hyoid.surface, 0, at))
    axes.set_title(f"{letter}: x = {x:.0f} mm")
    axes.set(xlabel="y, lateral (mm)", ylabel="z, up (mm)")


def _set_frontal_axes(panels: list[Axes], body: Speaker) -> None:
    """The same for all: room for the tongue and what lies above it."""
    nodes = body.nodes[np.unique(body.hexahedra)] * 1e3
    tops = [line[:, 1].max() * 1e3 for wall in body.walls.values() for line in midsagittal_cut(wall)]
    low, high = nodes[:, 2].min() - 2.0 * MARGIN, max([nodes[:, 2].max(), *tops]) + MARGIN
    half = np.abs(nodes[:, 1]).max() + 2.0 * MARGIN
    for axes in panels:
        axes.set(xlim=(-half, half), ylim=(low, high), aspect="equal")


def _draw_jacobians(axes: Axes, body: Speaker) -> None:
    """How many elements have which scaled Jacobian; those under GOOD_JACOBIAN stand out."""
    quality = body.scaled_jacobians
    counts, edges = np.histogram(quality, bins=np.arange(0.0, 1.0 + BIN / 2, BIN))
    poor = edges[1:] < GOOD_JACOBIAN + BIN / 2
    colours = np.where(poor, style.VERMILION, style.FAINT)
    axes.bar(edges[:-1], counts, BIN * 0.92, align="edge", color=colours)
    axes.axvline(GOOD_JACOBIAN, color=style.REST, linewidth=0.9, linestyle=(0, (4, 3)))
    axes.set(xlim=(0.0, 1.0), xlabel="scaled Jacobian", ylabel="elements")
    axes.set_title(f"smallest {quality.min():.3f}, median {np.median(quality):.2f}", fontsize=9.0, fontweight="normal")


def _draw_walls(axes: Axes, cuts: Iterable[tuple[str, list[FloatArray]]]) -> None:
    for name, lines in cuts:
        colour = WALL_COLOURS.get(name, style.WALL)
        drawn = LineCollection([line * 1e3 for line in lines], colors=colour, linewidths=1.7, zorder=3)
        drawn.set_gid(f"wall:{name}")
        axes.add_collection(drawn)


def _draw_bone(axes: Axes, lines: list[FloatArray]) -> None:
    bone = _fill(axes, [line * 1e3 for line in lines], style.BONE)
    if bone is not None:
        bone.set(edgecolor=style.WALL, linewidth=1.0, zorder=2.8, alpha=1.0)
        bone.set_gid("hyoid")


def _add_mesh(axes: Axes, lines: FloatArray | list[FloatArray]) -> None:
    mesh = LineCollection(list(lines), colors=style.FIBRE, linewidths=0.4, alpha=0.6, zorder=2.5)
    mesh.set_gid("mesh")
    axes.add_collection(mesh)


def _fill(axes: Axes, outlines: list[FloatArray], colour: str) -> PathPatch | None:
    """Closed lines (k, 2), holes included."""
    closed = [Path(np.concatenate([line, line[:1]]), closed=True) for line in outlines if len(line) > 2]
    if not closed:
        return None
    patch = PathPatch(Path.make_compound_path(*closed), facecolor=colour, edgecolor="none", alpha=0.45, zorder=2)
    axes.add_patch(patch)
    return patch


def _legend(body: Speaker) -> list[Patch | Line2D]:
    handles: list[Patch | Line2D] = [Patch(facecolor=style.TISSUE, edgecolor=style.FIBRE, alpha=0.6, label="tongue")]
    for name in body.walls:
        colour = WALL_COLOURS.get(name, style.WALL)
        handles.append(Line2D([], [], color=colour, linewidth=1.7, label=name.replace("_", " ")))
    if body.hyoid is not None:
        handles.append(Patch(facecolor=style.BONE, edgecolor=style.WALL, label="hyoid bone"))
        handles.append(Line2D([], [], color=style.SKY, linewidth=1.0, marker=".", label="springs"))
    return handles
