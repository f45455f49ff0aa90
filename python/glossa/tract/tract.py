"""The vocal tract of a posture, cut into sections."""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from glossa.acoustics.area_function import AreaFunction
from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.speaker import Speaker
from glossa.checks import instance, one_of, positive_number, whole_number
from glossa.errors import InputError
from glossa.results import Posture
from glossa.surroundings import hyoid_of, walls_of
from glossa.tract.airway import Passage, airway, split_at_slits
from glossa.tract.columns import Crossings, Numbers, cross
from glossa.tract.contour import contour, joined
from glossa.tract.lips import Lips, as_lips
from glossa.tract.profile import Profile, profile
from glossa.tract.rest_tract import LATERAL_ENDS, RestTract, rest_tract, with_walls
from glossa.tract.section import Section

PLANES = 45
"""Number of cutting planes. The path of centroids grows with it (by some 1.5 % from 45 to 90), so that it is part of
the definition of the tract's length."""
BARRIER = 0.5e-3
"""Smallest gap that connects parts of the airway, m: seals of tongue and palate leave slits of 0.1 to 0.5 mm in a mesh,
which saliva closes in a mouth."""
SLIT = 3e-3
"""Width from which a part of a section lower than twice the barrier is a slit, m: what lies behind it is another
channel. Without it sections would jump by 1 cm² when a slit beside the tongue opens by a hair's breadth."""
FLOOR = 2e-6
"""Smallest area of a section, m²."""
PATHS = ("centroids", "midline")
FACETS = 0.75e-3
"""Length of the facets that stand for the tongue's smooth surface, m: twice as long ones leave 2 % of error at a
constriction of 0.2 cm²."""


@dataclass(frozen=True, eq=False)
class Tract:
    """Sections from glottis to incisors, without lips.

    Attributes:
        sections: glottis first.
        lateral_end: where sections of the mouth end: "outer", "crest" or "lingual" edge of the upper dental arch.
        path: along what lengths are measured: "centroids" of the sections, or the "midline" at rest.
    """

    sections: tuple[Section, ...]
    lateral_end: str
    path: str

    def __len__(self) -> int:
        return len(self.sections)

    def __getitem__(self, number: int) -> Section:
        return self.sections[number]

    def __iter__(self) -> Iterator[Section]:
        return iter(self.sections)

    @property
    def areas(self) -> FloatArray:
        """(k,) m²."""
        return np.array([section.area for section in self.sections])

    @property
    def centroids(self) -> FloatArray:
        """(k, 3) m."""
        return np.array([section.centroid for section in self.sections])

    @property
    def lengths(self) -> FloatArray:
        """(k,) m: half the way along the path to either neighbour."""
        points = self.centroids if self.path == "centroids" else np.array([s.origin for s in self.sections])
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        return np.asarray(0.5 * (np.append(steps, 0.0) + np.insert(steps, 0, 0.0)))

    @property
    def length(self) -> float:
        """Length of the path, m."""
        return float(self.lengths.sum())

    def with_status(self, status: str) -> list[int]:
        """Numbers of the sections with this status."""
        return [number for number, section in enumerate(self.sections) if section.status == status]

    def area_function(self, lips: str | tuple[float, float] | Lips | None) -> AreaFunction:
        """Lengths and areas from glottis to lips; its ``sections`` are this tract.

        Raises:
            InputError: lips missing or unknown, or sections that are open.
        """
        end = as_lips(lips)
        if open_ones := self.with_status("open"):
            place = np.round(self.sections[open_ones[0]].origin[[0, 2]] * 1e3, 1).tolist()
            raise InputError(
                f"{len(open_ones)} of {len(self.sections)} sections are open, the first is number {open_ones[0]} "
                f"(counted from 0 at the glottis) at x, z = {place} mm: the outer wall, or what faces it, is missing "
                "there; close the gap in the walls (seams up to 3 mm are bridged)"
            )
        return AreaFunction(np.append(self.lengths, end.length), np.append(self.areas, end.area), sections=self)


