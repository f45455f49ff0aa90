"""Motor commands varied one at a time around a vowel: the runs of section IV and Table VI."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from glossa import paper
from glossa.anatomy.arrays import FloatArray
from glossa.checks import finite_number
from glossa.errors import InputError
from glossa.motor.commands import VOWELS, vowel_commands
from glossa.scene import Scene
from glossa.studies.evaluation import CONVERGED, START
from glossa.studies.midsagittal_nodes import MIDSAGITTAL_NODES, midsagittal_nodes
from glossa.studies.run import run_points
from glossa.studies.study_point import Point

STUDIED_MUSCLES = ("GGa", "GGm", "GGp", "Sty", "HG", "Trans", "IL", "SL", "MH")
"""The main muscles of the tongue (section IV.A), in the order of Table I."""

CHANGES = (-10.0, -8.0, -5.0, -2.0, 2.0, 5.0, 8.0, 10.0)
"""Percent of the command; more is weaker."""

UNCHANGED = "none"
"""Stands for a muscle in the run with the vowel's own commands."""

Changes = Sequence[float] | Mapping[str, Sequence[float]] | None


def sensitivity_changes(vowel: str = "i") -> dict[str, tuple[float, ...]]:
    """Changes of each muscle in percent, as the paper chose them for /i/.

    All of :data:`CHANGES`; only the negative ones of muscles that are silent in the vowel, because weaker ones would
    stay silent. Silent are those to which Table II gives no force; the choice is the same for every speaker. 56 runs
    for /i/, as in Table VI.

    Raises:
        InputError: an unknown vowel.
    """
    vowel_commands(vowel)
    forces = paper.forces().loc[vowel]
    stronger = tuple(change for change in CHANGES if change < 0.0)
    return {muscle: CHANGES if forces[muscle] > 0.0 else stronger for muscle in STUDIED_MUSCLES}


def sensitivity(
    scene: Scene,
    vowel: str = "i",
    changes: Changes = None,
    *,
    store: str | Path | None = None,
    executor: Executor | None = None,
    progress: Any = None,
) -> xr.Dataset:
    """Equilibria of a vowel with one motor command changed at a time, started from the vowel's own posture.

    A run that fails from there is repeated from rest, as in :func:`glossa.studies.run_points`.

    Args:
        scene: of a speaker with walls and the muscles of Table III; the paper's has upright gravity and contact.
        vowel: of Table III; the lips are those of Table IV throughout.
        changes: in percent of the command, of all of :data:`STUDIED_MUSCLES`, or by muscle; None:
            :func:`sensitivity_changes`.
        store: file that keeps finished runs, as for :func:`glossa.studies.run_points`.
        executor: as for :func:`glossa.studies.run_points`.
        progress: as for :func:`glossa.studies.run_points`.

    Returns:
        Over ``muscle`` (whose command is changed) and ``change`` (percent): ``formants (…, formant)`` Hz, ``nodes
        (…, node, axis)`` positions of the six midsagittal nodes in m, ``displacement`` of the same from the vowel's, m,
        ``forces (…, acting)`` N, ``asked``, ``converged``, ``reason``, ``started`` (from the "vowel" or from "rest";
        empty: not solved), ``iterations``, ``seconds``. A run that failed, or has no formants, has NaN there and says
        why in ``reason``; ``asked`` is False where nothing was to be run. For the vowel itself: ``vowel_formants``,
        ``vowel_nodes``, ``vowel_forces``, and ``vowel_positions (vertex, axis)`` of every node, m.

    Raises:
        InputError: an unknown vowel or muscle, impossible changes, no walls, or as :func:`glossa.studies.run_points`.
        SolveError, SolveInterrupted: as :meth:`glossa.Scene.equilibrate`, for the vowel itself.
    """
    asked = _checked_changes(vowel, changes)
    missing = [muscle for muscle in asked if muscle not in scene.speaker.muscles]
    if missing:
        raise InputError(f"sensitivity: this speaker has no muscle {missing[0]!r}; it has {_listed(scene)}")
    own = VOWELS[vowel]
    runs = [(UNCHANGED, 0.0), *((muscle, change) for muscle, several in asked.items() for change in several)]
    points = [
        Point(
            commands=own if muscle == UNCHANGED else own.scaled(muscle, 1.0 + change / 100.0),
            lips=vowel,
            labels={"changed": muscle, "change": change},
        )
        for muscle, change in runs
    ]
    start = scene.equilibrate(own)
    found = run_points(scene, points, store=store, executor=executor, start=start, progress=progress)
    return _arranged(found, runs, vowel, scene, start.positions)


