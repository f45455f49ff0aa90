"""Argument principle: how many zeros an analytic function has inside a polygon, and where about.

The logarithm of the function is followed along the outline. A step is halved, and its neighbours with it, while the
function changes by more than a factor e in size or 1 rad in phase, so that no turn is missed. The turns around the
outline count the zeros; the sums of z^p d(log D) / 2πj over the same steps are the sums of the zeros' powers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glossa.acoustics.constants import Complex

Function = Callable[[Complex, NDArray[np.intp]], Complex]
"""Values at points (r, s) of the functions numbered (r,)."""

LARGEST_STEP = 1.0
DEEPEST = 24
POWERS = 12


@dataclass(frozen=True, eq=False)
class Count:
    """Zeros inside each of m polygons.

    Attributes:
        zeros: number (m,); -1 where a zero lies on the outline or the function cannot be followed.
        moments: sums of ((zero - centre)/scale)^p for p = 1 … POWERS, (m, POWERS).
        centre: (m,).
        scale: (m,).
    """

    zeros: NDArray[np.intp]
    moments: Complex
    centre: Complex
    scale: NDArray[np.float64]

    def guesses(self, row: int, known: Complex) -> Complex:
        """The zeros of one polygon that are not among the known ones, from their power sums (Newton's identities)."""
        missing = int(self.zeros[row]) - known.size
        if not 0 < missing <= POWERS:
            return np.zeros(0, dtype=np.complex128)
        scaled = (known - self.centre[row]) / self.scale[row]
        sums = [self.moments[row, p - 1] - np.sum(scaled**p) for p in range(1, missing + 1)]
        polynomial = [1.0 + 0.0j]
        for p in range(1, missing + 1):
            total = sum(polynomial[p - i] * sums[i - 1] for i in range(1, p + 1))
            polynomial.append(-total / p)
        roots: Complex = np.roots(polynomial).astype(np.complex128) * self.scale[row] + self.centre[row]
        return roots


def count_zeros(function: Function, outline: Complex, values: Complex | None = None) -> Count:
    """Zeros inside polygons of m functions.

    Args:
        function: analytic inside and on the outlines.
        outline: points (m, s) along each outline, counterclockwise, not closed; corners among them.
        values: of the function there, where known.
    """
    rows, steps = outline.shape
    if values is None:
        values = function(outline, np.arange(rows))
    centre = 0.5 * (outline.real.max(axis=1) + outline.real.min(axis=1)) + 0.0j
    scale = np.abs(outline - centre[:, None]).max(axis=1)
    ends, end_values = np.roll(outline, -1, axis=1), np.roll(values, -1, axis=1)
    usable = np.isfinite(values).all(axis=1) & (values != 0).all(axis=1)
    safe = np.where(usable[:, None], values, 1.0)
    turns = np.log(np.where(usable[:, None], end_values, 1.0) / safe)
    coarse = _too_large(turns)
    coarse |= np.roll(coarse, 1, axis=1) | np.roll(coarse, -1, axis=1)
    moments = np.zeros((rows, POWERS + 1), dtype=np.complex128)
    _gather(moments, np.repeat(np.arange(rows), steps)[~coarse.ravel()], outline, ends, turns, ~coarse, centre, scale)
    which, place = np.nonzero(coarse)
    pieces = (outline[which, place], ends[which, place], values[which, place], end_values[which, place])
    _refine(function, moments, usable, which, pieces, centre, scale)
    total = moments[:, 0] / (2.0j * np.pi)
    zeros = np.rint(total.real).astype(np.intp)
    usable &= np.abs(total - zeros) < 1e-3
    zeros[~usable] = -1
    return Count(zeros, moments[:, 1:] / (2.0j * np.pi), centre, scale)


def _too_large(turns: Complex) -> NDArray[np.bool_]:
    return (np.abs(turns.real) > LARGEST_STEP) | (np.abs(turns.imag) > LARGEST_STEP)


def _gather(
    moments: Complex,
    rows: NDArray[np.intp],
    begin: Complex,
    end: Complex,
    turns: Complex,
    chosen: NDArray[np.bool_],
    centre: Complex,
    scale: NDArray[np.float64],
) -> None:
    """Adds the chosen steps to the sums of their rows."""
    middle = (0.5 * (begin[chosen] + end[chosen]) - centre[rows]) / scale[rows]
    term = turns[chosen]
    for power in range(moments.shape[1]):
        moments[:, power] += np.bincount(rows, term.real, moments.shape[0])
        moments[:, power] += 1j * np.bincount(rows, term.imag, moments.shape[0])
        term = term * middle


def _refine(
    function: Function,
    moments: Complex,
    usable: NDArray[np.bool_],
    which: NDArray[np.intp],
    pieces: tuple[Complex, Complex, Complex, Complex],
    centre: Complex,
    scale: NDArray[np.float64],
) -> None:
    """Halves steps until each is small; rows that need more than DEEPEST halvings become unusable."""
    begin, end, at_begin, at_end = pieces
    for _ in range(DEEPEST):
        keep = usable[which]
        which = which[keep]
        begin, end, at_begin, at_end = (a[keep] for a in (begin, end, at_begin, at_end))
        if not which.size:
            return
        middle = 0.5 * (begin + end)
        at_middle = function(middle[:, None], which)[:, 0]
        bad = ~np.isfinite(at_middle) | (at_middle == 0)
        usable[which[bad]] = False
        at_middle[bad] = 1.0
        starts, stops = np.stack([begin, middle], axis=1), np.stack([middle, end], axis=1)
        low, high = np.stack([at_begin, at_middle], axis=1), np.stack([at_middle, at_end], axis=1)
        turns = np.log(high / low)
        coarse = _too_large(turns).any(axis=1, keepdims=True) & np.ones((1, 2), dtype=np.bool_)
        done = ~coarse
        rows = np.repeat(which, 2).reshape(-1, 2)
        _gather(moments, rows[done], starts, stops, turns, done, centre, scale)
        which = rows[coarse]
        begin, end, at_begin, at_end = (a[coarse] for a in (starts, stops, low, high))
    usable[which] = False
