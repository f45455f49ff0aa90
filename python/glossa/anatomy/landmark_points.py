"""Named points of a speaker that can be measured on a subject, found by geometric rules.

They are read off an MRI, or off a palate trace and articulography. The rules look at sections of tongue, walls and
hyoid bone only, never at the numbering of a mesh, so that they find corresponding points on any speaker. Rules that ask
for the highest or foremost point take the middle of all that is nearly so: such lines are flat there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.plane_cut import plane_cut
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.swept_surface import chord_lengths
from glossa.anatomy.walls import Wall

MIDSAGITTAL: Mapping[str, str] = MappingProxyType(
    {
        "upper_incisor": "edge of the upper incisors: lowest point of the hard palate",
        "alveolar_ridge": "hard palate half-way up from the incisors' edge to the vault",
        "vault": "top of the hard palate: middle of what is within 0.5 mm of its highest point",
        "palate_end": "where the velum begins, without one the rear end of the hard palate",
        "velum": "outer wall on the line that rises backwards at 45 degrees from the middle of the tongue",
        "pharynx_wall": "rear wall at the height of the tongue's rear",
        "lower_pharynx_wall": "rear wall at the height of the vallecula",
        "glottis": "middle between front and rear wall of the larynx, as low as it has both",
        "lower_incisor": "edge of the lower incisors: highest point of the mandible",
        "symphysis": "lower rear edge of the mandible: farthest backwards and down at 45 degrees",
        "hyoid": "body of the hyoid bone: middle of its section",
        "tip": "tongue tip: middle of what is within 1.5 mm of the tongue's foremost point",
        "blade": "tongue's upper side half-way along it from tip to dorsum",
        "dorsum": "middle of what is within 0.5 mm of the tongue's highest point",
        "back": "tongue on the line that rises backwards at 45 degrees from its middle",
        "rear": "middle of what is within 0.5 mm of the tongue's rearmost point",
        "vallecula": "where the tongue's rear turns towards the hyoid: farthest backwards and down at 45 degrees, "
        "nearer to the rear than to the dorsum",
        "frenulum": "where the tongue's underside turns down along the mandible: deepest point behind the straight "
        "line from the tip to the lower front edge",
    }
)
"""Points of the midsagittal plane. The middle of the tongue is below its dorsum, at the height of its rear."""

LATERAL: Mapping[str, str] = MappingProxyType(
    {
        "palate_side": "hard palate half-way down from the vault to the molars, in the frontal plane of the molars",
        "upper_molar": "upper dental arch: middle of what is within 3 mm of its lowest point, in that plane",
        "lower_molar": "lower dental arch: middle of what is within 3 mm of its highest point, in that plane",
        "tongue_side": "tongue above the frenulum: middle of what is within 0.5 mm of its half width, in that plane",
        "root_side": "the same in the level plane of the tongue's rear",
        "pharynx_side": "where the rear wall is widest, in that plane",
        "hyoid_horn": "rear end of the hyoid's greater horn",
        "styloid": "styloid process, where the styloglossus begins",
    }
)
"""Points of both sides, named with the ending ``_left`` (y < 0) or ``_right`` (y > 0). The frontal plane of the molars
stands half-way between alveolar ridge and palate end."""

SIDES: Mapping[str, float] = MappingProxyType({"left": -1.0, "right": 1.0})
"""Sign of y."""

_BESIDE = 1e-5  # m; y of the midsagittal section: in the plane itself meshes have vertices, or a seam
_NEARLY, _NEARLY_TIP, _NEARLY_CREST = 0.5e-3, 1.5e-3, 3e-3  # m below the extreme that counts as extreme
_STEP = 0.5e-3  # m; heights at which the larynx is looked at
_NARROWEST = 2e-3  # m; lines nearer than this are not front and rear of the larynx
_X, _Z = 0, 1  # columns of a midsagittal section
_BACK_UP, _BACK_DOWN, _FRONT_DOWN = (np.array(d) / np.sqrt(2.0) for d in ([1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]))

Lines = list[FloatArray]


def landmark_points(speaker: Speaker) -> dict[str, FloatArray]:
    """Landmarks of a speaker at rest: name -> (3,) m, in the order of MIDSAGITTAL and LATERAL.

    A landmark whose organ the speaker lacks is left out. The walls "hard_palate", "soft_palate" and "mandible" are
    known by their names; all others count as walls of pharynx and larynx.
    """
    tongue = tongue_surface(speaker)
    sections = {name: plane_cut(wall, 1, _BESIDE) for name, wall in speaker.walls.items()}
    midsagittal = _midsagittal(speaker, plane_cut(tongue, 1, _BESIDE), sections)
    points = {name: np.array([x, 0.0, z]) for name, (x, z) in midsagittal.items()}
    for name, found in _lateral(speaker, tongue, midsagittal).items():
        points |= {f"{name}_{side}": found[side] for side in found}
    ordered = [*MIDSAGITTAL, *(f"{name}_{side}" for name in LATERAL for side in SIDES)]
    return {name: points[name] for name in ordered if name in points}


def tongue_surface(speaker: Speaker) -> Wall:
    """The tongue's smooth surface at rest in triangles."""
    weights, triangles = speaker.smooth_surface.triangulation()
    return Wall(weights @ speaker.nodes, triangles)


