"""The vowels of Table III as postures, and postures as a table (Table II and the displacements)."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Mapping

import numpy as np
import xarray as xr

from glossa.errors import InputError, SolveError
from glossa.motor.commands import vowel_commands
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.points import displacements_mm

log = logging.getLogger(__name__)


def vowels(scene: Scene, names: Iterable[str] = ("i", "ə", "u", "a")) -> dict[str, Posture]:
    """Equilibrium of each vowel of Table III, every one from rest.

    A vowel without convergence does not stop the others: its entry is the last good state, ``report.converged`` is
    False, a warning is logged, and :func:`posture_table` has NaN for it.

    Args:
        scene: with a speaker that has the muscles of Table III.
        names: "i", "ə", "u", "a", in any order.

    Raises:
        InputError: an unknown vowel, or a speaker that lacks a muscle.
        SolveError: a solve that failed without leaving a state.
        SolveInterrupted: Ctrl-C.
    """
    commands = {name: vowel_commands(name) for name in names}
    postures: dict[str, Posture] = {}
    for name, own in commands.items():
        try:
            postures[name] = scene.equilibrate(own)
        except SolveError as error:
            if error.posture is None:
                raise
            log.warning("vowel %s: %s", name, error)
            postures[name] = error.posture
    return postures


def posture_table(postures: Mapping[str, Posture]) -> xr.Dataset:
    """Forces, displacements and effort of postures of one speaker; NaN where a posture has not converged.

    Returns:
        Dataset with ``forces (posture, muscle)`` in N, ``displacement (posture, point, axis)`` in mm from rest (points
        tip and dorsum; axes x backward and z upward), ``converged``, ``iterations`` and ``seconds`` ``(posture)``.

    Raises:
        InputError: no posture, postures of several speakers, or a speaker without tip and dorsum.
    """
    if not postures:
        raise InputError("a table needs at least one posture")
    speaker = next(iter(postures.values())).speaker
    if any(posture.speaker.fingerprint != speaker.fingerprint for posture in postures.values()):
        raise InputError("the postures of a table must belong to one speaker")
    converged = np.array([p.report is None or p.report.converged for p in postures.values()])
    gap = np.where(converged, 1.0, math.nan)
    forces = np.stack([p.forces.to_numpy() for p in postures.values()]) * gap[:, None]
    moved = np.stack([np.stack(list(displacements_mm(p).values())) for p in postures.values()]) * gap[:, None, None]
    reports = [p.report for p in postures.values()]
    return xr.Dataset(
        {
            "forces": (("posture", "muscle"), forces, {"units": "N"}),
            "displacement": (("posture", "point", "axis"), moved, {"units": "mm"}),
            "converged": (("posture",), converged),
            "iterations": (("posture",), np.array([0 if r is None else r.iterations for r in reports])),
            "seconds": (
                ("posture",),
                np.array([math.nan if r is None else r.seconds["total"] for r in reports]),
                {"units": "s"},
            ),
        },
        coords={
            "posture": list(postures),
            "muscle": list(speaker.muscles),
            "point": ["tip", "dorsum"],
            "axis": ["x", "z"],
        },
        attrs={"speaker": speaker.name, "speaker_fingerprint": speaker.fingerprint},
    )
