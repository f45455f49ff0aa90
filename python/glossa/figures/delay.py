"""Figure of the delay of the reflex: trajectories and force of movements with several delays."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from glossa.errors import InputError
from glossa.figures import style
from glossa.figures.bare_posture import check_study


@style.styled
def delay_traces(study: xr.Dataset, node: str = "apical", muscle: str = "GGp") -> Figure:
    """Displacement of one node, backward and upward, and force of one muscle over time, a line for each delay.

    Args:
        study: of :func:`glossa.studies.delay`.
        node: one of the six midsagittal nodes.
        muscle: of the speaker.

    Raises:
        InputError: another study, an unknown node or an unknown muscle.
    """
    check_study(study, "delay")
    for name, known in ((node, study["node"]), (muscle, study["muscle"])):
        if name not in known:
            raise InputError(f"this study has no {known.name} {name!r}; it has {', '.join(known.values)}")
    sheet = style.new_sheet(6.4, 6.0)
    panels = sheet.subplots(3, 1, sharex=True)
    milliseconds = study["time"].to_numpy() * 1e3
    delays = study["delay"].values.tolist()
    hues = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(delays)))
    for value, hue in zip(delays, hues, strict=True):
        run = study.sel(delay=value)
        moved = run["trace"].sel(node=node).to_numpy() * 1e3
        own = value == study.attrs["reference_delay_s"]
        lines = (moved[:, 0], moved[:, 2], run["force"].sel(muscle=muscle).to_numpy())
        for axes, values in zip(panels, lines, strict=True):
            width = 2.2 if own else 1.2
            axes.plot(milliseconds, values, color=hue, linewidth=width, label=f"{value * 1e3:g} ms")
    words = (f"{node}, backward (mm)", f"{node}, upward (mm)", f"{muscle} (N)")
    for axes, label in zip(panels, words, strict=True):
        axes.set_ylabel(label)
    panels[0].set_title(f"{style.title_of(study.attrs['vowel'])}: delay of the reflex", loc="left")
    panels[0].legend(loc="best", ncols=2)
    panels[-1].set_xlabel("time (ms)")
    panels[-1].set_xlim(milliseconds[0], milliseconds[-1])
    sheet.align_ylabels()
    return sheet
