"""Figures of the material: laws of the tissue (fig. 3) and damping (fig. 4)."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from glossa.figures import style
from glossa.figures.bare_posture import check_study

BAND = (3.0, 10.0)
"""Modal frequencies for which the paper chose its damping, Hz."""

_DASHES = (":", "--", "-.", (0, (3.0, 1.0, 1.0, 1.0, 1.0, 1.0)), "-")
_COLOURS = (style.REST, style.BLUE, style.GREEN, style.ORANGE, style.VERMILION)


@style.styled
def stress_strain(study: xr.Dataset) -> Figure:
    """Nominal stress against strain, a line for each law, with Young's moduli.

    Args:
        study: of :func:`glossa.studies.stress_strain`.

    Raises:
        InputError: another study.
    """
    check_study(study, "stress_strain")
    sheet = style.new_sheet(5.6, 4.0)
    axes = sheet.subplots()
    for number, law in enumerate(study["law"].values.tolist()):
        one = study.sel(law=law)
        label = f"{law}: E = {float(one['modulus']) / 1e3:.3g} kPa"
        axes.plot(
            study["strain"],
            one["nominal_stress"] / 1e3,
            color=_COLOURS[number % len(_COLOURS)],
            linestyle=_DASHES[number % len(_DASHES)],
            linewidth=1.6,
            label=label,
        )
    axes.axhline(0.0, color=style.FAINT, linewidth=0.7, zorder=0)
    axes.axvline(0.0, color=style.FAINT, linewidth=0.7, zorder=0)
    axes.set(xlabel="strain", ylabel="nominal stress (kPa)")
    axes.legend(loc="best")
    return sheet


@style.styled
def damping_ratio(study: xr.Dataset) -> Figure:
    """Damping over critical damping against frequency; grey where the paper wants it near 1.

    Args:
        study: of :func:`glossa.studies.damping_ratio`.

    Raises:
        InputError: another study.
    """
    check_study(study, "damping_ratio")
    sheet = style.new_sheet(5.6, 3.4)
    axes = sheet.subplots()
    axes.axvspan(*BAND, color=style.FAINT, alpha=0.3, zorder=0)
    axes.axhline(1.0, color=style.REST, linewidth=0.9, linestyle="--")
    axes.plot(study["frequency"], study["ratio"], color=style.BLUE, linewidth=1.7)
    axes.set(xscale="log", xlim=(float(study["frequency"].min()), float(study["frequency"].max())))
    axes.set(ylim=(0.0, 5.0), xlabel="frequency (Hz)", ylabel="damping over critical damping")
    axes.xaxis.set_major_formatter("{x:g}")
    words = f"α = {study.attrs['alpha_per_s']:g} 1/s, β = {study.attrs['beta_s']:g} s"
    axes.set_title(words, loc="left")
    return sheet
