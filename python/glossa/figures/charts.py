"""Charts: muscle forces of postures beside the paper's, and movements over time."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from glossa.errors import InputError
from glossa.figures import style
from glossa.results import Movement, Posture
from glossa.studies.points import tracked_nodes

SHOWN_FORCE = 0.02
"""Part of the largest force from which a muscle has its own line in a movement."""


@style.styled
def force_bars(postures: Mapping[str, Posture], published: pd.DataFrame | None = None) -> Figure:
    """Muscle forces of each posture as bars, beside those published; each panel has its own scale.

    Args:
        postures: by name.
        published: forces in N, one row for each name and one column for each muscle, for example
            :func:`glossa.paper.forces`; names without a row have no second bars.

    Raises:
        InputError: no posture.
    """
    if not postures:
        raise InputError("a figure needs at least one posture")
    sheet = style.new_sheet(6.4, 0.5 + 1.55 * len(postures))
    panels = sheet.subplots(len(postures), 1, sharex=True, squeeze=False)[:, 0]
    draw_force_bars(list(panels), postures, published)
    return sheet


def draw_force_bars(panels: list[Axes], postures: Mapping[str, Posture], published: pd.DataFrame | None) -> None:
    """One panel for each posture; the caller arranges them."""
    colours = style.colours_of(postures)
    for axes, (name, posture) in zip(panels, postures.items(), strict=True):
        forces = posture.forces
        place = np.arange(len(forces))
        rows = [] if published is None or name not in published.index else [published.loc[name].reindex(forces.index)]
        axes.bar(place - 0.2 * len(rows), forces.to_numpy(), 0.38, color=colours[name], label="glossa")
        for row in rows:
            axes.bar(place + 0.2, row.to_numpy(dtype=float), 0.38, color=style.FAINT, label="paper, Table II")
        axes.set_xticks(place, list(forces.index))
        axes.tick_params(axis="x", length=0)
        axes.set_ylabel("force (N)")
        axes.set_title(style.title_of(name), color=colours[name], loc="left")
    if panels:
        panels[0].legend(loc="upper right", handlelength=1.0, borderaxespad=0.0)


@style.styled
def movement_traces(movement: Movement) -> Figure:
    """Displacement of tip and dorsum, and muscle forces, over time.

    Muscles that stay below 2 % of the largest force have no line.

    Raises:
        InputError: a speaker without tip and dorsum.
    """
    sheet = style.new_sheet(6.4, 6.0)
    backward, upward, force = sheet.subplots(3, 1, sharex=True)
    milliseconds = movement.times * 1e3
    colours = {"tip": style.VERMILION, "dorsum": style.BLUE}
    for point, node in tracked_nodes(movement.speaker).items():
        moved = (movement.positions[:, node] - movement.speaker.nodes[node]) * 1e3
        for axes, component in ((backward, 0), (upward, 2)):
            axes.plot(milliseconds, moved[:, component], color=colours[point], linewidth=1.7, label=point)
    for axes, words in ((backward, "backward"), (upward, "upward")):
        axes.axhline(0.0, color=style.FAINT, linewidth=0.7, zorder=0)
        axes.set_ylabel(f"{words} (mm)")
    backward.set_title("displacement from rest", loc="left")
    backward.legend(loc="best")
    _draw_forces(force, movement)
    force.set_title("muscle forces", loc="left")
    force.set_xlabel("time (ms)")
    force.set_xlim(milliseconds[0], milliseconds[-1])
    sheet.align_ylabels()
    return sheet


def _draw_forces(axes: Axes, movement: Movement) -> None:
    """Force lines in the order of their end, labelled at the end."""
    forces = movement.forces
    peak = float(forces.to_numpy().max(initial=0.0))
    shown = [name for name in forces if forces[name].max() > SHOWN_FORCE * peak]
    hues = mpl.colormaps["viridis"](np.linspace(0.0, 0.74, max(len(shown), 1)))
    ends = forces[shown].iloc[-1].sort_values()
    room = 0.09 * peak
    height = -np.inf
    for colour, (name, end) in zip(hues, ends.items(), strict=False):
        axes.plot(movement.times * 1e3, forces[name], color=colour, linewidth=1.5)
        height = max(float(end), height + room)
        axes.annotate(
            str(name),
            (1.0, height),
            xycoords=("axes fraction", "data"),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            color=colour,
            annotation_clip=False,
        )
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("force (N)")
