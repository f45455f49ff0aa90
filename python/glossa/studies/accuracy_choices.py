"""The numerical choices of an accuracy study: which there are, what each changes, and what it is measured against.

Elements are compared at equal nodes: those of Q2P1 are the hexahedra of a resolution eight by eight. An equilibrium
has two tolerances, which ``accuracy`` sets together and this study one by one: the residual at which it counts as
found, and how deep a wall may be entered (glossa.tolerances). Movements have one of their own, the local error; contact
follows the steps there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from glossa.errors import InputError
from glossa.scene import Scene
from glossa.simulation import LOCAL_ERROR
from glossa.studies.accuracy_settings import LEFT_OUT, MOVING, AccuracySettings
from glossa.tolerances import ACCURACIES, Tolerances

POSTURE, MOVEMENT = "posture", "movement"
KINDS = (POSTURE, MOVEMENT)

MESH, SOLVE, STEPS, WHOLE = "mesh", "solve", "steps", "all effects"
AGAINST: Mapping[str, str] = MappingProxyType(
    {
        MESH: "the limit of fine meshes, by extrapolation, or the finest resolution where there are only two",
        SOLVE: "the equilibrium of the same mesh at tolerances far below those of accuracy='reference'",
        STEPS: "the movement by SDIRK2 in short steps",
        WHOLE: "the same with all effects",
    }
)
"""What an error is measured against; that of "all effects" is no error but what an effect does."""

INTEGRATORS: Mapping[str, str] = MappingProxyType(
    {"SDIRK2": "SDIRK2", "BDF2": "BDF2", "backward Euler": "backward_euler"}
)
"""Families of fixed steps, and what :meth:`glossa.Scene.simulate` calls them."""

EXACT = {"accuracy": Tolerances(residual=1e-11, gap=0.1e-6)}
"""Of the reference of equilibria."""

NEXT = {"accuracy": Tolerances(residual=1e-11, gap=0.25e-6)}
"""The same of the second one that shows the error of the first."""

_OTHERS = 2  # finest resolution with other elements: Q1 locks, Q2P1 has more couplings to factorise


@dataclass(frozen=True, kw_only=True)
class Run:
    """One solve.

    Attributes:
        kind: "posture" or "movement".
        vowel: its commands.
        resolution: of the built-in speaker.
        scene: options that differ from those of the study's scene.
        solve: arguments of the solve.
    """

    kind: str
    vowel: str
    resolution: int = 1
    scene: tuple[tuple[str, Any], ...] = ()
    solve: tuple[tuple[str, Any], ...] = ()


@dataclass(frozen=True, kw_only=True)
class Choice:
    """One row of the study: all is standard but one thing.

    Attributes:
        kind: "posture" or "movement".
        family: what is varied.
        label: how it is set, in words.
        setting: the same as a number, NaN where it is none.
        units: of the number.
        against: what errors are measured against, one of :data:`AGAINST`.
        resolution, scene, solve: as in :class:`Run`.
    """

    kind: str
    family: str
    label: str
    setting: float = math.nan
    units: str = "1"
    against: str
    resolution: int = 1
    scene: Mapping[str, Any] = field(default_factory=dict)
    solve: Mapping[str, Any] = field(default_factory=dict)

    def run(self, vowel: str) -> Run:
        """The solve of a vowel."""
        return Run(
            kind=self.kind,
            vowel=vowel,
            resolution=self.resolution,
            scene=tuple(sorted(self.scene.items())),
            solve=tuple(sorted(self.solve.items())),
        )


def references(choice: Choice, vowel: str, step: float) -> tuple[Run, Run | None]:
    """The solve that the errors of a choice are measured against, and one that shows the error of that one.

    Args:
        choice: not one that is measured against the limit of fine meshes.
        vowel: of the solve.
        step: reference step of the settings, s.
    """
    if choice.against == SOLVE:
        exact, second = (Choice(kind=POSTURE, family="", label="", against=SOLVE, solve=own) for own in (EXACT, NEXT))
        return exact.run(vowel), second.run(vowel)
    if choice.against == STEPS:
        fine = {"accuracy": "reference", "integrator": "SDIRK2"}
        half, own = (
            Choice(kind=MOVEMENT, family="", label="", against=STEPS, solve=fine | {"dt": dt})
            for dt in (0.5 * step, step)
        )
        return half.run(vowel), own.run(vowel)
    return Run(kind=choice.kind, vowel=vowel), None


def choices(scene: Scene, settings: AccuracySettings, resolutions: Sequence[int]) -> list[Choice]:
    """All choices, postures first, a family's own from coarse to fine."""
    found: list[Choice] = []
    if settings.vowels:
        found += _posture_choices(scene, settings, resolutions)
    if settings.moving:
        found += _movement_choices(scene, settings)
    return found


