"""What is fixed for a speaker: cutting planes, the outer wall in every column, and how far sections reach sideways.

The outer wall of a plane (palate, velum, rear wall) is chosen once, with the tongue at rest: the first wall beyond the
midline whose normal points to it, followed sideways from column to column. A tongue that rises or touches cannot change
which wall it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from glossa.anatomy.arrays import BoolArray, FloatArray, frozen
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Wall
from glossa.tract.columns import WIDTH, Crossings, Numbers, column_row, cross, cut
from glossa.tract.midline import rest_midline
from glossa.tract.planes import CuttingPlanes, planes_along

REACH = 40e-3
"""Walls farther from the midline along a column bound no airway, m."""
SEAM = 3e-3
"""Gaps between pieces of wall, or wall and tongue, that are bridged, m."""
SHIFTS = tuple(sign * shift for shift in (0.0, 0.05e-3, 0.2e-3, 0.5e-3, 1e-3, 1.5e-3, 2e-3) for sign in (1.0, -1.0))[1:]
"""A plane that meets a seam of the outer wall or its edge is moved along the midline by the first of these that helps,
m."""
SUDDEN = 0.1
"""Share of its columns that a plane loses from one of SHIFTS to the next where it enters a seam."""
JUMP = 6e-3
"""Largest step of the outer wall from one column to the next, m: a vertical face of a tooth."""
CREST = 1.5e-3
"""Depth of the dental arch that counts as its crest, m."""
LATERAL_ENDS = ("outer", "crest", "lingual")
_SAME = 1e-6  # m; crossings nearer than this are one


@dataclass(frozen=True, eq=False)
class RestTract:
    """Fixed data for k planes and m columns.

    Attributes:
        planes: cutting planes.
        columns: (m,) y, m.
        outer: (k, m) t of the outer wall, m; NaN where there is none.
        outer_wall: (k, m) number of that wall in ``names``; -1 where there is none.
        inner: (k, m) t of the highest fixed wall below, m; -inf where there is none.
        inner_wall: (k, m) number of that wall in ``names``; -1 where there is none.
        ends: by lateral end, (k, 2) lowest and highest y of the section, m.
        arch: (k,) the plane cuts the upper dental arch, where the lateral ends differ.
        names: of the walls.
    """

    planes: CuttingPlanes
    columns: FloatArray
    outer: FloatArray
    outer_wall: Numbers
    inner: FloatArray
    inner_wall: Numbers
    ends: Mapping[str, FloatArray]
    arch: BoolArray
    names: tuple[str, ...]


def rest_tract(speaker: Speaker, count: int) -> RestTract:
    """Fixed data of a speaker with ``count`` planes.

    Raises:
        InputError: no airway between walls and tongue.
    """
    midline = rest_midline(speaker)
    row = column_row(max(float(np.abs(wall.vertices[:, 1]).max()) for wall in speaker.walls.values()))
    return with_walls(_placed(speaker, planes_along(midline, count), row), row, speaker.walls)


def _placed(speaker: Speaker, planes: CuttingPlanes, row: FloatArray) -> CuttingPlanes:
    """Planes moved out of seams and off edges, by the smallest of SHIFTS that helps.

    A plane is in a seam where it meets the walls in fewer columns than the planes on either side of it, all of a
    sudden. At the ends of the tract it is moved to where something is above and below the midline. Walls count as seen
    from the side seen above most of the midline: a plane in front of the incisal edge meets the front of the teeth.
    """
    weights, triangles = speaker.smooth_surface.triangulation()
    surfaces = [(wall.vertices, wall.triangles) for wall in speaker.walls.values()]
    solids = [(weights @ speaker.nodes, triangles)]
    if speaker.hyoid is not None and speaker.hyoid.surface is not None:
        solids.append((speaker.hyoid.surface.vertices, speaker.hyoid.surface.triangles))
    for vertices, faces in solids:  # they matter on the midline only
        surfaces.append((vertices, faces[(np.abs(vertices[faces, 1]).min(axis=1) < SEAM)]))
    widths = np.zeros((2, len(SHIFTS), len(planes)), dtype=np.int64)
    for number, shift in enumerate(SHIFTS):
        trial = replace(planes, origins=planes.origins + shift * planes.normals)
        found = [cross(*surface, trial, row) for surface in surfaces]
        widths[:, number] = _wall_columns(found, len(speaker.walls), len(planes), len(row) // 2)
    usual = int(widths[:, 0].sum(axis=1).argmax())
    any_side = widths.max(axis=0)
    seen = np.where(widths[usual].any(axis=0), widths[usual], any_side)
    moves = np.array([SHIFTS[_least_move(column)] for column in seen.T])
    return replace(planes, origins=frozen(planes.origins + moves[:, None] * planes.normals))


def _wall_columns(found: list[Crossings], walls: int, planes: int, half: int) -> Numbers:
    """(2, planes) columns that meet walls facing in and out; 0 where the middle ones miss something above or below."""
    meets = np.zeros((2, planes, 2 * half), dtype=bool)
    above, below = np.zeros((2, planes, 2), dtype=bool), np.zeros((planes, 2), dtype=bool)
    for number, one in enumerate(found):
        near = np.abs(one.heights) < REACH
        central = near & (one.column >= half - 1) & (one.column <= half)
        low, high = central & (one.heights < 0.0), central & (one.heights > 0.0)
        below[one.plane[low], one.column[low] - half + 1] = True
        if number < walls:
            side = one.facing_out.astype(int)
            meets[side[near], one.plane[near], one.column[near]] = True
            above[side[high], one.plane[high], one.column[high] - half + 1] = True
    return np.where((above & below).all(axis=2), meets.sum(axis=2), 0)


def _least_move(widths: Numbers) -> int:
    """Number of the shift for one plane, from the columns met at each of SHIFTS."""
    shifts = np.array(SHIFTS)
    candidates = []
    for sign in (1.0, -1.0):
        order = np.flatnonzero((sign * shifts > 0.0) | (np.arange(len(shifts)) == 0))
        met = widths[order]
        rise = np.diff(met)
        jumps = np.flatnonzero((rise > SUDDEN * met[1:]) & (rise > 3)) + 1
        if len(jumps):
            full = np.flatnonzero(met >= (1.0 - SUDDEN) * met[jumps[-1]])
            candidates.append(int(order[full[full > 0][0]]))
    if len(candidates) == 2 or (candidates and widths[0] == 0):
        return min(candidates, key=lambda number: abs(shifts[number]))
    return 0


def with_walls(planes: CuttingPlanes, row: FloatArray, walls: Mapping[str, Wall]) -> RestTract:
    """What walls, which may have moved since, make of planes and columns (m,)."""
    every = list(walls.values())
    parts = [cross(w.vertices, w.triangles, planes, row) for w in every]
    found = Crossings(
        *(np.concatenate([getattr(p, name) for p in parts]) for name in ("plane", "column", "heights", "facing_out"))
    )
    wall = np.repeat(np.arange(len(parts)), [len(p.plane) for p in parts])
    near = np.abs(found.heights) < REACH
    shape = (len(planes), len(row))
    outer, outer_wall = _bridged(*_followed(found, wall, near, shape, 1.0))
    below = near.copy()
    below[near] = found.heights[near] < outer[found.plane[near], found.column[near]] - _SAME
    inner, inner_wall = _followed(found, wall, below, shape, -1.0)
    inner[np.isnan(inner)] = -np.inf
    # Sheets that bound the airway from above overlap and hang over: of those only what faces out counts, and in the
    # same wall only below the midline.
    below &= found.facing_out | ~np.isin(wall, outer_wall)
    below &= (wall != outer_wall[found.plane, found.column]) | (found.heights < 0.0)
    order = np.flatnonzero(below)[np.argsort(found.heights[below], kind="stable")]
    place = found.plane[order], found.column[order]
    order = order[found.heights[order] > inner[place]]
    inner[found.plane[order], found.column[order]] = found.heights[order]
    inner_wall[found.plane[order], found.column[order]] = wall[order]
    edges = _edges(every, planes, row, outer, outer_wall)
    ends, arch = _lateral_ends(outer, outer_wall, row, edges)
    return RestTract(planes, row, outer, outer_wall, inner, inner_wall, ends, arch, tuple(walls))


def _followed(
    found: Crossings, wall: Numbers, candidates: BoolArray, shape: tuple[int, int], side: float
) -> tuple[FloatArray, Numbers]:
    """Height and wall (k, m) of the surface above (``side`` 1) or below (-1) the midline, followed sideways.

    It starts with the first crossing in the two middle columns and goes on with the crossing nearest to the last one
    whose triangle faces the same way: front and rear of a tube, which meet at its sides, stay apart.
    """
    chosen = np.flatnonzero(candidates)
    cell = found.plane[chosen] * shape[1] + found.column[chosen]
    order = np.lexsort((found.heights[chosen], cell))
    chosen, cell = chosen[order], cell[order]
    counts = np.bincount(cell, minlength=shape[0] * shape[1])
    most = max(1, int(counts.max(initial=0)))
    place = np.arange(len(cell)) - np.repeat(np.cumsum(counts) - counts, counts)
    heights = np.full((shape[0] * shape[1], most), np.nan)
    number = np.zeros(heights.shape, dtype=np.int64)
    heights[cell, place], number[cell, place] = found.heights[chosen], chosen
    heights_at, number_at = heights.reshape(*shape, most), number.reshape(*shape, most)
    result, which = np.full(shape, np.nan), np.full(shape, -1)
    planes, half = np.arange(shape[0]), shape[1] // 2
    for columns in (range(half, shape[1]), range(half - 1, -1, -1)):
        last, facing = np.full(shape[0], np.nan), np.zeros(shape[0], dtype=bool)
        for column in columns:
            options, numbers = heights_at[:, column], number_at[:, column]
            triangles = found.facing_out[numbers]
            if column in (half, half - 1):
                cost = np.where(side * options > 0.0, np.abs(options), np.inf)
            else:
                cost = np.where(triangles == facing[:, None], np.abs(options - last[:, None]), np.inf)
            cost = np.where(np.isnan(cost), np.inf, cost)
            best = cost.argmin(axis=1)
            good = cost[planes, best] < (REACH if column in (half, half - 1) else JUMP)
            result[good, column] = options[planes, best][good]
            which[good, column] = wall[numbers[planes, best]][good]
            last = np.where(good, result[:, column], last)
            if column in (half, half - 1):
                facing = triangles[planes, best]
    return result, which


def _bridged(outer: FloatArray, which: Numbers) -> tuple[FloatArray, Numbers]:
    """Seams of the outer wall filled by straight lines; what lies beyond a wider gap is left out."""
    widest = round(SEAM / WIDTH)
    half = outer.shape[1] // 2
    for k in range(len(outer)):
        for columns in (np.arange(half, outer.shape[1]), np.arange(half - 1, -1, -1)):
            here = np.flatnonzero(~np.isnan(outer[k, columns]))
            if len(here) == 0:
                continue
            gaps = np.flatnonzero(np.diff(here, prepend=-1) - 1 > widest)
            kept = here[: gaps[0]] if len(gaps) else here
            outer[k, columns[kept[-1] + 1 if len(kept) else 0 :]] = np.nan
            which[k, columns[kept[-1] + 1 if len(kept) else 0 :]] = -1
            if len(kept) == 0:
                continue
            full = np.arange(kept[-1] + 1)
            which[k, columns[full]] = which[k, columns[kept[np.minimum(np.searchsorted(kept, full), len(kept) - 1)]]]
            outer[k, columns[full]] = np.interp(full, kept, outer[k, columns[kept]])
    return outer, which


def _edges(
    walls: list[Wall], planes: CuttingPlanes, row: FloatArray, outer: FloatArray, outer_wall: Numbers
) -> FloatArray:
    """(k, 2) lowest and highest y of the outer wall itself, at most a column beyond the last column that meets it."""
    has = ~np.isnan(outer)
    step = row[1] - row[0]
    first = np.where(has.any(axis=1), row[has.argmax(axis=1)], 0.0)
    last = np.where(has.any(axis=1), row[len(row) - 1 - has[:, ::-1].argmax(axis=1)], 0.0)
    low, high = first.copy(), last.copy()
    for number, wall in enumerate(walls):
        segments, plane, _ = cut(wall.vertices, wall.triangles, planes)
        points, plane = segments.reshape(-1, 2), np.repeat(plane, 2)
        for limits, at, sign in ((low, first, -1.0), (high, last, 1.0)):
            end_column = np.where(has.any(axis=1), np.rint((at - row[0]) / step).astype(int), 0)
            own = outer_wall[np.arange(len(planes)), end_column] == number
            height = outer[np.arange(len(planes)), end_column]
            beyond = sign * (points[:, 0] - at[plane])
            near = own[plane] & (beyond > 0.0) & (beyond < step) & (np.abs(points[:, 1] - height[plane]) < JUMP)
            if sign > 0.0:
                np.maximum.at(limits, plane[near], points[near, 0])
            else:
                np.minimum.at(limits, plane[near], points[near, 0])
    return np.stack([low, high], axis=1)


def _lateral_ends(
    outer: FloatArray, outer_wall: Numbers, row: FloatArray, edges: FloatArray
) -> tuple[dict[str, FloatArray], BoolArray]:
    """Lateral ends by name, and which planes cut the arch.

    The arch is looked for where the outer wall on the midline is the same wall as between the incisors: the hard palate
    with the upper teeth. Its crest is what lies within CREST of its deepest point, if that is twice CREST wide or more.
    """
    half = len(row) // 2
    ends = {name: edges.copy() for name in LATERAL_ENDS}
    arch = np.zeros(len(outer), dtype=bool)
    front = outer_wall[-1, half]
    for k in np.flatnonzero((outer_wall[:, half] == front) & (front >= 0)):
        for side, columns in enumerate((np.arange(half - 1, -1, -1), np.arange(half, len(row)))):
            profile = outer[k, columns]
            profile = profile[~np.isnan(profile)]
            if len(profile) < 2:
                continue
            crest = np.flatnonzero(profile <= profile.min() + CREST)
            width = (crest[-1] - crest[0]) * (row[1] - row[0])
            if profile[0] - profile.min() < 2.0 * CREST or width < 2.0 * CREST or crest[0] == 0:
                continue
            arch[k] = True
            at = row[columns]
            ends["lingual"][k, side] = at[crest[0]]
            ends["crest"][k, side] = 0.5 * (at[crest[0]] + at[crest[-1]])
            if crest[-1] < len(profile) - 1:
                ends["outer"][k, side] = at[crest[-1]]
    return ends, arch
