"""Figures of the acoustics: area functions, transfer functions with their formants, and the F1-F2 chart of vowels."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter

from glossa.acoustics import AreaFunction, Formants, TubeConstants, formants
from glossa.acoustics.formants import WIDEST
from glossa.checks import positive_number
from glossa.errors import InputError
from glossa.figures import style

F1_RANGE = (200.0, 900.0)
F2_RANGE = (600.0, 2600.0)


@style.styled
def area_functions(areas: Mapping[str, AreaFunction]) -> Figure:
    """Area along the tract, glottis on the left, as the steps that the acoustics uses.

    Args:
        areas: by name, for example of the vowel.

    Raises:
        InputError: no area function.
    """
    _some(areas)
    sheet = style.new_sheet(6.4, 3.2)
    axes = sheet.subplots()
    colours = style.colours_of(areas)
    for name, area in areas.items():
        edges = np.concatenate([[0.0], np.cumsum(area.lengths)]) * 100.0
        axes.stairs(area.areas * 1e4, edges, color=colours[name], linewidth=1.6, label=style.title_of(name))
        axes.plot(edges[-1], area.areas[-1] * 1e4, "o", color=colours[name], markersize=4.0)
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("distance from the glottis (cm)")
    axes.set_ylabel("area (cm²)")
    axes.legend(loc="best")
    return sheet


@style.styled
def transfer_functions(
    areas: Mapping[str, AreaFunction], *, constants: str | TubeConstants = "badin", top: float = 5000.0
) -> Figure:
    """Flow through the lips over flow at the glottis in dB, one panel for each tract, formants marked.

    Lines are the first four formants, grey bands their bandwidths; dotted lines are poles wider than 350 Hz.

    Args:
        areas: by name.
        constants: name of a set in :data:`glossa.acoustics.TUBE_CONSTANTS`, or the set.
        top: highest frequency, Hz.

    Raises:
        InputError: no area function, or bad arguments.
    """
    _some(areas)
    highest = positive_number(top, "top (Hz)")
    sheet = style.new_sheet(6.4, 0.6 + 1.7 * len(areas))
    panels = sheet.subplots(len(areas), 1, sharex=True, squeeze=False)[:, 0]
    colours = style.colours_of(areas)
    table = formants(list(areas.values()), 4, constants=constants)
    frequency = np.arange(5.0, highest + 2.5, 5.0)
    for axes, (name, area), found in zip(panels, areas.items(), table, strict=True):
        level = 20.0 * np.log10(np.abs(area.transfer_function(frequency, constants=constants)))
        axes.plot(frequency / 1e3, level, color=colours[name], linewidth=1.5)
        _mark(axes, found, highest)
        axes.set_ylabel("|H| (dB)")
        axes.set_title(style.title_of(name), color=colours[name], loc="left")
    panels[-1].set_xlabel("frequency (kHz)")
    panels[-1].set_xlim(0.0, highest / 1e3)
    return sheet


def _mark(axes: Axes, found: Formants, top: float) -> None:
    for pole in found.poles:
        if pole.real < top and 2.0 * pole.imag > WIDEST:
            axes.axvline(pole.real / 1e3, color=style.FAINT, linewidth=0.9, linestyle=":", zorder=0)
    for number, (centre, width) in enumerate(zip(found.frequencies, found.bandwidths, strict=True), start=1):
        if not centre < top:
            continue
        axes.axvspan(
            (centre - 0.5 * width) / 1e3, (centre + 0.5 * width) / 1e3, color=style.FAINT, alpha=0.35, zorder=0
        )
        axes.axvline(centre / 1e3, color=style.REST, linewidth=0.7, zorder=0)
        axes.annotate(
            f"F{number} {centre:.0f}",
            (centre / 1e3, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(2, -1),
            textcoords="offset points",
            va="top",
            fontsize=7.5,
        )


@style.styled
def vowel_chart(found: Mapping[str, Formants], published: pd.DataFrame | None = None) -> Figure:
    """F1 against F2 as phoneticians draw it: close vowels on top, front vowels on the left, logarithmic axes.

    Args:
        found: formants by vowel.
        published: ``F1_Hz`` and ``F2_Hz`` by vowel, for example :func:`glossa.paper.formants_simulated`: open circles,
            joined to the vowel of the same name.

    Raises:
        InputError: no formants, or fewer than two of a vowel.
    """
    _some(found)
    for name, one in found.items():
        if len(one) < 2 or not np.isfinite(one.frequencies[:2]).all():
            raise InputError(f"formants of {name!r} need F1 and F2 for the chart, got {one!r}")
    sheet = style.new_sheet(4.8, 4.4)
    axes = sheet.subplots()
    colours = style.colours_of(found)
    reference = {} if published is None else {str(v): (row["F2_Hz"], row["F1_Hz"]) for v, row in published.iterrows()}
    for name, (f2, f1) in reference.items():
        colour = colours.get(name, style.VOWEL_COLOURS.get(name, style.REST))
        axes.plot(f2, f1, "o", markerfacecolor="none", color=colour, markersize=9.0, zorder=2)
    for name, one in found.items():
        f1, f2 = one.frequencies[:2]
        axes.plot(f2, f1, "o", color=colours[name], markersize=6.0, zorder=3)
        axes.annotate(style.title_of(name), (f2, f1), xytext=(6, 5), textcoords="offset points", color=colours[name])
        if name in reference:
            axes.plot([f2, reference[name][0]], [f1, reference[name][1]], color=style.FAINT, linewidth=0.9, zorder=1)
    _scale(axes, found, reference)
    if reference:
        axes.plot([], [], "o", color=style.REST, markersize=6.0, label="glossa")
        axes.plot([], [], "o", markerfacecolor="none", color=style.REST, markersize=9.0, label="published")
        axes.legend(loc="best")
    return sheet


def _scale(axes: Axes, found: Mapping[str, Formants], reference: Mapping[str, tuple[float, float]]) -> None:
    """Logarithmic axes that fall towards the right and upwards and hold every point."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    f1 = [one.frequencies[0] for one in found.values()] + [point[1] for point in reference.values()]
    f2 = [one.frequencies[1] for one in found.values()] + [point[0] for point in reference.values()]
    axes.set_xlim(max(F2_RANGE[1], 1.08 * max(f2)), min(F2_RANGE[0], 0.92 * min(f2)))
    axes.set_ylim(max(F1_RANGE[1], 1.08 * max(f1)), min(F1_RANGE[0], 0.92 * min(f1)))
    axes.xaxis.set_major_locator(FixedLocator([500, 700, 1000, 1500, 2000, 2500, 3000]))
    axes.yaxis.set_major_locator(FixedLocator([200, 300, 400, 500, 600, 800, 1000]))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(ScalarFormatter())
    axes.set_xlabel("F2 (Hz)")
    axes.set_ylabel("F1 (Hz)")


def _some(results: Mapping[str, object]) -> None:
    if not results:
        raise InputError("a figure needs at least one result")
