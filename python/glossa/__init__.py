"""glossa: a simulator of the human tongue. Motor commands in; tongue shapes, forces and movements out.

The model is that of Buchaillard, Perrier & Payan (2009), J. Acoust. Soc. Am. 126, 2033-2051. All quantities are SI.
"""

from glossa._core import __version__
from glossa.acoustics import TUBE_CONSTANTS, AreaFunction, Formants, Sound, TubeConstants, synthesize
from glossa.anatomy import Hyoid, Muscle, Speaker, Spring, Wall
from glossa.effects import DEFAULT, Damping, Reflex, Stiffening, Yeoh
from glossa.errors import InputError, SolveError, SolveInterrupted, SpeakerFileError
from glossa.motor import MUSCLES, VOWELS, MotorCommands, Ramp, Schedule
from glossa.results import Movement, Posture, SolveReport
from glossa.scene import Scene
from glossa.simulation import Simulation
from glossa.tract import LIPS, Lips, area_function

__all__ = [
    "DEFAULT",
    "LIPS",
    "MUSCLES",
    "TUBE_CONSTANTS",
    "VOWELS",
    "AreaFunction",
    "Damping",
    "Formants",
    "Hyoid",
    "InputError",
    "Lips",
    "MotorCommands",
    "Movement",
    "Muscle",
    "Posture",
    "Ramp",
    "Reflex",
    "Scene",
    "Schedule",
    "Simulation",
    "SolveError",
    "SolveInterrupted",
    "SolveReport",
    "Sound",
    "Speaker",
    "SpeakerFileError",
    "Spring",
    "Stiffening",
    "TubeConstants",
    "Wall",
    "Yeoh",
    "__version__",
    "area_function",
    "synthesize",
]
