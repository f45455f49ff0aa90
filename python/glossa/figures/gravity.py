"""Figures of gravity: final shapes without commands (figs 12 and 13), and forces of vowels upright and supine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError
from glossa.figures import style
from glossa.figures.bare_posture import bare_posture, check_study, drawable
from glossa.figures.midsagittal import DOTTED, draw_attachments, draw_outline, draw_surroundings, outline_cut, set_axes
from glossa.surroundings import hyoid_of

LOOKS: Mapping[str, tuple[str, Literal["--", "-"]]] = {"upright": (style.VERMILION, "--"), "supine": (style.BLUE, "-")}
"""Colours and dashes of figs 12 and 13."""

TITLES = {"silent": "gravity alone", "reflex": "gravity and reflex"}


@style.styled
def gravity_shapes(study: xr.Dataset, speaker: Speaker, *, moment: str = "final") -> Figure:
    """Midsagittal shapes under gravity without commands: muscles silent (fig. 12) and reflex only (fig. 13).

    Args:
        study: of :func:`glossa.studies.gravity` or of its first part.
        speaker: whose study it is.
        moment: "final", the end of the movement, or "static", the equilibrium.

    Raises:
        InputError: another study, one of another speaker, or an unknown moment.
    """
    check_study(study, "gravity", speaker)
    if moment not in ("final", "static"):
        raise InputError(f"moment must be 'final' or 'static', got {moment!r}")
    sheet = style.new_sheet(9.6, 4.8)
    panels = sheet.subplots(1, 2, sharex=True, sharey=True)
    for axes, (control, title) in zip(panels, TITLES.items(), strict=True):
        _draw_shapes(axes, study.sel(control=control), speaker, moment)
        axes.set_title(title)
        axes.label_outer()
    words = "in equilibrium" if moment == "static" else f"after {float(study['time'][-1]):g} s"
    handles = [Line2D([], [], color=style.REST, linestyle=DOTTED, label="rest")]
    handles += [Line2D([], [], color=c, linestyle=dash, label=f"{name}, {words}") for name, (c, dash) in LOOKS.items()]
    sheet.legend(handles=handles, loc="outside lower center", ncols=3)
    return sheet


def _draw_shapes(axes: Axes, study: xr.Dataset, speaker: Speaker, moment: str) -> None:
    found = drawable(
        {
            name: bare_posture(
                speaker,
                speaker.nodes + study[moment].sel(gravity=name).to_numpy(),
                study[f"{moment}_hyoid"].sel(gravity=name).to_numpy(),
            )
            for name in LOOKS
        }
    )
    rest = bare_posture(speaker, speaker.nodes)
    assert rest is not None
    draw_surroundings(axes, {"rest": rest})
    draw_attachments(axes, rest)
    draw_outline(axes, speaker, speaker.nodes, colour=style.REST, dotted=True)
    for name, posture in found.items():
        colour, dash = LOOKS[name]
        line = draw_outline(axes, speaker, posture.positions, colour=colour)
        line.set_linestyle(dash)
        line.set_gid(f"tongue:{name}")
        bone = hyoid_of(posture)
        if bone is not None:
            outline_cut(axes, bone, colour, dash=dash)
    set_axes(axes, speaker)


@style.styled
def gravity_forces(study: xr.Dataset, muscle: str = "GGp") -> Figure:
    """Peak and final force of one muscle in movements to vowels, upright and supine, with the change in percent.

    Args:
        study: of :func:`glossa.studies.gravity` or of its second part.
        muscle: of the speaker.

    Raises:
        InputError: another study, or an unknown muscle.
    """
    check_study(study, "gravity")
    if muscle not in study["acting"]:
        raise InputError(f"this study has no muscle {muscle!r}; it has {', '.join(study['acting'].values)}")
    names = study["vowel"].values.tolist()
    sheet = style.new_sheet(7.6, 3.4)
    for axes, which in zip(sheet.subplots(1, 2, sharey=True), ("peak", "final"), strict=True):
        place = np.arange(len(names))
        forces = study[f"{which}_force"].sel(acting=muscle)
        for offset, (position, (colour, _)) in zip((-0.2, 0.2), LOOKS.items(), strict=True):
            axes.bar(place + offset, forces.sel(position=position), 0.38, color=colour, label=position)
        for x, change in zip(place, study[f"{which}_change"].sel(acting=muscle).values.tolist(), strict=True):
            top = float(forces[int(x)].max())
            if np.isfinite(change):
                axes.annotate(f"{change:+.1f} %", (x, top), xytext=(0, 2), textcoords="offset points", ha="center")
        axes.set_xticks(place, [style.title_of(name) for name in names])
        axes.set_title(f"{which} force of {muscle}", loc="left")
        axes.label_outer()
    sheet.axes[0].set_ylabel("force (N)")
    sheet.axes[0].legend(loc="best")
    return sheet
