"""Figures: functions that take results and draw; none of them simulates, none keeps global state.

Each returns a :class:`matplotlib.figure.Figure`, to show in a notebook or to write with ``savefig``.
"""

from glossa.figures.acoustics import area_functions, transfer_functions, vowel_chart
from glossa.figures.charts import force_bars, movement_traces
from glossa.figures.contact import contact_map, electropalatogram
from glossa.figures.midsagittal import midsagittal, midsagittal_panels
from glossa.figures.overview import overview
from glossa.figures.spatial import muscles, surfaces
from glossa.figures.tract import cutting_planes, tract_sections

__all__ = [
    "area_functions",
    "contact_map",
    "cutting_planes",
    "electropalatogram",
    "force_bars",
    "midsagittal",
    "midsagittal_panels",
    "movement_traces",
    "muscles",
    "overview",
    "surfaces",
    "tract_sections",
    "transfer_functions",
    "vowel_chart",
]
