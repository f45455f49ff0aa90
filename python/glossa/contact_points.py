"""Which points of the tongue's smooth surface may touch which walls."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from scipy import sparse

from glossa import _core
from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray
from glossa.anatomy.contact_samples import SPACING, contact_samples
from glossa.anatomy.mirror import TOLERANCE, HalfBody, mirror_pairs
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.wall_checks import check_facing, check_wall
from glossa.anatomy.walls import Wall
from glossa.checks import finite_number
from glossa.contact import Contact
from glossa.errors import InputError

FIELD_SPACING = 0.9e-3
"""Of the lattice on which the distance of a wall is splined, m: surfaces are kept to 0.025 mm (95 % of their
area; 0.1 mm at most), edges to 0.15 mm."""

FINEST = 0.4e-3
"""Least distance of contact points, m: edges of walls are not known any better."""

LEAST_MOBILITY = 0.5
"""Share of moving nodes in a contact point: points nearer to attachments can hardly give way and are left out."""

MARGIN = 30e-3
"""How far contact points may move from the box they fill at rest before walls are no longer known, m."""

BEHIND = 12e-3
"""How far around a wall its distance is known, m: twice the band of the field, for wild trial states."""


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """Pairs of a surface point and a wall that it may touch; k pairs.

    A point that overlaps its wall at rest is given an offset, the depth of that overlap: the wall counts as dented
    there by so much, and the rest state feels no contact.

    Attributes:
        walls: names.
        fields: signed distance of each wall (_core.DistanceField).
        operator: (k, n) weights of the speaker's nodes.
        wall: (k,) number of the wall.
        areas: (k,) m2 of the surface at rest that the point stands for.
        offsets: (k,) m, at least 0, added to the distance of the wall.
        held: nodes that never move; faces among them touch nothing.
        spacing: of the points, m.
    """

    walls: tuple[str, ...]
    fields: tuple[Any, ...]
    operator: sparse.csr_array
    wall: IntArray
    areas: FloatArray
    offsets: FloatArray
    held: IntArray
    spacing: float

    def contact(
        self, positions: FloatArray, pressures: FloatArray, drags: FloatArray, shifts: Mapping[str, FloatArray]
    ) -> Contact:
        """Contact at node positions (n, 3), m, from pressures (k,) and drags (k, 3), Pa, and wall displacements, m."""
        points = self.operator @ positions
        gaps, directions = np.empty(len(points)), np.empty((len(points), 3))
        for number, (name, distances) in enumerate(zip(self.walls, self.fields, strict=True)):
            here = self.wall == number
            distance, gradient, _ = distances.evaluate(points[here] - shifts.get(name, 0.0))
            gaps[here], directions[here] = distance, gradient
        return Contact(
            walls=self.walls,
            wall=self.wall,
            points=points,
            areas=self.areas,
            gaps=gaps + self.offsets,
            pressures=pressures,
            directions=directions,
            drags=drags,
            held=self.held,
            spacing=self.spacing,
        )

    def core(self, rows: IntArray, half: HalfBody | None, friction: float) -> dict[str, Any]:
        """Arrays of the points ``rows`` for the core's constructor."""
        chosen = self.operator[rows]
        if half is None:
            along, across = chosen, chosen
        else:
            side = np.where(half.reflected, -1.0, 1.0)
            n, kept = len(side), len(half.kept_nodes)
            fold = sparse.csr_array((np.ones(n), (np.arange(n), half.node_index)), shape=(n, kept))
            along, across = chosen @ fold, chosen @ sparse.csr_array(fold * side[:, None])
        pattern = (abs(along) + abs(across)).tocsr()
        pattern.sort_indices()
        row = np.repeat(np.arange(len(rows)), np.diff(pattern.indptr))
        return {
            "weight_start": pattern.indptr.astype(np.int32),
            "weight_node": pattern.indices.astype(np.int32),
            "weight_along": np.asarray(along[row, pattern.indices]).ravel(),
            "weight_across": np.asarray(across[row, pattern.indices]).ravel(),
            "area": self.areas[rows],
            "wall": self.wall[rows],
            "offset": self.offsets[rows],
            "walls": list(self.fields),
            "friction": friction,
        }

    def halves(self, rest: FloatArray) -> tuple[IntArray, IntArray, BoolArray]:
        """For a mirrored scene: points at y > 0; for each point its place among them; whether it is an image."""
        points = self.operator @ rest
        place = np.empty(len(points), np.int32)
        for number, name in enumerate(self.walls):
            here = np.flatnonzero(self.wall == number)
            try:
                place[here] = here[mirror_pairs(points[here])]
            except InputError:
                raise InputError(f"the contact points at wall {name!r} are not mirror symmetric about y = 0") from None
        kept = np.flatnonzero(points[:, 1] > TOLERANCE).astype(np.int32)
        left = points[:, 1] < -TOLERANCE
        if len(kept) * 2 != len(points):
            raise InputError("a contact point lies in the midplane y = 0; use mirror=False")
        number_of = np.full(len(points), -1, np.int32)
        number_of[kept] = np.arange(len(kept))
        return kept, number_of[np.where(left, place, np.arange(len(points)))], left