def cut_tract(
    posture: Posture,
    *,
    planes: int = PLANES,
    lateral_end: str = "outer",
    path: str = "centroids",
    barrier: float = BARRIER,
    floor: float = FLOOR,
    divisions: int | None = None,
) -> Tract:
    """Cuts the vocal tract of a posture into sections.

    Args:
        posture: of a speaker with walls.
        planes: number of cutting planes, 8 to 500.
        lateral_end: of sections of the mouth: "outer" edge, "crest" or "lingual" edge of the upper dental arch.
        path: measure lengths along the "centroids" of the sections, as the paper does, or along the "midline" at rest.
        barrier: m, smallest gap that connects parts of the airway.
        floor: m², smallest area.
        divisions: pieces of each edge of the tongue's surface, 1 to 16; None: about FACETS m long.

    Raises:
        InputError: no walls, no airway between walls and tongue at rest, or bad arguments.
    """
    instance(posture, Posture, "posture")
    count = whole_number(planes, "planes", 8, 500)
    end = one_of(lateral_end, LATERAL_ENDS, "lateral_end")
    along = one_of(path, PATHS, "path")
    pieces = None if divisions is None else whole_number(divisions, "divisions", 1, 16)
    least, smallest = positive_number(barrier, "barrier (m)"), positive_number(floor, "floor (m²)")
    speaker = posture.speaker
    rest = _rest(speaker, count)
    if posture.wall_displacements:
        rest = with_walls(rest.planes, rest.columns, walls_of(posture))
    below = profile(rest, _solids(posture, rest, pieces))
    return Tract(_sections(rest, below, end, least, smallest), end, along)


def area_function(
    posture: Posture,
    lips: str | tuple[float, float] | Lips | None = None,
    *,
    planes: int = PLANES,
    lateral_end: str = "outer",
    path: str = "centroids",
    barrier: float = BARRIER,
    floor: float = FLOOR,
    divisions: int | None = None,
) -> AreaFunction:
    """Area function of a posture from glottis to lips; its ``sections`` are the :class:`Tract`.

    Args:
        posture: of a speaker with walls.
        lips: name of a vowel (Table IV), a pair (length in m, area in m²), or Lips.
        planes: as for :func:`cut_tract`.
        lateral_end: as for :func:`cut_tract`.
        path: as for :func:`cut_tract`.
        barrier: as for :func:`cut_tract`.
        floor: as for :func:`cut_tract`.
        divisions: as for :func:`cut_tract`.

    Raises:
        InputError: as for :func:`cut_tract`; lips missing or unknown; open sections.
    """
    end = as_lips(lips)
    tract = cut_tract(
        posture, planes=planes, lateral_end=lateral_end, path=path, barrier=barrier, floor=floor, divisions=divisions
    )
    return tract.area_function(end)


_rest_tracts: weakref.WeakKeyDictionary[Speaker, dict[int, RestTract]] = weakref.WeakKeyDictionary()
_surfaces: weakref.WeakKeyDictionary[Speaker, dict[int, tuple[sparse.csr_array, IntArray]]]
_surfaces = weakref.WeakKeyDictionary()


def _rest(speaker: Speaker, count: int) -> RestTract:
    known = _rest_tracts.setdefault(speaker, {})
    if count not in known:
        known[count] = rest_tract(speaker, count)
    return known[count]


def _tongue(speaker: Speaker, divisions: int) -> tuple[sparse.csr_array, IntArray]:
    known = _surfaces.setdefault(speaker, {})
    if divisions not in known:
        known[divisions] = speaker.smooth_surface.triangulation(divisions)
    return known[divisions]


def _divisions(speaker: Speaker) -> int:
    corners = speaker.nodes[speaker.surface_quads]
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    return int(np.clip(np.rint(edges.mean() / FACETS), 1, 16))


