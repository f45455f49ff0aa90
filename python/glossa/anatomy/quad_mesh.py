"""Half-edges of a closed surface of quadrilaterals.

Half-edge 4 f + c runs along face f from its corner c to the next one; the same number stands for that corner. Seen
from outside, the face lies on its left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glossa.anatomy.arrays import IntArray, frozen
from glossa.errors import InputError

IndexArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False, init=False)
class QuadMesh:
    """Which half-edge follows which; every array has one entry for each of the 4 q half-edges.

    Attributes:
        start, end: nodes.
        twin: the half-edge of the neighbouring face along the same edge, in the other direction.
        ccw: the next half-edge around the start, counter-clockwise: the face of h lies between h and ccw[h].
        cw: the one before.
        fan: lowest half-edge of the fan, the faces around the start that hang together by edges. A node where two
            parts of a surface touch has two fans.

    Raises:
        InputError: the surface is not closed, not consistently oriented, or two parts touch along an edge.
    """

    start: IndexArray
    end: IndexArray
    twin: IndexArray
    ccw: IndexArray
    cw: IndexArray
    fan: IndexArray

    def __init__(self, quads: IntArray, n_nodes: int) -> None:
        half_edges = np.arange(quads.size)
        start = quads.ravel().astype(np.int64)
        end = np.roll(quads, -1, axis=1).ravel().astype(np.int64)
        twin = _twins(start, end, n_nodes)
        before = half_edges - half_edges % 4 + (half_edges + 3) % 4
        after = half_edges - half_edges % 4 + (half_edges + 1) % 4
        ccw, cw = twin[before], after[twin]
        fan, step = half_edges.copy(), ccw.copy()
        while not np.array_equal(fan, fan[ccw]):
            fan = np.minimum(fan, fan[step])
            step = step[step]
        parts = {"start": start, "end": end, "twin": twin, "ccw": ccw, "cw": cw, "fan": fan}
        for name, part in parts.items():
            object.__setattr__(self, name, frozen(part))

    def around(self, half_edge: int) -> list[int]:
        """The half-edges of a fan, counter-clockwise from ``half_edge``."""
        result, at = [half_edge], int(self.ccw[half_edge])
        while at != half_edge:
            result.append(at)
            at = int(self.ccw[at])
        return result


def _twins(start: IndexArray, end: IndexArray, n_nodes: int) -> IndexArray:
    keys = start * n_nodes + end
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    for first in np.flatnonzero(ordered[1:] == ordered[:-1])[:1]:
        a, b = sorted((int(order[first]), int(order[first + 1])))
        raise InputError(
            f"surface: faces {a // 4} and {b // 4} both run from node {start[a]} to node {end[a]}; neighbouring faces "
            f"must run in opposite directions, and no more than two may meet at an edge"
        )
    wanted = end * n_nodes + start
    place = np.minimum(np.searchsorted(ordered, wanted), len(ordered) - 1)
    for h in np.flatnonzero(ordered[place] != wanted)[:1]:
        raise InputError(
            f"surface: the edge of face {h // 4} between the nodes {start[h]} and {end[h]} has no face on its other "
            f"side; the surface must be closed"
        )
    twins: IndexArray = order[place]
    return twins
