"""Chart of a study of stability: growth of the rightmost root over delay and velocity gain of the reflex."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure

from glossa.errors import InputError
from glossa.figures import style
from glossa.studies.stability import check_stability

_LARGEST = 300.0  # 1/s, where the colours end
_PER_MS = 1e3


@style.styled
def stability(study: xr.Dataset) -> Figure:
    """A row of charts for each posture, one for each gradient c of the force law.

    Colours and upper numbers: growth of the rightmost root, 1/s, blue where small movements die away; lower numbers:
    its frequency, Hz. Line: the border of stability. Star: delay and velocity gain of the scene.

    Args:
        study: of :func:`glossa.studies.stability`.

    Raises:
        InputError: another study, or one with a single delay or velocity gain.
    """
    check_stability(study)
    if study.sizes["delay"] < 2 or study.sizes["velocity_gain"] < 2:
        raise InputError("a chart of stability needs two or more delays and velocity gains")
    rows, columns = study.sizes["posture"], study.sizes["firing_gradient"]
    sheet = style.new_sheet(0.6 + 4.6 * columns, 0.4 + 3.2 * rows)
    panels = sheet.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    norm = SymLogNorm(linthresh=10.0, vmin=-_LARGEST, vmax=_LARGEST)
    for i, row in enumerate(panels):
        for j, axes in enumerate(row):
            one = study.isel(posture=i, firing_gradient=j)
            _draw(axes, one, norm)
            _mark(axes, one, study)
            name, c = str(one["posture"].item()), float(one["firing_gradient"])
            axes.set_title(f"{style.title_of(name)}, c = {c:g} m⁻¹", loc="left")
            if i == rows - 1:
                axes.set_xlabel("delay (ms)")
        row[0].set_ylabel("velocity gain µ (ms)")
    scale = mpl.cm.ScalarMappable(norm, mpl.colormaps["RdBu_r"])
    sheet.colorbar(scale, ax=panels.ravel().tolist(), label="growth of the rightmost root (1/s)", shrink=0.8)
    return sheet


def _draw(axes: Axes, one: xr.Dataset, norm: SymLogNorm) -> None:
    x, y = one["delay"].to_numpy() * _PER_MS, one["velocity_gain"].to_numpy() * _PER_MS
    growth, frequency = one["growth"][..., 0].to_numpy(), one["frequency"][..., 0].to_numpy()
    across, up = np.arange(len(x) + 1) - 0.5, np.arange(len(y) + 1) - 0.5
    axes.pcolormesh(across, up, np.ma.masked_invalid(growth), norm=norm, cmap="RdBu_r", rasterized=True)
    for (i, j), value in np.ndenumerate(growth):
        if np.isfinite(value):
            shade = style.BLACK if abs(value) < 0.3 * _LARGEST else "white"
            axes.text(j, i, f"{value:+.0f}\n{frequency[i, j]:.0f}", ha="center", va="center", fontsize=6.5, color=shade)
    axes.set_xticks(range(len(x)), [f"{value:g}" for value in x])
    axes.set_yticks(range(len(y)), [f"{value:g}" for value in y])


def _mark(axes: Axes, one: xr.Dataset, study: xr.Dataset) -> None:
    """The border and the scene's own reflex, in the even spacing of the chart."""
    delays, gains = one["delay"].to_numpy(), one["velocity_gain"].to_numpy()
    border, heights = one["border_delay"].to_numpy(), one["border_gain"].to_numpy()
    there = np.isfinite(border) & (border <= delays[-1])
    across = np.interp(border[there], delays, np.arange(len(delays)))
    (line,) = axes.plot(across, np.interp(heights[there], gains, np.arange(len(gains))), color=style.BLACK)
    line.set_gid("border")
    own = (study.attrs["delay_s"], study.attrs["velocity_gain_s"])
    if delays[0] <= own[0] <= delays[-1] and gains[0] <= own[1] <= gains[-1]:
        x, y = np.interp(own[0], delays, np.arange(len(delays))), np.interp(own[1], gains, np.arange(len(gains)))
        axes.plot([x + 0.36], [y + 0.33], "*", color=style.YELLOW, markeredgecolor=style.BLACK, markersize=10)