def _solids(posture: Posture, rest: RestTract, divisions: int | None) -> list[tuple[int, Crossings]]:
    """Crossings of tongue and hyoid at the posture; their numbers follow those of the walls."""
    weights, triangles = _tongue(posture.speaker, divisions or _divisions(posture.speaker))
    solids = [(weights @ posture.positions, triangles)]
    if (bone := hyoid_of(posture)) is not None:
        solids.append((bone.vertices, bone.triangles))
    first = len(rest.names)
    return [(first + n, cross(*solid, rest.planes, rest.columns)) for n, solid in enumerate(solids)]


def _sections(rest: RestTract, below: Profile, end: str, least: float, floor: float) -> tuple[Section, ...]:
    ends, row = rest.ends[end], rest.columns
    inside = (row >= ends[:, :1]) & (row <= ends[:, 1:])
    gaps = np.where(inside & ~np.isnan(rest.outer), rest.outer - below.inner, -1.0)
    spread = max(1, round(least / (row[1] - row[0])))
    passages = airway(split_at_slits(gaps, least, round(SLIT / (row[1] - row[0]))), spread, least)
    return tuple(_section(k, passages[k], rest, below, ends[k], spread, floor) for k in range(len(rest.planes)))


def _section(
    k: int, passage: Passage, rest: RestTract, below: Profile, ends: FloatArray, spread: int, floor: float
) -> Section:
    row, outer, inner = rest.columns, rest.outer[k], below.inner[k]
    channels = passage.channels
    drawn = [contour(channel, row, outer, inner, ends, spread if channel.reached else 0) for channel in channels]
    shape = joined([polygon for polygon, _ in drawn])
    beside = [contour(channel, row, outer, inner, ends, spread)[0] for channel in passage.beside]
    measured = float(shape.area)
    planes, half = rest.planes, len(row) // 2
    if measured > 0.0:
        centre = np.array([shape.centroid.x, shape.centroid.y])
    else:
        centre = np.array([0.0, np.nan_to_num(outer[half])])
    columns = np.concatenate([np.arange(c.first, c.last + 1) for c in channels] or [np.zeros(0, dtype=int)])
    middle = [half - 1, half]
    missing = bool(np.isnan(outer[middle]).any() or below.missing[k, middle].all())
    status = "open" if missing else "ambiguous" if len(channels) + len(beside) > 1 else "closed"
    (x, z), (nx, nz), (ox, oz) = planes.origins[k], planes.normals[k], planes.outwards[k]
    return Section(
        area=max(measured, floor),
        measured_area=measured,
        area_beside=float(sum(polygon.area for polygon in beside)),
        contour=shape,
        centroid=planes.to_space(k, centre),
        origin=np.array([x, 0.0, z]),
        normal=np.array([nx, 0.0, nz]),
        outwards=np.array([ox, 0.0, oz]),
        midsagittal=_on_midline(outer[middle], inner[middle], missing),
        bounds=_bounds(rest.names, rest.outer_wall[k, columns], below.structure[k, columns]),
        status=status,
        floored=measured < floor,
        occluded=not channels or not all(channel.reached for channel in channels),
        clamped=bool(below.clamped[k, columns].any()),
        bridged=bool(below.bridged[k, columns].any()),
        lateral_end=any(reached for _, reached in drawn),
        arch=bool(rest.arch[k]),
    )


def _on_midline(outer: FloatArray, inner: FloatArray, missing: bool) -> FloatArray:
    top, bottom = float(outer.mean()), float(inner.mean())
    return np.full(2, np.nan) if missing else np.array([min(bottom, top), top])


def _bounds(walls: tuple[str, ...], above: Numbers, below: Numbers) -> dict[str, float]:
    names = (*walls, "tongue", "hyoid")
    both = np.concatenate([above, below])
    counts = np.bincount(both[both >= 0], minlength=len(names))
    return {name: float(count / len(both)) for name, count in zip(names, counts, strict=True) if count}