def _midsagittal(speaker: Speaker, tongue: Lines, sections: Mapping[str, Lines]) -> dict[str, FloatArray]:
    """(2,) x and z of the points of the midsagittal plane, from the sections of tongue and walls."""
    points = _tongue_points(tongue)
    palate, velum, jaw = (sections.get(name, []) for name in ("hard_palate", "soft_palate", "mandible"))
    if palate:
        points |= _palate_points(palate, velum)
    outer = [line for name, lines in sections.items() if name != "mandible" for line in lines]
    if jaw:
        points["lower_incisor"] = _middle_of_extreme(jaw, lambda p: p[:, _Z], 0.0)
        points["symphysis"] = _middle_of_extreme(jaw, lambda p: p @ _BACK_DOWN, 0.0)
    if speaker.hyoid is not None and speaker.hyoid.surface is not None:
        bone = plane_cut(speaker.hyoid.surface, 1, _BESIDE)
        if bone:
            outline = np.concatenate(bone)
            points["hyoid"] = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
    if "rear" not in points:
        return points
    middle, backwards = np.array([points["dorsum"][_X], points["rear"][_Z]]), np.array([1.0, 0.0])
    rays = {
        "velum": (middle, _BACK_UP),
        "pharynx_wall": (points["rear"], backwards),
        "lower_pharynx_wall": (points["vallecula"], backwards),
    }
    for name, (origin, direction) in rays.items():
        points |= _hit(name, outer, origin, direction)
    return points | _glottis(outer, points["vallecula"][_Z])


def _tongue_points(lines: Lines) -> dict[str, FloatArray]:
    """Points of the tongue's outline; none where the midsagittal plane misses the tongue."""
    if not lines:
        return {}
    outline = max(lines, key=lambda line: float(chord_lengths(line)[-1]))
    one = [outline]
    points = {
        "tip": _middle_of_extreme(one, lambda p: -p[:, _X], _NEARLY_TIP),
        "dorsum": _middle_of_extreme(one, lambda p: p[:, _Z], _NEARLY),
        "rear": _middle_of_extreme(one, lambda p: p[:, _X], _NEARLY),
    }
    behind = _beyond(one, _X, 0.5 * float(points["dorsum"][_X] + points["rear"][_X]))
    points["vallecula"] = _middle_of_extreme(behind, lambda p: p @ _BACK_DOWN, 0.0)
    upper = _between(outline, points["tip"], points["dorsum"])
    points["blade"] = _at_share(upper, 0.5)
    middle = np.array([points["dorsum"][_X], points["rear"][_Z]])
    points |= _hit("back", one, middle, _BACK_UP)
    front_edge = _middle_of_extreme(one, lambda p: p @ _FRONT_DOWN, 0.0)
    under = _between(outline, points["tip"], front_edge)
    run = front_edge - points["tip"]
    points["frenulum"] = under[int((under @ np.array([-run[_Z], run[_X]])).argmax())]
    return points


def _palate_points(palate: Lines, velum: Lines) -> dict[str, FloatArray]:
    edge = _middle_of_extreme(palate, lambda p: -p[:, _Z], 0.0)
    top = _middle_of_extreme(palate, lambda p: p[:, _Z], _NEARLY)
    line = max(palate, key=lambda one: float(one[:, _Z].max()))
    climb = _crossings(line, line[:, _Z] - 0.5 * (edge[_Z] + top[_Z]))
    points = {"upper_incisor": edge, "vault": top}
    if len(climb):
        points["alveolar_ridge"] = climb[climb[:, _X].argmin()]
    ends = np.concatenate([one[[0, -1]] for one in velum or palate])
    points["palate_end"] = ends[ends[:, _X].argmin() if velum else ends[:, _X].argmax()]
    return points


