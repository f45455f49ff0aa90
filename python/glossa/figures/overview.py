"""The vowels on one sheet: midsagittal shapes above, muscle forces beside Table II below."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from glossa.figures import style
from glossa.figures.charts import draw_force_bars
from glossa.figures.midsagittal import draw_attachment_names, draw_panels, one_speaker
from glossa.results import Posture


@style.styled
def overview(postures: Mapping[str, Posture], published: pd.DataFrame | None = None) -> Figure:
    """A column for each posture: midsagittal outline against rest (dotted), and forces as horizontal bars.

    Args:
        postures: by name, of one speaker.
        published: as for :func:`glossa.figures.charts.force_bars`.

    Raises:
        InputError: no posture, several speakers, or a speaker without a midsagittal section.
    """
    speaker = one_speaker(postures)
    columns = len(postures)
    sheet = style.new_sheet(0.6 + 3.1 * columns, 5.6)
    halves = sheet.subfigures(2, 1, squeeze=False, height_ratios=(3.1, 2.4))
    above, below = halves[0, 0], halves[1, 0]
    shapes = list(above.subplots(1, columns, sharex=True, sharey=True, squeeze=False)[0])
    draw_panels(shapes, postures)
    draw_attachment_names(shapes[0], speaker)
    bars = list(below.subplots(1, columns, squeeze=False)[0])
    draw_force_bars(bars, postures, published)
    for axes in shapes:
        axes.label_outer()
    for number, axes in enumerate(bars):
        axes.set_title("", loc="left")
        axes.tick_params(axis="x", rotation=90)
        if number:
            axes.set_ylabel("")
    above.suptitle(speaker.name, x=0.01, ha="left", fontsize=9, color=style.WALL)
    return sheet
