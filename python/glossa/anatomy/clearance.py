"""How far the walls are from the tongue at rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glossa import _core
from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.contact_samples import contact_samples
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.wall_checks import INTERIOR

HELD = ("jaw", "hyoid")
"""Node sets that hold the tongue: faces of theirs lie on bone."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Clearance:
    """Of one wall; k contact points of the tongue that face it.

    Attributes:
        points: (k, 3) m.
        distances: (k,) m from the wall, negative behind it.
    """

    points: FloatArray
    distances: FloatArray

    @property
    def least(self) -> float:
        """Smallest distance, m."""
        return float(self.distances.min())

    @property
    def place(self) -> FloatArray:
        """(3,) m, where it is."""
        return np.asarray(self.points[self.distances.argmin()])


def clearances(speaker: Speaker) -> dict[str, Clearance]:
    """By wall, for the walls that the tongue may touch and faces: what is beside the edge of a wall is free of it."""
    held = np.zeros(len(speaker.nodes), dtype=bool)
    for name in HELD:
        held[speaker.node_sets.get(name, [])] = True
    result = {}
    for name, wall in speaker.walls.items():
        points = contact_samples(speaker, name, held).operator @ speaker.nodes
        if not len(points):
            continue
        distances, _, kinds, _ = _core.nearest_features(wall.vertices, wall.triangles, points)
        facing = kinds == INTERIOR
        if facing.any():
            result[name] = Clearance(points=points[facing], distances=distances[facing])
    return result