def _posture_choices(scene: Scene, settings: AccuracySettings, resolutions: Sequence[int]) -> Iterator[Choice]:
    if len(resolutions) > 1:
        yield from _meshes(scene, resolutions)
    yield from _tolerances(scene, settings)
    for mirror in (True, False):
        if scene.mirror or not mirror or _possible(scene, mirror=True):
            label = "mirrored" if mirror else "full"
            half: dict[str, Any] = {} if mirror == scene.mirror else {"mirror": mirror}
            yield Choice(kind=POSTURE, family="half", label=label, against=SOLVE, scene=half)
    for threads in settings.threads:
        options: dict[str, Any] = {} if threads == scene.threads else {"threads": threads}
        label = f"{threads} thread{'s' * (threads > 1)}"
        yield Choice(kind=POSTURE, family="threads", label=label, setting=float(threads), against=SOLVE, scene=options)
    yield from _effects(POSTURE, scene, [name for name in settings.effects if name not in MOVING])


def _tolerances(scene: Scene, settings: AccuracySettings) -> Iterator[Choice]:
    """The presets; then residuals with the standard depth, and depths with the standard residual."""
    for accuracy, own in ACCURACIES.items():
        solve: dict[str, Any] = {} if accuracy == "standard" else {"accuracy": accuracy}
        yield Choice(kind=POSTURE, family="preset", label=accuracy, setting=own.residual, against=SOLVE, solve=solve)
    standard = ACCURACIES["standard"]
    for value in settings.residuals:
        solve = {"accuracy": replace(standard, residual=value)}
        yield Choice(kind=POSTURE, family="residual", label=f"{value:g}", setting=value, against=SOLVE, solve=solve)
    for value in settings.gaps if scene.contact else ():
        yield Choice(
            kind=POSTURE,
            family="contact",
            label=f"{1e6 * value:g} µm",
            setting=value,
            units="m",
            against=SOLVE,
            solve={"accuracy": replace(standard, gap=value)},
        )


def _meshes(scene: Scene, resolutions: Sequence[int]) -> Iterator[Choice]:
    """Resolutions with the standard element, then with the others."""
    for family, element in (("mesh", "Q1P0"), ("element", "Q1"), ("element", "Q2P1")):
        for r in resolutions:
            if element == "Q1P0" or r <= _OTHERS:
                yield Choice(
                    kind=POSTURE,
                    family=family,
                    label=f"resolution {r}" if family == "mesh" else f"{element}, resolution {r}",
                    setting=1.0 / r,
                    against=MESH,
                    resolution=r,
                    scene={} if element == scene.element else {"element": element},
                )


def _movement_choices(scene: Scene, settings: AccuracySettings) -> Iterator[Choice]:
    for family, integrator in INTEGRATORS.items():
        for step in settings.steps:
            yield Choice(
                kind=MOVEMENT,
                family=family,
                label=f"{1e3 * step:g} ms",
                setting=step,
                units="s",
                against=STEPS,
                solve={"dt": step, "integrator": integrator},
            )
    tolerated = {f"{1e6 * error:g} µm": error for error in settings.local_errors} | LOCAL_ERROR
    for label, error in sorted(tolerated.items(), key=lambda pair: -pair[1]):
        named = label if label in LOCAL_ERROR else error
        yield Choice(
            kind=MOVEMENT,
            family="adaptive",
            label=label,
            setting=error,
            units="m",
            against=STEPS,
            solve={} if named == "standard" else {"accuracy": named},
        )
    yield from _effects(MOVEMENT, scene, settings.effects)


def _effects(kind: str, scene: Scene, names: Sequence[str]) -> Iterator[Choice]:
    yield Choice(kind=kind, family="effects", label="all", against=WHOLE)
    for name in names:
        if name in scene.effects:
            yield Choice(kind=kind, family="effects", label=f"no {name}", against=WHOLE, scene=LEFT_OUT[name])


def _possible(scene: Scene, **options: Any) -> bool:
    try:
        Scene(scene.speaker, **{**scene.options, **options})
    except InputError:
        return False
    return True
