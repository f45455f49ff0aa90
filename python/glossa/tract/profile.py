"""What bounds the airway from below at a posture, column by column: tongue, hyoid and the fixed walls facing out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import grey_closing

from glossa.anatomy.arrays import BoolArray, FloatArray
from glossa.tract.columns import Crossings, Numbers, runs
from glossa.tract.rest_tract import REACH, SEAM, RestTract

DEPTH = 20e-3
"""How far below the midline at rest a section may reach where nothing bounds it, m."""
OVERLAP = 3e-3
"""m; how deep a tongue in the wall is told apart."""
SLOTS = (0.5e-3, 1e-3, 2e-3)
"""Slots up to these widths, m, that are deeper than wide are seams between pieces or clefts beside the tongue; they are
bridged."""


@dataclass(frozen=True, eq=False)
class Profile:
    """Lower boundary of k sections in m columns.

    Attributes:
        inner: (k, m) t, m; above the outer wall where that lies inside a solid.
        structure: (k, m) numbers of names; -1 where nothing bounds, or a seam was bridged.
        missing: (k, m) nothing bounds within reach.
        clamped: (k, m) the depth was clamped, for what bounds lies deeper or is missing.
        bridged: (k, m) a seam or slot was bridged by a straight line.
    """

    inner: FloatArray
    structure: Numbers
    missing: BoolArray
    clamped: BoolArray
    bridged: BoolArray


def profile(rest: RestTract, solids: list[tuple[int, Crossings]]) -> Profile:
    """Lower boundary from the fixed walls and solids (number, crossings) at a posture."""
    inner, structure = rest.inner.copy(), rest.inner_wall.copy()
    for number, found in solids:
        top = solid_top(rest.outer, found)
        higher = top > inner
        inner[higher], structure[higher] = top[higher], number
    walled = ~np.isnan(rest.outer)
    missing, deep = walled & (inner < -REACH), walled & (inner < -DEPTH)
    inner[deep] = -DEPTH
    structure[missing] = -1
    step = float(rest.columns[1] - rest.columns[0])
    seams = _narrow(deep, round(SEAM / step))
    _bridge(inner, seams)
    bridged = seams | _slots(inner, walled, step)
    structure[bridged] = -1
    return Profile(inner, structure, missing & ~bridged, deep & ~bridged, bridged)


def solid_top(outer: FloatArray, found: Crossings) -> FloatArray:
    """(k, m) t of the highest point of a closed surface below the outer wall, m; -inf for none.

    Where the wall lies inside the solid, the solid's surface above the wall.
    """
    shape = outer.shape
    cell = found.plane * shape[1] + found.column
    limit = outer.ravel()[cell]
    top = np.full(outer.size, -np.inf)
    low = found.facing_out & (found.heights < limit)
    np.maximum.at(top, cell[low], found.heights[low])
    next_out, next_in = np.full(outer.size, np.inf), np.full(outer.size, np.inf)
    for target, mask in ((next_out, found.facing_out), (next_in, ~found.facing_out)):
        high = mask & (found.heights >= limit)
        np.minimum.at(target, cell[high], found.heights[high])
    inside = next_out < next_in
    top[inside] = np.minimum(next_out, outer.ravel() + OVERLAP)[inside]
    return top.reshape(shape)


def _narrow(missing: BoolArray, widest: int) -> BoolArray:
    """Runs of at most ``widest`` columns."""
    narrow = np.zeros_like(missing)
    for k in np.flatnonzero(missing.any(axis=1)):
        for first, behind in runs(missing[k]):
            narrow[k, first:behind] = behind - first <= widest
    return narrow


def _slots(inner: FloatArray, valid: BoolArray, step: float) -> BoolArray:
    """Bridges slots of ``inner`` that are deeper than wide; returns their columns."""
    found = np.zeros(inner.shape, dtype=bool)
    for width in SLOTS:
        ground = np.where(valid, inner, -DEPTH)
        closed = grey_closing(ground, size=(1, round(width / step) + 1), mode="nearest")
        deep = (closed - ground > width) & valid
        for k in np.flatnonzero(deep.any(axis=1)):
            for first, behind in runs((closed[k] > ground[k]) & valid[k]):
                if deep[k, first:behind].any():
                    found[k, first:behind] = True
        _bridge(inner, found)
    return found


def _bridge(inner: FloatArray, gaps: BoolArray) -> None:
    """Straight lines over runs of columns; the last value where one side has none."""
    for k in np.flatnonzero(gaps.any(axis=1)):
        for first, behind in runs(gaps[k]):
            sides = [c for c in (first - 1, behind) if 0 <= c < inner.shape[1] and np.isfinite(inner[k, c])]
            if sides:
                inner[k, first:behind] = np.interp(np.arange(first, behind), sides, inner[k, sides])
