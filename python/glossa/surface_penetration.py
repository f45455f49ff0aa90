"""How deep the tongue's surface lies inside walls: between contact points, too, where nothing holds it back.

Contact acts at points, and on distances that are smoothed so that Newton's method can follow them: sharp edges are
rounded. The penetration that a solve reports is that of its points in the smoothed walls. Edges enter between the
points, and as far as they are rounded. Here the whole surface is sampled and the walls are taken as they are, as the
triangles of the speaker.

The depth of a place is its distance from the nearest triangle: a wedge of the angle a whose edge has sunk by s into a
flat face, straight across it, counts s sin(a / 2). Overlap with the wall at rest is left out, place by place.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import pandas as pd
from scipy import sparse

from glossa import _core
from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray
from glossa.anatomy.contact_samples import contact_surface, moving_contact_faces
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.surface_sampling import surface_lattice
from glossa.anatomy.walls import Wall
from glossa.checks import finite_number
from glossa.contact_points import LEAST_MOBILITY
from glossa.errors import InputError
from glossa.results import Posture

SAMPLES = 0.5e-3
"""Distance of neighbouring samples, m."""

FINEST_SAMPLES = 0.25e-3
"""Least distance of samples, m; no edge is divided into more than 40."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfacePenetration:
    """Depth of samples of the tongue's surface in the walls that they may touch; k pairs of a sample and a wall.

    Attributes:
        walls: names.
        wall: (k,) which wall.
        points: (k, 3) m.
        depths: (k,) m from the surface of the wall, 0 outside of it.
        attached: (k,) near attachments, where contact has no points because the surface can hardly give way.
        at_points: (walls,) m, deepest contact point of each wall.
    """

    walls: tuple[str, ...]
    wall: IntArray
    points: FloatArray
    depths: FloatArray
    attached: BoolArray
    at_points: FloatArray

    @cached_property
    def by_wall(self) -> pd.DataFrame:
        """Deepest place in each wall, m: of the contact points, of the surface among them, and near attachments."""
        places = {"points": self.at_points}
        for name, here in (("surface", ~self.attached), ("attached", self.attached)):
            places[name] = np.array(
                [self.depths[here & (self.wall == number)].max(initial=0.0) for number in range(len(self.walls))]
            )
        return pd.DataFrame(places, index=list(self.walls))

    @property
    def deepest(self) -> float:
        """Largest depth where contact acts, m: that of the table's columns "points" and "surface"."""
        return float(self.by_wall[["points", "surface"]].to_numpy().max(initial=0.0))

    def __repr__(self) -> str:
        return f"SurfacePenetration(deepest {self.deepest * 1e3:.3f} mm of {len(self.depths)} samples)"


def surface_penetration(posture: Posture, *, samples: float = SAMPLES) -> SurfacePenetration:
    """Penetration of the whole surface that may touch walls, walls where the posture has them.

    Args:
        posture: of a scene with contact, or a moment of a movement.
        samples: distance of neighbouring samples, m, at least 0.25e-3; nodes and edges of the faces are among them. The
            depth of an edge of the angle a is found to ``samples / 2 cos(a / 2)`` at worst.

    Raises:
        InputError: a posture without contact, or a distance that is too small or no number.
    """
    spacing = finite_number(samples, "surface_penetration: samples")
    if spacing < FINEST_SAMPLES:
        raise InputError(f"surface_penetration: samples must be at least {FINEST_SAMPLES:g} m, got {samples!r}")
    contact, speaker = posture.contact, posture.speaker
    if contact is None:
        raise InputError("surface_penetration needs a posture with contact; this one comes from a scene without")
    parts, numbers = [], []
    for number, sampled in enumerate(_sampled(speaker, contact.held.tobytes(), spacing)):
        name = contact.walls[number]
        points = sampled.operator @ posture.positions
        here = _depths(speaker.walls[name], points - posture.wall_displacements.get(name, np.zeros(3)))
        parts.append((points, np.maximum(0.0, here - sampled.overlap), sampled.attached))
        numbers.append(np.full(len(points), number, np.int32))
    points, depths, attached = (np.concatenate(part) for part in zip(*parts, strict=True))
    gaps = [contact.gaps[contact.wall == number].min(initial=0.0) for number in range(len(contact.walls))]
    return SurfacePenetration(
        walls=contact.walls,
        wall=np.concatenate(numbers),
        points=points,
        depths=depths,
        attached=attached,
        at_points=np.abs(gaps),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Sampled:
    """Samples of the surface that may touch one wall; k of them.

    Attributes:
        operator: (k, n) weights of the speaker's nodes.
        overlap: (k,) m in the wall at rest.
        attached: (k,) as in :class:`SurfacePenetration`.
    """

    operator: sparse.csr_array
    overlap: FloatArray
    attached: BoolArray


@lru_cache(maxsize=4)
def _sampled(speaker: Speaker, held_nodes: bytes, spacing: float) -> tuple[_Sampled, ...]:
    """Wall by wall. Kept, since postures of one scene share them."""
    held = np.zeros(len(speaker.nodes), dtype=bool)
    held[np.frombuffer(held_nodes, np.int32)] = True
    surface = contact_surface(speaker)
    found = []
    for name, wall in speaker.walls.items():
        operator = surface.operator(*surface_lattice(surface, moving_contact_faces(speaker, name, held), spacing))
        attached = np.asarray(operator @ (~held).astype(float) <= LEAST_MOBILITY)
        found.append(_Sampled(operator=operator, overlap=_depths(wall, operator @ speaker.nodes), attached=attached))
    return tuple(found)


def _depths(wall: Wall, points: FloatArray) -> FloatArray:
    """(k,) m inside a wall."""
    if len(points) == 0:
        return np.zeros(0)
    distances, *_ = _core.nearest_features(wall.vertices, wall.triangles, points)
    return np.maximum(0.0, -distances)
