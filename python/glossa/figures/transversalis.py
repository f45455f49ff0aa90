"""Figure of the transversalis in a vowel: midsagittal outlines and a frontal section in each condition."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.plane_cut import plane_cut
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Wall
from glossa.figures import style
from glossa.figures.bare_posture import bare_posture, check_study, drawable
from glossa.figures.midsagittal import DOTTED, draw_outline, draw_surroundings, set_axes
from glossa.studies.midsagittal_nodes import midsagittal_nodes

LOOKS = {"reflex": style.BLUE, "silent": style.VERMILION, "voluntary": style.GREEN}

WORDS = {"reflex": "reflex, as in Table III", "silent": "transversalis silent", "voluntary": "voluntary"}

PLACE = "palatal"
"""Node in whose frontal plane at rest the section lies."""


@style.styled
def transversalis(study: xr.Dataset, speaker: Speaker) -> Figure:
    """Midsagittal outlines, and the section by the frontal plane of the palatal node, by condition; rest dotted.

    Args:
        study: of :func:`glossa.studies.transversalis`.
        speaker: whose study it is.

    Raises:
        InputError: another study, or one of another speaker.
    """
    check_study(study, "transversalis", speaker)
    found = drawable({name: bare_posture(speaker, study["positions"].sel(condition=name).to_numpy()) for name in LOOKS})
    sheet = style.new_sheet(10.0, 4.9)
    side, front = sheet.subplots(1, 2)
    rest = bare_posture(speaker, speaker.nodes)
    assert rest is not None
    draw_surroundings(side, {"rest": rest})
    draw_outline(side, speaker, speaker.nodes, colour=style.REST, dotted=True)
    at = float(speaker.nodes[midsagittal_nodes(speaker)[PLACE], 0])
    _draw_frontal(front, speaker, speaker.nodes, at, style.REST, "rest", dotted=True)
    for name, posture in found.items():
        draw_outline(side, speaker, posture.positions, colour=LOOKS[name]).set_linewidth(1.5)
        _draw_frontal(front, speaker, posture.positions, at, LOOKS[name], WORDS[name])
    for wall in speaker.walls.values():
        for cut in plane_cut(wall, 0, at):
            front.plot(*(cut * 1e3).T, color=style.WALL, linewidth=1.0, zorder=1)
    set_axes(side, speaker)
    side.set_title(f"{style.title_of(study.attrs['vowel'])}, midsagittal")
    front.set_title(f"frontal section at x = {at * 1e3:.0f} mm")
    front.set(xlabel="y, lateral (mm)", ylabel="z, up (mm)", ylim=side.get_ylim(), aspect="equal")
    sheet.legend(handles=front.get_legend_handles_labels()[0], loc="outside lower center", ncols=4)
    return sheet


def _draw_frontal(
    axes: Axes, speaker: Speaker, positions: FloatArray, at: float, colour: str, label: str, *, dotted: bool = False
) -> None:
    weights, triangles = speaker.smooth_surface.triangulation()
    surface = Wall(np.asarray(weights @ positions), triangles)
    dash = DOTTED if dotted else "-"
    for number, cut in enumerate(plane_cut(surface, 0, at)):
        words = label if number == 0 else None
        (line,) = axes.plot(*(cut * 1e3).T, color=colour, linestyle=dash, linewidth=1.0 if dotted else 1.5, label=words)
        line.set_gid(f"section:{label}")
