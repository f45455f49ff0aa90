"""Figure of a size study: seconds, factor and memory against the number of unknowns, on logarithmic axes."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from glossa.figures import style
from glossa.studies.size import check_size

_FACTOR = (
    ("factor_flops", 1e-9, "one factorisation, 10⁹ operations", style.VERMILION, "-"),
    ("whole_flops", 1e-9, "the same, fibres in it", style.VERMILION, "--"),
    ("factor_entries", 1e-6, "its factor, 10⁶ entries", style.BLUE, "-"),
    ("whole_entries", 1e-6, "the same, fibres in it", style.BLUE, "--"),
    ("memory", 1e-9, "memory of the process, GB", style.GREEN, "-"),
)


@style.styled
def size(study: xr.Dataset) -> Figure:
    """What a vowel from rest takes, by vowel; beside it operations and entries of one factor, and memory.

    The broad grey lines grow as nested dissection does: with the powers 2 and 4/3 of the unknowns.

    Args:
        study: of :func:`glossa.studies.size_study`.

    Raises:
        InputError: another study.
    """
    check_size(study)
    sheet = style.new_sheet(8.4, 3.8)
    left, right = sheet.subplots(1, 2)
    unknowns = study["unknowns"].to_numpy()
    for vowel in study["vowel"].values.tolist():
        seconds = study["cpu_seconds"].sel(vowel=vowel)
        left.plot(unknowns, seconds, "o-", color=style.VOWEL_COLOURS[vowel], label=f"/{vowel}/")
    left.plot(unknowns, study["making_seconds"], "s:", color=style.REST, label="speaker and scene")
    left.set_ylabel("processor time (s)")
    for name, scale, words, colour, dashes in _FACTOR:
        right.plot(unknowns, study[name] * scale, "o", linestyle=dashes, color=colour, label=words)
    for name, power in (("factor_flops", 2.0), ("factor_entries", 4.0 / 3.0)):
        scale = next(factor for own, factor, *_ in _FACTOR if own == name)
        start = float(study[name][0]) * scale
        right.plot(unknowns, start * (unknowns / unknowns[0]) ** power, color=style.FAINT, linewidth=2.5, zorder=0.8)
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("unknowns")
        axes.grid(visible=True, color=style.FAINT, linewidth=0.3)
        axes.legend(loc="upper left")
        labels = [f"{count:.0f}\nr = {r}" for r, count in zip(study["resolution"].values, unknowns, strict=True)]
        axes.set_xticks(unknowns, labels)
        axes.xaxis.set_minor_locator(NullLocator())
        low, high = axes.get_ylim()
        axes.set_ylim(low, high * (high / low) ** 0.35)  # room for the legend
    return sheet