@dataclass(frozen=True, eq=False)
class ContactCourse:
    """Contact over time; t frames, k contact points.

    Attributes:
        points: which may touch what.
        pressures: (t, k) Pa.
        drags: (t, k, 3) Pa, friction of the tongue on the wall.
        wall_displacements: (3,) m by wall, for walls that stand displaced.
    """

    points: ContactPoints
    pressures: FloatArray
    drags: FloatArray
    wall_displacements: Mapping[str, FloatArray] = field(default_factory=dict)

    def between(self, positions: FloatArray, before: int, after: int, share: float) -> Contact:
        """Contact at node positions (n, 3), m, with pressure and drag linearly between two frames."""
        mix = [(1.0 - share) * values[before] + share * values[after] for values in (self.pressures, self.drags)]
        return self.points.contact(positions, mix[0], mix[1], self.wall_displacements)


def checked_spacing(value: Any) -> float:
    """A checked spacing of contact points, m.

    Raises:
        InputError: not a number between FINEST and SPACING.
    """
    spacing = finite_number(value, "contact spacing")
    if not FINEST <= spacing <= SPACING:
        raise InputError(f"contact spacing must lie between {FINEST:g} and {SPACING:g} m, got {value!r}")
    return spacing


def contact_points(speaker: Speaker, held: BoolArray, *, mirror: bool, spacing: float = SPACING) -> ContactPoints:
    """Contact points of a speaker where at least one node of the face may move.

    Args:
        speaker: with walls.
        held: (n,) nodes that never move.
        mirror: the scene is mirrored; the walls must be, too.
        spacing: of the points, m.

    Raises:
        InputError: a wall that cannot be touched: degenerate, inside out, open where the tongue faces it, or behind
            the tongue at rest; or not symmetric in a mirrored scene.
    """
    return _contact_points(speaker, held.tobytes(), mirror, spacing)


@lru_cache(maxsize=8)
def _contact_points(speaker: Speaker, held_bytes: bytes, mirror: bool, spacing: float) -> ContactPoints:
    """Kept, since a study makes many scenes of one speaker."""
    held = np.frombuffer(held_bytes, dtype=bool)
    parts, fields = [], []
    for number, (name, wall) in enumerate(speaker.walls.items()):
        check_wall(name, wall)
        if mirror:
            _check_symmetric(name, wall)
        samples = contact_samples(speaker, name, held, spacing)
        points = samples.operator @ speaker.nodes
        check_facing(name, wall, points, samples.normals)
        distances = _field(wall, *_box(points, wall))
        fields.append(distances)
        mobile = samples.operator @ (~held).astype(float) > LEAST_MOBILITY
        overlap = np.maximum(0.0, -distances.distance(points[mobile]))
        numbers = np.full(len(overlap), number, np.int32)
        parts.append((samples.operator[np.flatnonzero(mobile)], numbers, samples.areas[mobile], overlap))
    operators, wall_numbers, areas, offsets = zip(*parts, strict=True)
    return ContactPoints(
        walls=tuple(speaker.walls),
        fields=tuple(fields),
        operator=sparse.vstack(operators, format="csr"),
        wall=np.concatenate(wall_numbers),
        areas=np.concatenate(areas),
        offsets=np.concatenate(offsets),
        held=np.flatnonzero(held).astype(np.int32),
        spacing=spacing,
    )


def _box(points: FloatArray, wall: Wall) -> tuple[FloatArray, FloatArray]:
    """Corners of the box where the distance of a wall is known to points (k, 3) that may touch it.

    Whole lattice cells, so symmetric in y where all is.
    """
    low, high = wall.vertices.min(axis=0) - BEHIND, wall.vertices.max(axis=0) + BEHIND
    if len(points):
        low, high = np.maximum(low, points.min(axis=0) - MARGIN), np.minimum(high, points.max(axis=0) + MARGIN)
    if len(points) == 0 or (low >= high).any():  # out of reach: a box of one corner will do
        low, high = wall.vertices[0] - FIELD_SPACING, wall.vertices[0] + FIELD_SPACING
    return np.floor(low / FIELD_SPACING) * FIELD_SPACING, np.ceil(high / FIELD_SPACING) * FIELD_SPACING


def _field(wall: Wall, low: FloatArray, high: FloatArray) -> Any:
    """Signed distance of a wall; kept by content, for speakers that share it and scenes that hold other nodes."""
    digest = hashlib.sha256()
    for part in (wall.vertices, wall.triangles, low, high):
        digest.update(np.ascontiguousarray(part).tobytes())
    key = digest.digest()
    if key not in _fields:
        if len(_fields) >= MOST_FIELDS:
            del _fields[next(iter(_fields))]
        _fields[key] = _core.DistanceField(wall.vertices, wall.triangles, low=low, high=high, spacing=FIELD_SPACING)
    return _fields[key]


MOST_FIELDS = 40
_fields: dict[bytes, Any] = {}


def _check_symmetric(name: str, wall: Wall) -> None:
    try:
        mirror_pairs(np.unique(wall.vertices, axis=0))
    except InputError as error:
        raise InputError(f"mirror=True needs symmetric walls; wall {name!r}: {error}") from None
