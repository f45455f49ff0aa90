"""From an area function to formants and sound."""

from glossa.acoustics.area_function import AreaFunction
from glossa.acoustics.constants import (
    TUBE_CONSTANTS,
    BoundaryLayer,
    MeanLosses,
    ResonantWall,
    TubeConstants,
    YieldingWall,
)
from glossa.acoustics.formants import Formants, FormantTable, formants
from glossa.acoustics.sensitivity import sensitivity
from glossa.acoustics.sound import Sound
from glossa.acoustics.source import LF, Rosenberg
from glossa.acoustics.spectrum import transfer_function
from glossa.acoustics.synthesis import synthesize

__all__ = [
    "LF",
    "TUBE_CONSTANTS",
    "AreaFunction",
    "BoundaryLayer",
    "FormantTable",
    "Formants",
    "MeanLosses",
    "ResonantWall",
    "Rosenberg",
    "Sound",
    "TubeConstants",
    "YieldingWall",
    "formants",
    "sensitivity",
    "synthesize",
    "transfer_function",
]