def _listed(scene: Scene) -> str:
    return ", ".join(scene.speaker.muscles) or "none"


def _checked_changes(vowel: str, changes: Changes) -> dict[str, tuple[float, ...]]:
    vowel_commands(vowel)
    if changes is None:
        return sensitivity_changes(vowel)
    if not isinstance(changes, Mapping):
        changes = dict.fromkeys(STUDIED_MUSCLES, changes)
    checked = {muscle: _percents(muscle, several) for muscle, several in changes.items()}
    if not any(checked.values()):
        raise InputError("sensitivity: there is no change to be run")
    return {muscle: several for muscle, several in checked.items() if several}


def _percents(muscle: str, changes: Sequence[float]) -> tuple[float, ...]:
    if muscle not in VOWELS["i"]:
        raise InputError(f"sensitivity: no command of {muscle!r} to change; Table III has {', '.join(VOWELS['i'])}")
    if not isinstance(changes, tuple | list | np.ndarray):
        raise InputError(f"changes of {muscle!r} must be a list of numbers in percent, got {changes!r}")
    values = tuple(finite_number(change, f"change of {muscle!r} (percent)") for change in changes)
    for value in values:
        if value <= -100.0 or value == 0.0:
            raise InputError(f"changes of {muscle!r} must be above -100 % and not 0, got {value:g}")
    if len(set(values)) < len(values):
        raise InputError(f"changes of {muscle!r} must differ, got {list(values)}")
    return values


def _arranged(
    found: xr.Dataset,
    runs: Sequence[tuple[str, float]],
    vowel: str,
    scene: Scene,
    positions: FloatArray,
) -> xr.Dataset:
    """The points, in the order of ``runs``, as a table of muscles and changes."""
    muscles = list(dict.fromkeys(muscle for muscle, _ in runs[1:]))
    changes = sorted({change for _, change in runs[1:]})
    rows = np.array([muscles.index(muscle) for muscle, _ in runs[1:]])
    columns = np.array([changes.index(change) for _, change in runs[1:]])
    moved = found["displacement"].to_numpy()
    rest = scene.speaker.nodes[list(midsagittal_nodes(scene.speaker).values())]
    asked = np.zeros((len(muscles), len(changes)), dtype=bool)
    asked[rows, columns] = True

    def table(values: Any, missing: Any) -> Any:
        listed = np.asarray(values)[1:]
        whole = np.full((*asked.shape, *listed.shape[1:]), missing, dtype=listed.dtype)
        whole[rows, columns] = listed
        return whole

    run = ("muscle", "change")
    reasons = np.char.add(found["reason"].to_numpy().astype(str), found["acoustic_reason"].to_numpy().astype(str))
    started = found["started"].to_numpy()
    nodes, formants, forces = rest + moved, found["formants"].to_numpy(), found["forces"].to_numpy()
    return xr.Dataset(
        {
            "formants": ((*run, "formant"), table(formants, math.nan), {"units": "Hz"}),
            "nodes": ((*run, "node", "axis"), table(nodes, math.nan), {"units": "m"}),
            "displacement": ((*run, "node", "axis"), table(moved - moved[0], math.nan), {"units": "m"}),
            "forces": ((*run, "acting"), table(forces, math.nan), {"units": "N"}),
            "asked": (run, asked),
            "converged": (run, table(found["status"].to_numpy() == CONVERGED, False)),
            "reason": (run, table(reasons.astype(object), "")),
            "started": (run, table(np.where(started == START, "vowel", started), "")),
            "iterations": (run, table(found["iterations"].to_numpy(), 0)),
            "seconds": (run, table(found["seconds"].to_numpy(), math.nan), {"units": "s"}),
            "vowel_formants": (("formant",), formants[0], {"units": "Hz"}),
            "vowel_nodes": (("node", "axis"), nodes[0], {"units": "m"}),
            "vowel_forces": (("acting",), forces[0], {"units": "N"}),
            "vowel_positions": (("vertex", "axis"), positions, {"units": "m"}),
        },
        coords={
            "muscle": muscles,
            "change": ("change", changes, {"units": "%"}),
            "node": list(MIDSAGITTAL_NODES),
            "axis": ["x", "y", "z"],
            "formant": found["formant"].to_numpy(),
            "acting": found["muscle"].to_numpy(),
        },
        attrs={**found.attrs, "study": "sensitivity", "vowel": vowel},
    )
