"""How much an accuracy study computes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from types import MappingProxyType
from typing import Any

from glossa.checks import positive_number, whole_number
from glossa.errors import InputError
from glossa.motor.commands import vowel_commands
from glossa.studies.costs import BARE
from glossa.studies.costs import EFFECTS as ADDED

LEFT_OUT: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "stiffening": {"stiffening": False},
        "reflex": {"reflex": None},
        "force_velocity": {"force_velocity": False},
        "damping": {"damping": None},
        **{effect: {key: BARE[key] for key in options} for effect, options in ADDED.items()},
    }
)
"""Options of a scene that leave an effect out."""

MOVING = ("reflex", "force_velocity", "damping")
"""Effects that an equilibrium knows nothing of."""

_MOST = 12  # of the resolution


def _names(value: Any, what: str) -> Sequence[str]:
    if isinstance(value, str) or not isinstance(value, Sequence) or not all(isinstance(one, str) for one in value):
        raise InputError(f"{what} must be a list of names, got {value!r}")
    if len(set(value)) < len(value):
        raise InputError(f"{what} names something twice: {', '.join(value)}")
    return value


@dataclass(frozen=True, kw_only=True)
class AccuracySettings:
    """How much an accuracy study computes.

    Attributes:
        vowels: equilibria, of Table III.
        moving: vowels of the movements; the commands ramp from the lengths at rest within 30 ms.
        until: end of the movements, s.
        resolutions: of the built-in speaker, rising from 1; with three or more the last three are extrapolated. Only 1:
            no errors of mesh and element. None: 1 and 2 for the built-in speaker, else 1.
        residuals: over force scale, at which an equilibrium counts as found.
        gaps: how deep a wall may be entered in an equilibrium, m.
        threads: of the element loops.
        steps: fixed time steps, s.
        local_errors: tolerated local errors of adaptive steps beside those of the presets, m.
        reference_step: of SDIRK2, s; the reference has half of it, and the distance of both is its own error.
        effects: to leave out.
        repetitions: runs of each choice; the shortest time counts. Runs that take long are not repeated.
    """

    vowels: Sequence[str] = ("i", "a", "u")
    moving: Sequence[str] = ("i", "u")
    until: float = 0.1
    resolutions: Sequence[int] | None = None
    residuals: Sequence[float] = (1e-3, 1e-5, 1e-8, 1e-11)
    gaps: Sequence[float] = (100e-6, 50e-6, 20e-6, 10e-6, 5e-6, 2e-6, 1e-6)
    threads: Sequence[int] = (1, 2)
    steps: Sequence[float] = (0.010, 0.005, 0.0025, 0.001)
    local_errors: Sequence[float] = (100e-6, 10e-6, 0.5e-6)
    reference_step: float = 0.00025
    effects: Sequence[str] = tuple(LEFT_OUT)
    repetitions: int = 3

    @property
    def name(self) -> str:
        """Of the settings: "full" or "quick", whatever their resolutions and repetitions, else "own"."""
        known = {"full": FULL, "quick": QUICK}
        alike: dict[str, Any] = {"resolutions": None, "repetitions": 1}
        own = replace(self, **alike)
        return next((name for name, settings in known.items() if own == replace(settings, **alike)), "own")

    def __post_init__(self) -> None:
        for name in ("vowels", "moving"):
            _names(getattr(self, name), name)
            for vowel in getattr(self, name):
                vowel_commands(vowel)
        if not self.vowels and not self.moving:
            raise InputError("an accuracy study needs at least one vowel, in vowels or in moving")
        for effect in _names(self.effects, "effects"):
            if effect not in LEFT_OUT:
                raise InputError(f"effects: unknown effect {effect!r}; there are {', '.join(LEFT_OUT)}")
        for count in self.threads:
            whole_number(count, "threads", 1, 256)
        positive_number(self.until, "until (s)")
        whole_number(self.repetitions, "repetitions", 1, 1000)
        for name in ("residuals", "gaps", "steps", "local_errors"):
            for value in getattr(self, name):
                positive_number(value, name)
        finest = positive_number(self.reference_step, "reference_step (s)")
        if any(step <= finest for step in self.steps):
            raise InputError(f"reference_step must be shorter than every step, got {finest:g} s")
        if self.resolutions is not None:
            levels = [whole_number(r, "resolution", 1, _MOST) for r in self.resolutions]
            if not levels or levels[0] != 1 or any(b <= a for a, b in pairwise(levels)):
                raise InputError(f"resolutions must rise from 1, got {list(self.resolutions)}")


FULL = AccuracySettings()

QUICK = AccuracySettings(
    vowels=("i",),
    moving=("i",),
    until=0.02,
    resolutions=(1,),
    residuals=(1e-4,),
    gaps=(20e-6, 2e-6),
    threads=(),
    steps=(0.005, 0.0025),
    local_errors=(),
    reference_step=0.0005,
    effects=("contact", "gravity"),
    repetitions=1,
)
"""For tests and a first look."""
