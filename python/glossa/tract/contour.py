"""The closed contour of a channel: outer wall above, what bounds it below, closed at its lateral ends."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import shapely

from glossa.anatomy.arrays import FloatArray
from glossa.tract.airway import Channel

Shape: TypeAlias = shapely.Polygon | shapely.MultiPolygon


def joined(polygons: list[shapely.Polygon]) -> Shape:
    """Polygons as one shape: what lies in several counts once; empty for none."""
    return polygons[0] if len(polygons) == 1 else shapely.union_all(polygons)


def contour(
    channel: Channel, columns: FloatArray, outer: FloatArray, inner: FloatArray, ends: FloatArray, spread: int
) -> tuple[shapely.Polygon, bool]:
    """Polygon in coordinates (y, t) of one channel, and whether it reaches a lateral end.

    A channel includes up to ``spread`` columns on either side whose gap is below the barrier: the edge of a wedge. It
    is closed where the gap ends, at the lateral end, or else by a straight line across the slit that goes on; empty
    where that leaves a single column.

    Args:
        channel: its columns.
        columns: (m,) y, m.
        outer: (m,) t of the wall above, m.
        inner: (m,) t of what bounds it below, m.
        ends: (2,) lateral ends, m.
        spread: number of columns.
    """
    left, at_left = _closing(channel.first, -1, columns, outer, inner, ends[0], spread)
    right, at_right = _closing(channel.last, 1, columns, outer, inner, ends[1], spread)
    first, last = (int(side[1]) for side in (left, right))
    kept = slice(first, last + 1)
    y = np.concatenate([left[0][:, 0], columns[kept], right[0][:, 0]])
    top = np.concatenate([left[0][:, 1], outer[kept], right[0][:, 1]])
    bottom = np.concatenate([left[0][:, 2], inner[kept], right[0][:, 2]])
    ring = np.concatenate([np.stack([y, bottom], axis=1), np.stack([y, top], axis=1)[::-1]])
    if len(y) < 2:  # a single column of a slit that goes on at both sides has no width
        return shapely.Polygon(), False
    return shapely.Polygon(ring), at_left or at_right


def _closing(
    column: int, step: int, columns: FloatArray, outer: FloatArray, inner: FloatArray, end: float, spread: int
) -> tuple[tuple[FloatArray, int], bool]:
    """Last point (0 or 1, 3) y, upper and lower t, on one side; the last column; whether it is the lateral end."""

    def within(c: int) -> bool:
        return 0 <= c < len(columns) and step * (end - columns[c]) >= 0.0 and not np.isnan(outer[c])

    reach = column
    while abs(reach - column) < spread and within(reach + step) and outer[reach + step] > inner[reach + step]:
        reach += step
    nothing = np.zeros((0, 3))
    following = reach + step
    if within(following):
        gap, beyond = outer[reach] - inner[reach], outer[following] - inner[following]
        if beyond > 0.0:
            return (nothing, reach), False
        share = gap / (gap - beyond)
        y, t = (v[reach] + share * (v[following] - v[reach]) for v in (columns, outer))
        return (np.array([[y, t, t]]), reach), False
    # Lateral end, at most a column away: both sides go on straight; a tube that closes there meets in one point.
    width = end - columns[reach]
    previous = reach - step
    slopes = [
        (v[reach] - v[previous]) / (columns[reach] - columns[previous]) if within(previous) else 0.0
        for v in (outer, inner)
    ]
    top, bottom = (v[reach] + slope * width for v, slope in zip((outer, inner), slopes, strict=True))
    if top < bottom:
        top = bottom = 0.5 * (top + bottom)
    return (np.array([[end, top, bottom]]), reach), True
