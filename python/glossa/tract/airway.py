"""Which channels of the sections belong to the airway: the air connected to the larynx.

A channel is a run of columns of one plane whose gap is at least the barrier, or the pocket on the midline as long as
anything is open there: a groove does not end where it gets narrower than the barrier, slits beside it do. Channels of
neighbouring planes are connected where they overlap sideways by the barrier. The airway is what lies on a way from
larynx to lips; slits and pockets that lead nowhere do not count. Where one channel on such a way contains the midline
it is the section, and channels beside it, along the teeth, are told of but left out; where the midline is closed, as in
laterals, all count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glossa.anatomy.arrays import BoolArray, FloatArray
from glossa.tract.columns import runs


@dataclass(frozen=True)
class Channel:
    """Columns ``first`` to ``last`` (included) of a plane; ``reached`` by air through gaps of the barrier."""

    first: int
    last: int
    reached: bool = True


@dataclass(frozen=True)
class Passage:
    """The airway in one plane: channels that count, and channels beside them that are connected but do not."""

    channels: tuple[Channel, ...]
    beside: tuple[Channel, ...]


def airway(gaps: FloatArray, barrier: int, least: float) -> list[Passage]:
    """The airway in each plane.

    Args:
        gaps: (k, m) m, distance of the outer wall from what lies below; at most 0 outside the section.
        barrier: columns by which channels must overlap.
        least: m, smallest gap that air passes.

    Returns:
        One for each plane, glottis first. A pocket narrower than the barrier is marked as not ``reached``. Where
        nothing goes on towards the lips: the gaps above 0 in front of the plane before, not ``reached`` either; no
        channel where there are none. Beyond a closure the airway goes on with the channel nearest the midline.
    """
    middle = gaps.shape[1] / 2.0 - 0.5
    forwards: list[list[Channel]] = []
    for row in gaps:
        before = forwards[-1] if forwards else []
        options = channels(row >= least) + _groove(row, least, before)
        onwards = [c for c in options if any(_overlap(c, b) >= barrier for b in before)]
        if not onwards:
            onwards = _narrow(row, before) if before else sorted(options, key=lambda c: _nearest(c, middle))[:1]
        forwards.append(onwards)
    result: list[list[Channel]] = []
    for options in reversed(forwards):
        after = result[-1] if result else []
        kept = [c for c in options if any(_overlap(c, b) >= barrier for b in after)] if after else options
        result.append(kept or sorted(options, key=lambda c: _nearest(c, middle))[:1])
    return [_passage(options, middle) for options in reversed(result)]


def split_at_slits(gaps: FloatArray, least: float, length: int) -> FloatArray:
    """Gaps (k, m) with the lowest column closed of each slit between two chambers of a channel.

    A slit is lower than twice the smallest gap over at least ``length`` columns, off the midline.
    """
    result = gaps.copy()
    middle = gaps.shape[1] / 2.0 - 0.5
    for k, row in enumerate(gaps):
        for channel in channels(row >= least):
            for slit in channels(row[channel.first : channel.last + 1] < 2.0 * least):
                first, last = channel.first + slit.first, channel.first + slit.last
                between = channel.first < first and last < channel.last
                if between and last - first + 1 >= length and _nearest(Channel(first, last), middle)[0] >= 1.0:
                    result[k, first + int(row[first : last + 1].argmin())] = 0.0
    return result


def _groove(row: FloatArray, least: float, before: list[Channel]) -> list[Channel]:
    """The pocket below the barrier on the midline, in front of the channel on the midline before; often none."""
    middle = len(row) / 2.0 - 0.5
    behind = [b for b in before if _nearest(b, middle)[0] < 1.0]
    inside = (row > 0.0) & (row < least)
    if behind:
        inside[: behind[0].first] = inside[behind[0].last + 1 :] = False
    wide = any(_nearest(c, middle)[0] < 1.0 for c in channels(row >= least))
    pockets = [c for c in channels(inside) if _nearest(c, middle)[0] < 1.0]
    return [] if wide else [Channel(c.first, c.last, reached=False) for c in pockets[:1]]


def _passage(channels: list[Channel], middle: float) -> Passage:
    on_midline = [c for c in channels if _nearest(c, middle)[0] < 1.0]
    if not on_midline:
        return Passage(tuple(channels), ())
    return Passage(tuple(on_midline), tuple(c for c in channels if c not in on_midline))


def channels(mask: BoolArray) -> list[Channel]:
    """Runs of True in (m,) booleans."""
    return [Channel(first, behind - 1) for first, behind in runs(mask)]


def _narrow(row: FloatArray, before: list[Channel]) -> list[Channel]:
    """What is left of the airway where it is narrower than the barrier: gaps in front of the channels before."""
    low, high = min(b.first for b in before), max(b.last for b in before)
    inside = np.zeros(len(row), dtype=bool)
    inside[low : high + 1] = row[low : high + 1] > 0.0
    pockets = sorted(channels(inside), key=lambda c: _nearest(c, len(row) / 2.0 - 0.5))
    return [Channel(pocket.first, pocket.last, reached=False) for pocket in pockets[:1]]


def _overlap(a: Channel, b: Channel) -> int:
    return min(a.last, b.last) - max(a.first, b.first) + 1


def _nearest(channel: Channel, middle: float) -> tuple[float, int]:
    """Sorts channels by distance from the midline, wider ones first where equal."""
    return max(channel.first - middle, middle - channel.last, 0.0), channel.first - channel.last
