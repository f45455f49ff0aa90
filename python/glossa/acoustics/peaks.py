"""Formants as maxima of the transfer function on the real frequency axis, of many tracts at once.

|H| = 1/|D| is largest where Re(D'/D) rises through zero. Two formants closer than their bandwidths make one peak, a
wide one may make none: this is how formants are read from spectra, and why poles are the default.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from glossa.acoustics.poles import TWO_PI, PoleSearch, Tracts
from glossa.acoustics.transmission_line import Real, flow_ratio_slope

STEPS_PER_SPACING = 100
ITERATIONS = 60
HALF_POWER = 0.5 * np.log(2.0)


def find_peaks(tracts: Tracts, top: Real) -> PoleSearch:
    """Peaks of each tract up to ``top`` (m,), Hz, as F + jB/2.

    B is the width 3 dB below the peak; twice the half that exists where |H| turns up again before it has fallen by 3 dB
    on one side, and nan where it does on both.
    """
    steps = int(np.ceil(STEPS_PER_SPACING * float((top / tracts.spacing).max())))
    lowest = tracts.constants.lowest_frequency
    grid = lowest + (top - lowest)[:, None] * (np.arange(steps + 1) / steps)
    slope, level = _slope_and_level(tracts, grid)
    rows, places = np.nonzero((slope[:, :-1] < 0.0) & (slope[:, 1:] >= 0.0))
    at = _root(
        lambda f, r: _slope_and_level(tracts.rows(r), f[:, None])[0][:, 0],
        grid[rows, places],
        grid[rows, places + 1],
        rows,
    )
    height = _slope_and_level(tracts.rows(rows), at[:, None])[1][:, 0] if rows.size else at
    sides = [_edge(tracts, grid, level, (rows, places), height, at, step) for step in (-1, 1)]
    width = sides[1] - sides[0]
    width = np.where(np.isnan(sides[0]), 2.0 * (sides[1] - at), width)
    width = np.where(np.isnan(sides[1]), 2.0 * (at - sides[0]), width)
    peaks = np.empty(at.size, dtype=np.complex128)
    peaks.real, peaks.imag = at, 0.5 * width  # a sum would make the frequency nan with the width
    return PoleSearch([peaks[rows == row] for row in range(len(grid))], [""] * len(grid))


def _slope_and_level(tracts: Tracts, frequency: Real) -> tuple[Real, Real]:
    """Slope by F of log|D|, and log|D|, (m, f)."""
    omega = np.asarray(TWO_PI * frequency, dtype=np.complex128)
    value, slope = flow_ratio_slope(omega, tracts.lengths, tracts.areas, tracts.constants)
    size = np.maximum(np.abs(value), 1e-100)
    return np.asarray(TWO_PI * (slope * np.conj(value)).real / size**2), np.log(size)


def _root(function: Callable[[Real, NDArray[np.intp]], Real], low: Real, high: Real, rows: NDArray[np.intp]) -> Real:
    """Where functions rise or fall through zero between low and high (r,), by bisection."""
    if not rows.size:
        return low
    begins_above = function(low, rows) > 0.0
    for _ in range(ITERATIONS):
        middle = 0.5 * (low + high)
        if (high - low).max() < 1e-9 * float(high.max()):
            break
        same = (function(middle, rows) > 0.0) == begins_above
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray(0.5 * (low + high))


def _edge(
    tracts: Tracts,
    grid: Real,
    level: Real,
    peaks: tuple[NDArray[np.intp], NDArray[np.intp]],
    height: Real,
    at: Real,
    step: int,
) -> Real:
    """Where |H| has fallen by 3 dB on one side of each peak; nan where it turns up, or the grid ends, before that."""
    rows, places = peaks
    edge = np.full(rows.size, np.nan)
    target = height + HALF_POWER
    found, inner, outer = [], [], []
    for i, (row, place) in enumerate(zip(rows, places, strict=True)):
        j = place + (1 if step > 0 else 0)
        previous, reached = at[i], height[i]
        while 0 <= j < grid.shape[1] and level[row, j] >= reached:
            if level[row, j] >= target[i]:
                found.append(i)
                inner.append(previous)
                outer.append(grid[row, j])
                break
            previous, reached = grid[row, j], level[row, j]
            j += step
    if found:
        chosen = np.array(found)

        def excess(f: Real, r: NDArray[np.intp]) -> Real:
            return np.asarray(_slope_and_level(tracts.rows(rows[r]), f[:, None])[1][:, 0] - target[r])

        edge[chosen] = _root(excess, np.array(inner), np.array(outer), chosen)
    return edge
