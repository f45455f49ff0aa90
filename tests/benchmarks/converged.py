"""Movements with very fine steps, kept between sessions, and errors of other movements against them."""

from __future__ import annotations

import hashlib
import tempfile
from pathlib import Path

import numpy as np
from tests.blocks import FloatArray

import glossa
from glossa import VOWELS, Movement, Ramp, Scene

FINE_STEP = 0.1e-3
"""s; the default of :func:`fine_movement`."""


def fine_movement(scene: Scene, vowel: str, until: float, dt: float = FINE_STEP) -> Movement:
    """The movement from rest positions to a vowel in SDIRK2 steps of ``dt`` s, stages solved to 1e-9.

    It takes a minute and is kept in the system's folder for temporary files, under a name that changes with the speaker
    and with every file of the package.
    """
    key = "-".join([scene.speaker.fingerprint[:12], fingerprint(), vowel, f"{until:g}", f"{dt:g}", str(scene.mirror)])
    path = Path(tempfile.gettempdir()) / "glossa-benchmarks" / f"{key}.nc"
    if path.exists():
        return Movement.load(path, scene.speaker)
    fine = scene.simulate(Ramp(VOWELS[vowel]), until, dt=dt, accuracy="reference", integrator="SDIRK2")
    path.parent.mkdir(exist_ok=True)
    partial = path.with_suffix(".partial")
    fine.save(partial)
    partial.replace(path)
    return fine


def fingerprint() -> str:
    """Of the package's code, the compiled core among it."""
    folder = Path(glossa.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.suffix in (".py", ".so", ".pyd")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def positions_at(movement: Movement, times: FloatArray) -> FloatArray:
    """(t, n, 3) m, by cubic Hermite interpolation as :meth:`Movement.at` does."""
    k = np.clip(np.searchsorted(movement.times, times, side="right") - 1, 0, len(movement.times) - 2)
    h = (movement.times[k + 1] - movement.times[k])[:, None, None]
    x = (times[:, None, None] - movement.times[k][:, None, None]) / h
    return np.asarray(
        (1 + 2 * x) * (1 - x) ** 2 * movement.positions[k]
        + x * x * (3 - 2 * x) * movement.positions[k + 1]
        + h * x * (1 - x) ** 2 * movement.velocities[k]
        - h * x * x * (1 - x) * movement.velocities[k + 1]
    )


def largest_error(movement: Movement, fine: Movement) -> float:
    """Largest distance in m from the fine movement: over all nodes, and over all steps of ``movement`` and all whole
    milliseconds."""
    grid = np.arange(0.0, min(movement.times[-1], fine.times[-1]) + 1e-9, 1e-3)
    times = np.unique(np.concatenate([grid, movement.times])).clip(max=min(movement.times[-1], fine.times[-1]))
    away = positions_at(movement, times) - positions_at(fine, times)
    return float(np.linalg.norm(away, axis=2).max())
