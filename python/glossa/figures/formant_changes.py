"""Formants of a vowel whose commands change: beside Table VI, and their scatter."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from glossa import paper
from glossa.anatomy.arrays import FloatArray
from glossa.errors import InputError
from glossa.figures import style
from glossa.figures.bare_posture import check_study
from glossa.studies.sensitivity_summary import TABLE_VOWEL, compared_changes

FORMANTS = (1, 2, 3)


@style.styled
def formant_changes(study: xr.Dataset) -> Figure:
    """Change of F1, F2 and F3 in each run against that of Table VI, coloured by the muscle whose command changes.

    Args:
        study: of :func:`glossa.studies.sensitivity`, of /i/.

    Raises:
        InputError: another study, or another vowel.
    """
    check_study(study, "sensitivity")
    table = compared_changes(study)
    if table.empty:
        raise InputError("Table VI has no runs of this study to compare with")
    sheet = style.new_sheet(9.6, 3.7)
    colours = _colours(study)
    for number, axes in zip(FORMANTS, sheet.subplots(1, 3), strict=True):
        for muscle, rows in table.groupby(level="muscle", sort=False):
            colour = colours[str(muscle)]
            axes.plot(rows[f"paper_F{number}"], rows[f"F{number}"], "o", color=colour, markersize=3.5, label=muscle)
        values = table[[f"F{number}", f"paper_F{number}"]].to_numpy()
        ends = np.array([np.nanmin(values), np.nanmax(values)])
        axes.plot(ends, ends, color=style.FAINT, linewidth=1.0, zorder=0)
        axes.set(xlabel=f"change of F{number} in Table VI (Hz)", ylabel="ours (Hz)", aspect="equal")
        axes.set_title(f"F{number}", loc="left")
    _name_muscles(sheet, colours)
    return sheet


@style.styled
def formant_dispersion(study: xr.Dataset) -> Figure:
    """F1 and F3 against F2 of every run, ours and those of Table VI, coloured by the muscle whose command changes.

    Args:
        study: of :func:`glossa.studies.sensitivity`; for other vowels than /i/ there is nothing of the paper's.

    Raises:
        InputError: another study.
    """
    check_study(study, "sensitivity")
    own = study["vowel_formants"].to_numpy()
    clouds = {"glossa": ({m: study["formants"].sel(muscle=m).to_numpy() for m in study["muscle"].values.tolist()}, own)}
    if study.attrs["vowel"] == TABLE_VOWEL:
        table = paper.sensitivity_i()
        printed = paper.formants_simulated().loc[[TABLE_VOWEL], ["F1_Hz", "F2_Hz", "F3_Hz"]].to_numpy(dtype=float)[0]
        known = {str(m): rows.to_numpy(dtype=float) for m, rows in table.groupby(level="muscle", sort=False)}
        clouds["paper"] = (known, printed)
    sheet = style.new_sheet(0.6 + 3.4 * len(clouds), 6.0)
    panels = sheet.subplots(2, len(clouds), sharex=True, sharey="row", squeeze=False)
    colours = _colours(study)
    for column, (who, (runs, centre)) in zip(panels.T, clouds.items(), strict=True):
        for axes, number in zip(column, (1, 3), strict=True):
            _draw_cloud(axes, runs, centre, number, colours)
        column[0].set_title(who)
        column[1].set_xlabel("F2 (Hz)")
    for axes, number in zip(panels[:, 0], (1, 3), strict=True):
        axes.set_ylabel(f"F{number} (Hz)")
    _name_muscles(sheet, colours)
    return sheet


def _draw_cloud(
    axes: Axes, runs: dict[str, FloatArray], centre: FloatArray, number: int, colours: dict[str, str]
) -> None:
    for muscle, rows in runs.items():
        colour = colours.get(muscle, style.FAINT)
        (dots,) = axes.plot(rows[:, 1], rows[:, number - 1], "o", color=colour, markersize=3.5)
        dots.set_gid(f"runs:{muscle}")
    axes.plot(centre[1], centre[number - 1], "+", color=style.BLACK, markersize=10.0, zorder=5)


def _colours(study: xr.Dataset) -> dict[str, str]:
    names = study["muscle"].values.tolist()
    hues = mpl.colormaps["tab10"]
    return {name: mpl.colors.to_hex(hues(number % 10)) for number, name in enumerate(names)}


def _name_muscles(sheet: Figure, colours: dict[str, str]) -> None:
    handles = [Line2D([], [], linestyle="", marker="o", markersize=4.0, color=c, label=m) for m, c in colours.items()]
    sheet.legend(handles=handles, loc="outside lower center", ncols=len(handles), handletextpad=0.1, columnspacing=1.0)
