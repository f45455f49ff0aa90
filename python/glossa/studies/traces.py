"""Movements of single nodes and forces of muscles at chosen times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from glossa.anatomy.arrays import FloatArray
from glossa.checks import positive_number
from glossa.errors import InputError
from glossa.results import Movement

LATE = 0.050
"""End of a movement in which it is told what still swings, s."""


def even_times(until: float, interval: float) -> FloatArray:
    """Times from 0 to ``until`` (s), about ``interval`` (s) apart, both ends included.

    Raises:
        InputError: numbers that are not positive, or an interval longer than the movement.
    """
    end, step = positive_number(until, "until (s)"), positive_number(interval, "interval (s)")
    if step > end:
        raise InputError(f"interval must not be longer than the movement of {end:g} s, got {step:g} s")
    return np.linspace(0.0, end, round(end / step) + 1)


def node_traces(movement: Movement, nodes: Sequence[int], times: ArrayLike) -> FloatArray:
    """(t, k, 3) displacements from rest of k nodes, m: cubic Hermite between the frames, as :meth:`Movement.at`.

    Raises:
        InputError: times outside the movement.
    """
    moments = np.asarray(times, dtype=float)
    frame, h, x = _between(movement, moments)
    x, h = x[:, None, None], h[:, None, None]
    places, speeds = movement.positions[:, nodes], movement.velocities[:, nodes]
    after = frame + 1
    found = (
        (1 + 2 * x) * (1 - x) ** 2 * places[frame]
        + x * x * (3 - 2 * x) * places[after]
        + h * x * (1 - x) ** 2 * speeds[frame]
        - h * x * x * (1 - x) * speeds[after]
    )
    return np.asarray(found - movement.speaker.nodes[nodes])


def force_traces(movement: Movement, times: ArrayLike) -> FloatArray:
    """(t, muscles) forces, N, linear between the frames.

    Raises:
        InputError: times outside the movement.
    """
    frame, _, x = _between(movement, np.asarray(times, dtype=float))
    forces = movement.forces.to_numpy()
    return np.asarray((1 - x)[:, None] * forces[frame] + x[:, None] * forces[frame + 1])


def peak_speeds(movement: Movement, nodes: Sequence[int]) -> FloatArray:
    """(k,) largest speed of each node over the frames, m/s."""
    return np.asarray(np.linalg.norm(movement.velocities[:, nodes], axis=2).max(axis=0))


def _between(movement: Movement, times: FloatArray) -> tuple[NDArray[np.intp], FloatArray, FloatArray]:
    """Frame before each time, length of its interval (s), and share of the interval."""
    ends = movement.times
    outside = (times < ends[0]) | (times > ends[-1])
    if times.ndim != 1 or not np.isfinite(times).all() or outside.any():
        raise InputError(f"times must lie between {ends[0]:g} s and {ends[-1]:g} s")
    frame = np.clip(np.searchsorted(ends, times, side="right") - 1, 0, len(ends) - 2).astype(np.intp)
    h = ends[frame + 1] - ends[frame]
    return frame, h, (times - ends[frame]) / h