def _glottis(outer: Lines, below: float) -> dict[str, FloatArray]:
    """Between front and rear wall at the lowest height (m, under ``below``) that has both."""
    bottom = min((float(line[:, _Z].min()) for line in outer), default=below)
    for height in np.arange(bottom + 0.5 * _STEP, below, _STEP):
        x = np.concatenate([_crossings(line, line[:, _Z] - height)[:, _X] for line in outer])
        if len(x) and np.ptp(x) > _NARROWEST:
            return {"glottis": np.array([0.5 * (x.min() + x.max()), height])}
    return {}


def _lateral(speaker: Speaker, tongue: Wall, midsagittal: Mapping[str, FloatArray]) -> dict[str, dict[str, FloatArray]]:
    """Points of both sides: name -> side -> (3,) m."""
    found: dict[str, dict[str, FloatArray]] = {name: {} for name in LATERAL}
    for side, sign in SIDES.items():
        points: dict[str, FloatArray] = {}
        if {"alveolar_ridge", "palate_end"} <= midsagittal.keys():
            x = 0.5 * (midsagittal["alveolar_ridge"][_X] + midsagittal["palate_end"][_X])
            frontal = _frontal(speaker, tongue, x, sign, midsagittal)
            points |= {name: np.array([x, sign * y, z]) for name, (y, z) in frontal.items()}
        if "rear" in midsagittal:
            z = midsagittal["rear"][_Z]
            level = _level(speaker, tongue, z, sign, float(midsagittal["dorsum"][_X]))
            points |= {name: np.array([x, sign * y, z]) for name, (x, y) in level.items()}
        points |= _bony(speaker, sign)
        for name, point in points.items():
            found[name][side] = point
    return found


def _frontal(
    speaker: Speaker, tongue: Wall, x: float, sign: float, midsagittal: Mapping[str, FloatArray]
) -> dict[str, FloatArray]:
    """(2,) distance from the midplane and z of the points of one side in the frontal plane at ``x``."""

    def section(wall: Wall) -> Lines:
        return _beyond([line * [sign, 1.0] for line in plane_cut(wall, 0, x)], 0, 0.0)

    points: dict[str, FloatArray] = {}
    palate = section(speaker.walls["hard_palate"])
    if palate:
        molar = _middle_of_extreme(palate, lambda p: -p[:, 1], _NEARLY_CREST)
        points["upper_molar"] = molar
        every = np.concatenate(palate)
        half_way = 0.5 * (every[:, 1].min() + every[:, 1].max())
        points |= _nearest_crossing("palate_side", palate, half_way)
    jaw = section(speaker.walls["mandible"]) if "mandible" in speaker.walls else []
    if jaw:
        points["lower_molar"] = _middle_of_extreme(jaw, lambda p: p[:, 1], _NEARLY_CREST)
    if "frenulum" in midsagittal:
        upper = _beyond(section(tongue), 1, midsagittal["frenulum"][_Z])
        if upper:
            points["tongue_side"] = _middle_of_extreme(upper, lambda p: p[:, 0], _NEARLY)
    return points


def _level(speaker: Speaker, tongue: Wall, z: float, sign: float, middle: float) -> dict[str, FloatArray]:
    """(2,) x and distance from the midplane of the points of one side in the level plane at ``z``."""

    def section(wall: Wall) -> Lines:
        return _beyond([line * [1.0, sign] for line in plane_cut(wall, 2, z)], 1, 0.0)

    points: dict[str, FloatArray] = {}
    sides = section(tongue)
    if sides:
        points["root_side"] = _middle_of_extreme(sides, lambda p: p[:, 1], _NEARLY)
    rear = [line for name, wall in speaker.walls.items() if name != "mandible" for line in section(wall)]
    rear = _beyond(rear, 0, middle)
    if rear:
        points["pharynx_side"] = _middle_of_extreme(rear, lambda p: p[:, 1], 0.0)
    return points


