"""Figures: functions that take results and draw; none of them simulates, none keeps global state.

Each returns a :class:`matplotlib.figure.Figure`, to show in a notebook or to write with ``savefig``.
"""

from glossa.figures.accuracy import accuracy
from glossa.figures.acoustics import area_functions, transfer_functions, vowel_chart
from glossa.figures.calibration import calibration
from glossa.figures.cavity import cavity
from glossa.figures.charts import force_bars, movement_traces
from glossa.figures.contact import contact_map, electropalatogram
from glossa.figures.delay import delay_traces
from glossa.figures.dispersion import dispersion, saturation
from glossa.figures.formant_changes import formant_changes, formant_dispersion
from glossa.figures.gravity import gravity_forces, gravity_shapes
from glossa.figures.material import damping_ratio, stress_strain
from glossa.figures.midsagittal import midsagittal, midsagittal_panels
from glossa.figures.overview import overview
from glossa.figures.size import size
from glossa.figures.spatial import frontal_views, muscles, surfaces
from glossa.figures.speaker import speaker
from glossa.figures.stability import stability
from glossa.figures.tract import cutting_planes, tract_sections
from glossa.figures.transversalis import transversalis

__all__ = [
    "accuracy",
    "area_functions",
    "calibration",
    "cavity",
    "contact_map",
    "cutting_planes",
    "damping_ratio",
    "delay_traces",
    "dispersion",
    "electropalatogram",
    "force_bars",
    "formant_changes",
    "formant_dispersion",
    "frontal_views",
    "gravity_forces",
    "gravity_shapes",
    "midsagittal",
    "midsagittal_panels",
    "movement_traces",
    "muscles",
    "overview",
    "saturation",
    "size",
    "speaker",
    "stability",
    "stress_strain",
    "surfaces",
    "tract_sections",
    "transfer_functions",
    "transversalis",
    "vowel_chart",
]
