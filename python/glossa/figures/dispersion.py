"""Figures of the sensitivity of a vowel: scatter of six midsagittal nodes (fig. 11), and formants against a command."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from glossa import paper
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError
from glossa.figures import style
from glossa.figures.bare_posture import bare_posture, check_study, drawable
from glossa.figures.midsagittal import draw_outline, draw_surroundings, set_axes
from glossa.studies.dispersion import SIGMAS, dispersion_ellipse
from glossa.studies.sensitivity_summary import PANELS, TABLE_VOWEL, scatter

AROUND = 7.0
"""Room around the points, mm."""


@style.styled
def dispersion(study: xr.Dataset, speaker: Speaker, sigmas: float = SIGMAS) -> Figure:
    """Scatter of the six nodes over all runs, with ellipses, and over the runs of GGp, GGa and Sty, as fig. 11.

    Args:
        study: of :func:`glossa.studies.sensitivity`.
        speaker: whose study it is.
        sigmas: standard deviations at which the ellipses end; where samples are too few or degenerate there is none.

    Raises:
        InputError: another study, or one of another speaker.
    """
    check_study(study, "sensitivity", speaker)
    vowel = study.attrs["vowel"]
    posture = drawable({vowel: bare_posture(speaker, study["vowel_positions"].to_numpy())})[vowel]
    sheet = style.new_sheet(9.2, 7.2)
    for axes, panel in zip(sheet.subplots(2, 2, sharex=True, sharey=True).ravel(), PANELS, strict=True):
        draw_surroundings(axes, {vowel: posture})
        draw_outline(axes, speaker, posture.positions, colour=style.FAINT).set_linewidth(1.1)
        for node in study["node"].values.tolist():
            _draw_scatter(axes, study, panel, node, sigmas if panel == "all" else None)
        words = "all muscles" if panel == "all" else f"{panel} only"
        axes.set_title(f"{style.title_of(vowel)}, {words}")
        set_axes(axes, speaker)
        axes.label_outer()
    _zoom(sheet.axes[0], study)
    handles = [
        Line2D(
            [], [], linestyle="", marker="o", markersize=3.0, markerfacecolor="none", color=style.BLACK, label="one run"
        ),
        Line2D([], [], color=style.VERMILION, label=f"{sigmas:g}σ ellipse"),
        Line2D([], [], color=style.BLUE, label="its major axis"),
        Line2D([], [], color=style.FAINT, label="the vowel"),
    ]
    sheet.axes[0].legend(handles=handles, loc="lower center")
    return sheet


def _draw_scatter(axes: Axes, study: xr.Dataset, panel: str, node: str, sigmas: float | None) -> None:
    points = scatter(study, panel, node)
    x, z = points.T
    dots = axes.scatter(x, z, s=5.0, facecolors="none", edgecolors=style.BLACK, linewidths=0.6, zorder=6)
    dots.set_gid(f"scatter:{node}")
    if sigmas is None:
        return
    try:
        ellipse = dispersion_ellipse(points, sigmas)
    except InputError:  # nothing to draw where nothing spreads
        return
    (line,) = axes.plot(*ellipse.outline().T, color=style.VERMILION, linewidth=1.3, zorder=7)
    line.set_gid(f"ellipse:{node}")
    axes.plot(*ellipse.major_axis().T, color=style.BLUE, linewidth=1.1, zorder=7)


def _zoom(axes: Axes, study: xr.Dataset) -> None:
    """Limits around the points of all panels."""
    points = np.concatenate([scatter(study, "all", node) for node in study["node"].values.tolist()])
    if len(points):
        low, high = points.min(axis=0) - AROUND, points.max(axis=0) + AROUND
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


@style.styled
def saturation(study: xr.Dataset, muscle: str = "GGa") -> Figure:
    """F1 to F3 against the change of one muscle's command, beside Table VI for /i/.

    The saturation effect of section IV.C would leave F1 where it is when GGa changes.

    Args:
        study: of :func:`glossa.studies.sensitivity`.
        muscle: one of the study.

    Raises:
        InputError: another study, or a muscle that it has not.
    """
    check_study(study, "sensitivity")
    if muscle not in study["muscle"]:
        raise InputError(f"this study has no muscle {muscle!r}; it has {', '.join(study['muscle'].values)}")
    run = study.sel(muscle=muscle)
    shown = run["asked"].to_numpy()
    change = np.append(run["change"].to_numpy()[shown], 0.0)
    order = np.argsort(change)
    sheet = style.new_sheet(5.4, 6.0)
    for number, axes in enumerate(sheet.subplots(3, 1, sharex=True), start=1):
        values = np.append(run["formants"].sel(formant=number).to_numpy()[shown], study["vowel_formants"][number - 1])
        axes.plot(change[order], values[order], "o-", color=style.BLUE, markersize=4.0, label="glossa")
        if study.attrs["vowel"] == TABLE_VOWEL:
            _draw_table(axes, muscle, number)
        axes.axvline(0.0, color=style.FAINT, linewidth=0.7, zorder=0)
        axes.set_ylabel(f"F{number} (Hz)")
    sheet.axes[0].set_title(f"{style.title_of(study.attrs['vowel'])}: command of {muscle}", loc="left")
    sheet.axes[0].legend(loc="best")
    sheet.axes[-1].set_xlabel(f"change of the command of {muscle} (%); more is weaker")
    return sheet


def _draw_table(axes: Axes, muscle: str, number: int) -> None:
    table = paper.sensitivity_i()
    if muscle in table.index.get_level_values("muscle"):
        rows = table.xs(muscle, level="muscle")[f"F{number}_Hz"]
        own = paper.formants_simulated()[f"F{number}_Hz"][TABLE_VOWEL]
        points = np.array(sorted([*zip(rows.index, rows, strict=True), (0.0, own)]), dtype=float)
        axes.plot(*points.T, "s--", color=style.REST, markersize=3.5, label="paper, Table VI", zorder=1)