def _bony(speaker: Speaker, sign: float) -> dict[str, FloatArray]:
    """(3,) m of the hyoid's horn and the styloid process of one side."""
    points: dict[str, FloatArray] = {}
    if speaker.hyoid is not None and speaker.hyoid.surface is not None:
        vertices = speaker.hyoid.surface.vertices
        here = vertices[sign * vertices[:, 1] > 0.0]
        if len(here):
            points["hyoid_horn"] = here[here[:, 0].argmax()].copy()
    styloid = speaker.nodes[speaker.node_sets.get("styloid", np.zeros(0, np.int32))]
    here = styloid[sign * styloid[:, 1] > 0.0]
    if len(here) == 1:
        points["styloid"] = here[0].copy()
    return points


# Lines in a plane: (k, 2) points, closed lines repeat the first


def _middle_of_extreme(lines: Lines, value: Callable[[FloatArray], FloatArray], nearly: float) -> FloatArray:
    """The point half-way along the piece of a line on which ``value`` stays within ``nearly`` of its largest value."""
    line = max(lines, key=lambda one: float(value(one).max()))
    values = value(line)
    best = int(values.argmax())
    if nearly == 0.0:
        return np.asarray(line[best])
    if np.array_equal(line[0], line[-1]):  # start where the value is far from its largest
        start = int(values[:-1].argmin())
        line = np.roll(line[:-1], -start, axis=0)
        line = np.concatenate([line, line[:1]])
        values = value(line)
        best = int(values.argmax())
    excess = values - (values[best] - nearly)
    arms = []
    for sign in (-1, 1):
        arm, heights = line[best::sign], excess[best::sign]
        low = np.flatnonzero(heights < 0.0)
        if len(low):
            n = int(low[0])
            share = heights[n - 1] / (heights[n - 1] - heights[n])
            arm = np.concatenate([arm[:n], [arm[n - 1] + share * (arm[n] - arm[n - 1])]])
        arms.append(arm)
    return _at_share(np.concatenate([arms[0][:0:-1], arms[1]]), 0.5)


def _at_share(line: FloatArray, share: float) -> FloatArray:
    """(2,) the point at a share of the line's length."""
    along = chord_lengths(line)
    return np.array([np.interp(share * along[-1], along, line[:, axis]) for axis in range(2)])


def _between(closed: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """The shorter way round a closed line between two of its points."""
    points = closed[:-1]
    a, b = (int(((points - place) ** 2).sum(axis=1).argmin()) for place in (start, end))
    ways = []
    for sign in (1, -1):
        count = sign * (b - a) % len(points)
        ways.append(points[(a + sign * np.arange(count + 1)) % len(points)])
    inner = min(ways, key=lambda way: float(chord_lengths(way)[-1]))
    return np.concatenate([start[None], inner[1:-1], end[None]])


def _crossings(line: FloatArray, values: FloatArray) -> FloatArray:
    """(c, 2) points at which ``values`` (k,) along a line change sign."""
    up = values >= 0.0
    at = np.flatnonzero(up[1:] != up[:-1])
    share = (values[at] / (values[at] - values[at + 1]))[:, None]
    return np.asarray(line[at] + share * (line[at + 1] - line[at]))


def _nearest_crossing(name: str, lines: Lines, height: float) -> dict[str, FloatArray]:
    """The point nearest to the midplane at which frontal lines pass a height."""
    found = np.concatenate([_crossings(line, line[:, 1] - height) for line in lines])
    return {name: found[found[:, 0].argmin()]} if len(found) else {}


def _hit(name: str, lines: Lines, origin: FloatArray, direction: FloatArray) -> dict[str, FloatArray]:
    """The first point in which a ray meets lines; none where it misses them."""
    across = np.array([-direction[1], direction[0]])
    found = [_crossings(line, (line - origin) @ across) for line in lines]
    places = np.concatenate([*found, np.zeros((0, 2))])
    places = places[(places - origin) @ direction > 0.0]
    return {name: places[((places - origin) @ direction).argmin()]} if len(places) else {}


def _beyond(lines: Lines, axis: int, bound: float) -> Lines:
    """The pieces of lines whose coordinate is at least ``bound``, cut exactly there."""
    pieces = []
    for line in lines:
        inside = line[:, axis] >= bound
        cuts = [0, *(np.flatnonzero(inside[1:] != inside[:-1]) + 1).tolist(), len(line)]
        ends = _crossings(line, line[:, axis] - bound)
        for number, (first, last) in enumerate(pairwise(cuts)):
            if inside[first]:
                before = ends[number - 1 : number] if number else line[:0]
                pieces.append(np.concatenate([before, line[first:last], ends[number : number + 1]]))
    return [piece for piece in pieces if len(piece) > 1]
