"""The runs behind a replication: every study of the paper once, each with what failed."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd
import xarray as xr

from glossa.acoustics import Formants
from glossa.anatomy.arrays import FloatArray
from glossa.effects import gravity_vector
from glossa.errors import InputError, SolveError
from glossa.motor.commands import MUSCLES, VOWELS
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.acoustics import vowel_tracts
from glossa.studies.failure import reason_of
from glossa.studies.gravity import CARDINALS, gravity
from glossa.studies.muscle_effects import muscle_effects
from glossa.studies.run import Progress
from glossa.studies.sensitivity import sensitivity
from glossa.studies.single_muscle import single_muscles
from glossa.studies.transversalis import transversalis
from glossa.studies.vowels import vowels

VOWEL = "i"
"""Of sections III.B and IV."""

_Result = TypeVar("_Result")


@dataclass(frozen=True, kw_only=True)
class Runs:
    """What the studies returned; None, or no entry, where one failed.

    Attributes:
        vowels: converged equilibria of Table III.
        formants: F1 to F4 of these with the lips of Table IV.
        muscles: equilibria of single muscles.
        effects: of :func:`glossa.studies.muscle_effects`.
        transversalis, sensitivity, gravity: of the functions of these names.
        weight: of the tongue, N.
        reasons: why there is no result, by study, or by study and vowel ("vowels i", "formants i").
    """

    vowels: dict[str, Posture] = field(default_factory=dict)
    formants: dict[str, Formants] = field(default_factory=dict)
    muscles: dict[str, Posture] = field(default_factory=dict)
    effects: pd.DataFrame | None = None
    transversalis: xr.Dataset | None = None
    sensitivity: xr.Dataset | None = None
    gravity: xr.Dataset | None = None
    weight: float = math.nan
    reasons: dict[str, str] = field(default_factory=dict)


def run_studies(
    scene: Scene,
    *,
    store: str | Path | None = None,
    executor: Executor | None = None,
    progress: Callable[[str, Progress | None], object] | None = None,
) -> Runs:
    """Every study of the paper in one scene; a solve that fails leaves its reason and stops nothing else.

    Args:
        scene: upright, of a speaker with walls, mobile hyoid, contour "dorsum" and the muscles of Table III.
        store: of the runs of Table VI, as for :func:`glossa.studies.sensitivity`.
        executor: likewise.
        progress: called with a line of text before each study and run, and during Table VI also with how far it is.

    Raises:
        InputError: another scene or speaker, or a store or executor that is refused.
        SolveInterrupted: Ctrl-C; the store holds finished runs of Table VI.
    """
    check_scene(scene)
    tell = progress or (lambda _words, _points: None)
    reasons: dict[str, str] = {}

    def attempt(name: str, words: str, study: Callable[[], _Result]) -> _Result | None:
        tell(words, None)
        try:
            return study()
        except SolveError as error:
            reasons[name] = reason_of(error)
            return None

    def tell_of_gravity(which: str) -> None:
        tell(f"section V: {which}", None)

    words = f"Table VI: commands of /{VOWEL}/"
    # first, because it has the store, whose faults should not wait for the rest
    found_sensitivity = attempt(
        "sensitivity",
        words,
        lambda: sensitivity(scene, VOWEL, store=store, executor=executor, progress=lambda points: tell(words, points)),
    )
    postures, reasons_of_vowels = _vowels(scene, lambda name: tell(f"Tables II and IV: /{name}/", None))
    formants, reasons_of_formants = _formants(postures)
    muscles = attempt("muscles", "fig. 5: single muscles", lambda: single_muscles(scene))
    effects = attempt("effects", "section III.A.1: single muscles", lambda: muscle_effects(scene, muscles))
    found_transversalis = attempt("transversalis", "section III.B: transversalis", lambda: transversalis(scene, VOWEL))
    found_gravity = attempt(
        "gravity",
        "section V: gravity",
        lambda: gravity(scene, CARDINALS, progress=tell_of_gravity),
    )
    return Runs(
        vowels=postures,
        formants=formants,
        muscles=muscles or {},
        effects=effects,
        transversalis=found_transversalis,
        sensitivity=found_sensitivity,
        gravity=found_gravity,
        weight=tongue_weight(scene),
        reasons={**reasons, **reasons_of_vowels, **reasons_of_formants},
    )


def check_scene(scene: Scene) -> None:
    """Refuse a scene in which the paper's numbers have no counterpart.

    Raises:
        InputError: what it lacks.
    """
    speaker = scene.speaker
    missing = [muscle for muscle in MUSCLES if muscle not in speaker.muscles]
    lacks = [
        (bool(missing), f"the muscles of Table III (there is no {', '.join(missing)})"),
        (not speaker.walls, "walls"),
        ("dorsum" not in speaker.contours, "the contour 'dorsum'"),
        (scene.hyoid != "mobile", "a mobile hyoid"),
        (scene.gravity != gravity_vector("upright"), "upright gravity"),
    ]
    for lacking, what in lacks:
        if lacking:
            raise InputError(f"to replicate the paper, a scene needs {what}")


def tongue_weight(scene: Scene) -> float:
    """Weight of the tongue, N."""
    field_strength = float(np.linalg.norm(np.asarray(gravity_vector("upright"))))
    return float(scene.speaker.volume * scene.tissue.density * field_strength)


def _vowels(scene: Scene, tell: Callable[[str], object]) -> tuple[dict[str, Posture], dict[str, str]]:
    postures: dict[str, Posture] = {}
    reasons: dict[str, str] = {}
    for name in VOWELS:
        tell(name)
        try:
            posture = vowels(scene, [name])[name]
        except SolveError as error:
            reasons[f"vowels {name}"] = reason_of(error)
            continue
        if posture.report is None or posture.report.converged:
            postures[name] = posture
        else:
            reasons[f"vowels {name}"] = f"the solve of /{name}/ ended with {posture.report.status}"
    return postures, reasons


def _formants(postures: dict[str, Posture]) -> tuple[dict[str, Formants], dict[str, str]]:
    tracts, without = vowel_tracts(postures)
    reasons = {f"formants {name}": reason for name, reason in without.items()}
    found: dict[str, Formants] = {}
    for name, tract in tracts.items():
        try:
            found[name] = tract.formants(4)
        except SolveError as error:
            reasons[f"formants {name}"] = reason_of(error)
    return found, reasons


def four(formants: Formants | None) -> FloatArray:
    """F1 to F4, Hz; NaN where there are none."""
    return np.full(4, math.nan) if formants is None else np.asarray(formants.frequencies[:4], dtype=np.float64)
