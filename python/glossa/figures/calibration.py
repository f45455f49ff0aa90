"""The calibration of the built-in speaker: formants and large forces over the paper's, before and after."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from glossa.figures import style

FORMANT_BAND, FORCE_BAND = 0.10, 0.30
"""Deviations that are shaded."""


@style.styled
def calibration(before: xr.Dataset, after: xr.Dataset) -> Figure:
    """Deviations from Table IV and Table II in two panels.

    Args:
        before: table of an outcome, see :meth:`glossa.studies.calibration.Outcome.table`.
        after: likewise.
    """
    sheet = style.new_sheet(7.2, 4.6)
    upper, lower = sheet.subplots(2, 1)
    names = [f"F{n} /{v}/" for v in after.vowel.to_numpy() for n in after.formant.to_numpy()]
    _draw(upper, names, [table.formant_ratio.to_numpy().ravel() for table in (before, after)], FORMANT_BAND)
    upper.set_title("Formants and Table IV", loc="left")
    upper.legend(loc="upper right", ncols=2)
    forces = [name.replace(" of ", " /") + "/" for name in after.force.to_numpy().tolist()]
    _draw(lower, forces, [table.force_ratio.to_numpy() for table in (before, after)], FORCE_BAND)
    lower.set_title("Forces above 1 N and Table II", loc="left")
    return sheet


def _draw(axes: Axes, names: list[str], ratios: list[np.ndarray], band: float) -> None:
    place = np.arange(len(names))
    axes.axhspan(-100.0 * band, 100.0 * band, color=style.FAINT, alpha=0.3, linewidth=0.0)
    axes.axhline(0.0, color=style.REST, linewidth=0.7)
    before, after = (100.0 * (ratio - 1.0) for ratio in ratios)
    axes.vlines(place, before, after, color=style.FAINT, linewidth=1.0)
    axes.plot(place, before, "o", color=style.VERMILION, markerfacecolor="white", label="before")
    axes.plot(place, after, "o", color=style.BLUE, label="after")
    axes.set_xticks(place, names, rotation=60, ha="right", rotation_mode="anchor")
    axes.set_ylabel("deviation (%)")
