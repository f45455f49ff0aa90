"""The middle of the airway at rest, in the midsagittal plane.

It is the line of points equally far from the outer walls (palate, velum, rear wall down to the glottis) and from what
faces them (tongue at rest, lower jaw, hyoid bone, front of the larynx): the centres of the circles that just fit
between both, smoothed. Only the geometry at rest enters, so that it serves any speaker with walls.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.ndimage import gaussian_filter1d
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.plane_cut import plane_cut
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.swept_surface import chord_lengths
from glossa.anatomy.walls import Wall
from glossa.errors import InputError

STEP = 0.25e-3
"""Distance of the points that stand for a line, m."""
BESIDE = 1e-5
"""y at which the midsagittal section is cut, m: in the midplane itself meshes have vertices, or a seam."""
JOIN = 5e-3
"""Widest seam between two pieces of the outer wall along the tract, m."""
OVERLAP = 2e-3
"""Lines that keep this near to the outer wall are its overlapping edges, m."""
LONELY = 10e-3
"""How far a front wall may go on where the rear wall has ended, m."""
CONE = 0.8
"""Cosine of the angle to either side within which a piece of the outer wall goes on behind a wider gap."""
FOLD = 8e-3
"""Length of wall over which an edge folded back is looked for, m: the front of an incisor is no part of the tract."""
SMOOTHING = 8e-3
"""Standard deviation of the smoothing along the midline, m: planes one after the other must not cross within the depth
of a section, 20 mm."""
EXTENSION = 3e-3
"""How far below the lowest circle the edges of the larynx are looked for, m."""
LARGEST_RADIUS = 40e-3
"""m; no airway is wider."""
_TO_LARYNX = np.array([1.0, -1.0])  # x and z: it lies behind and below the lips
_SLACK = 0.2e-3  # m; a circle that overlaps the outer wall elsewhere by more does not fit


def rest_midline(speaker: Speaker) -> FloatArray:
    """(k, 2) x and z in m, glottis to incisors, about 0.25 mm apart.

    Raises:
        InputError: no walls, no wall above the tongue in the midsagittal plane, or nothing that faces it.
    """
    outer, inner = midsagittal_sides(speaker)
    line = _extended(centre_line(outer, inner))
    return _between_edges(line, _dense(outer), inner)


def midsagittal_sides(speaker: Speaker) -> tuple[FloatArray, FloatArray]:
    """Outer wall from glottis to incisors as one line (k, 2), and points (n, 2) of all that faces it, m."""
    if not speaker.walls:
        raise InputError(
            "an area function needs walls around the tongue, and this speaker has none; give the speaker walls "
            "(hard palate, velum, pharynx, larynx)"
        )
    weights, triangles = speaker.smooth_surface.triangulation()
    tongue = plane_cut(Wall(weights @ speaker.nodes, triangles), 1, BESIDE)
    if not tongue:
        raise InputError("the midsagittal plane y = 0 does not cut the tongue: there is no midline of an airway")
    lines = [line for wall in speaker.walls.values() for piece in _pieces(wall) for line in plane_cut(piece, 1, BESIDE)]
    chain, rest = _outer_chain(lines, np.concatenate(tongue).mean(axis=0))
    behind = max(float(line[:, 0].max()) for line in tongue)
    if chain[0, 0] < behind:
        raise InputError(
            f"the walls above the tongue end at x = {chain[0, 0] * 1e3:.1f} mm in the midsagittal plane, in front of "
            f"the tongue's rear at {behind * 1e3:.1f} mm: the rear wall of the pharynx is missing"
        )
    _check_larynx(chain, rest)
    if speaker.hyoid is not None and speaker.hyoid.surface is not None:
        rest = rest + [_dense(line) for line in plane_cut(speaker.hyoid.surface, 1, BESIDE)]
    return chain, np.concatenate([*(_dense(line) for line in tongue), *rest])


def centre_line(outer: FloatArray, inner: FloatArray) -> FloatArray:
    """(k, 2) centres of the circles that touch ``outer`` (a line) and ``inner`` (points), smoothed, along ``outer``."""
    feet = _dense(outer)
    tangent = np.gradient(gaussian_filter1d(feet, 4.0, axis=0, mode="nearest"), axis=0)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    facing, own = cKDTree(inner), cKDTree(feet)
    towards = inner[facing.query(feet)[1]] - feet
    if np.sum(np.sign((towards * normal).sum(axis=1))) < 0.0:
        normal = -normal
    low, high = np.zeros(len(feet)), np.full(len(feet), LARGEST_RADIUS)
    for _ in range(24):
        middle = 0.5 * (low + high)
        free = facing.query(feet + middle[:, None] * normal)[0] > middle
        low, high = np.where(free, middle, low), np.where(free, high, middle)
    centres = feet + low[:, None] * normal
    fits = (own.query(centres)[0] > low - _SLACK) & (low < 0.99 * LARGEST_RADIUS)
    if fits.sum() < 8:
        raise InputError(
            "nothing faces the outer walls in the midsagittal plane, so that the middle of the airway is not defined; "
            "check that the tongue lies between the walls"
        )
    return _smooth(_dense(centres[fits]))


def _extended(line: FloatArray) -> FloatArray:
    """The line with a straight end at the glottis: where the larynx widens downwards, circles end above its edge."""
    steps = np.arange(round(EXTENSION / STEP), 0, -1)[:, None]
    return np.concatenate([line[0] + steps * (line[0] - line[1]), line])


def _between_edges(line: FloatArray, outer: FloatArray, inner: FloatArray) -> FloatArray:
    """The line without ends whose perpendicular passes beside the edge of the outer wall or of what faces it."""
    tangent = np.gradient(line, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    outwards = np.sign(((outer[cKDTree(outer).query(line)[1]] - line) * normal).sum(axis=1))[:, None] * normal

    def meets(k: int) -> bool:
        sides = []
        for points, direction in ((outer, outwards[k]), (inner, -outwards[k])):
            arms = points - line[k]
            height = arms @ direction
            near = (np.abs(arms @ tangent[k]) <= STEP) & (height > 0.0) & (height < LARGEST_RADIUS)
            sides.append(bool(near.any()))
        return all(sides)

    limit = len(line) // 4
    first = next((k for k in range(limit) if meets(k)), 0)
    last = next((k for k in range(len(line) - 1, len(line) - 1 - limit, -1) if meets(k)), len(line) - 1)
    return line[first : last + 1]


def _outer_chain(lines: list[FloatArray], inside: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
    """The outer wall as one line from glottis to incisors, and the other lines.

    The line farthest above ``inside`` is the palate; pieces that go on from its ends, behind a seam or overlapping,
    are joined.
    """
    heights = [_height_above(line, inside) for line in lines]
    if not lines or max(heights) < 0.0:
        raise InputError(
            "no wall stands above the middle of the tongue in the midsagittal plane y = 0: the hard palate is missing"
        )
    first = int(np.argmax(heights))
    chain, rest = lines[first], [line for number, line in enumerate(lines) if number != first]
    if np.allclose(chain[0], chain[-1]):
        raise InputError("the wall above the tongue is closed in the midsagittal plane; it must be an open surface")
    while (found := _continuation(chain, rest)) is not None:
        number, chain = found
        rest = rest[:number] + rest[number + 1 :]
    if chain[-1] @ _TO_LARYNX < chain[0] @ _TO_LARYNX:
        chain = chain[::-1]
    chain, front_wall = _without_bottom(chain)
    chain = _unfolded(_unfolded(chain)[::-1])
    near = cKDTree(_dense(chain))
    rest = [line for line in rest if near.query(line)[0].max() > OVERLAP]
    return chain, [_above_bottom(line, chain) for line in rest + front_wall]


def _above_bottom(line: FloatArray, chain: FloatArray) -> FloatArray:
    """The points of a line that are not the bottom of a closed larynx: level with its end and across it."""
    end, down = chain[0], -_direction(chain)
    dense = _dense(line)
    heading = gaussian_filter1d(np.gradient(dense, axis=0), 4.0, axis=0, mode="nearest")
    across = np.abs(heading @ down) < 0.5 * np.linalg.norm(heading, axis=1)
    level = ((dense - end) @ down > -FOLD) & (np.linalg.norm(dense - end, axis=1) < LARGEST_RADIUS)
    return np.asarray(dense[~(across & level)])


def _pieces(wall: Wall) -> list[Wall]:
    """Connected pieces of a wall: where two of them touch, their cuts stay two lines."""
    triangles, count = wall.triangles, len(wall.vertices)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]])
    graph = sparse.coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    piece = connected_components(graph, directed=False)[1][triangles[:, 0]]
    return [Wall(wall.vertices, triangles[piece == number]) for number in np.unique(piece)]


def _check_larynx(chain: FloatArray, lines: list[FloatArray]) -> None:
    """Refuses a rear wall that ends where the wall in front of it goes on."""
    end, direction = chain[0], -_direction(chain)
    for line in lines:
        arms = line - end
        beside = np.linalg.norm(arms - (arms @ direction)[:, None] * direction, axis=1) < LARGEST_RADIUS
        if np.any(beside & (arms @ direction > LONELY)) and np.any(beside & (arms @ direction < 0.0)):
            raise InputError(
                f"the rear wall ends at x, z = {np.round(end * 1e3, 1).tolist()} mm in the midsagittal plane, and the "
                f"wall in front of it goes on for more than {LONELY * 1e3:g} mm: the rear wall of the larynx is missing"
            )


def _without_bottom(chain: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
    """The line from the incisors up to where it turns forwards, across the bottom of a closed larynx; the rest."""
    dense = _dense(chain)
    heading = gaussian_filter1d(np.gradient(dense, axis=0), 4.0, axis=0, mode="nearest")
    forwards = heading[:, 0] < -0.75 * np.linalg.norm(heading, axis=1)
    turns = np.flatnonzero(forwards & (np.arange(len(dense)) * STEP > FOLD))
    return (dense[: turns[0]], [dense[turns[0] :]]) if len(turns) else (chain, [])


def _height_above(line: FloatArray, point: FloatArray) -> float:
    """Height of the highest crossing of a line with the vertical above a point, m; -1 for none."""
    a, b = line[:-1], line[1:]
    crossed = (a[:, 0] <= point[0]) != (b[:, 0] <= point[0])
    if not crossed.any():
        return -1.0
    a, b = a[crossed], b[crossed]
    z = a[:, 1] + (point[0] - a[:, 0]) / (b[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    return float(z.max() - point[1])


def _continuation(chain: FloatArray, lines: list[FloatArray]) -> tuple[int, FloatArray] | None:
    """Number of the line that goes on from an end of the chain, and the chain with it; None where none does.

    It begins at a seam, or anywhere ahead within CONE: a wide gap stays in the tract, to be reported as open.
    """
    best: tuple[float, int, FloatArray] | None = None
    for forwards in (chain, chain[::-1]):
        end, direction = forwards[-1], -_direction(forwards[::-1])
        for number, line in enumerate(lines):
            if np.allclose(line[0], line[-1]):
                continue
            for candidate in (line, line[::-1]):
                distances = np.linalg.norm(candidate - end, axis=1)
                tail = candidate[(candidate - end) @ direction > _SLACK]
                if len(tail) < 2 or (tail[-1] - end) @ direction <= 0.0 or _direction(candidate) @ direction <= 0.0:
                    continue
                distance, lead = float(distances.min()), tail[0] - end
                if distance > JOIN and lead @ direction < CONE * float(np.linalg.norm(lead)):
                    continue
                if best is None or distance < best[0]:
                    best = (distance, number, np.concatenate([forwards, tail]))
    return None if best is None else best[1:]


def _direction(line: FloatArray) -> FloatArray:
    """Unit vector of the first few millimetres of a line."""
    dense = _dense(line)
    step = dense[min(len(dense) - 1, 12)] - dense[0]
    return np.asarray(step / max(float(np.linalg.norm(step)), 1e-300))


def _unfolded(chain: FloatArray) -> FloatArray:
    """The line without a last part that turns back by more than a right angle."""
    dense = _dense(chain)
    tail = min(int(FOLD / STEP), len(dense) - 2)
    base = dense[-tail - 1]
    heading = base - dense[max(-2 * tail - 1, -len(dense))]
    progress = (dense[-tail - 1 :] - base) @ heading
    farthest = int(progress.argmax())
    back = (progress[-1] - progress[farthest]) / max(float(np.linalg.norm(heading)), 1e-300)
    return dense[: len(dense) - tail + farthest] if back < -STEP else chain


def _dense(line: FloatArray, step: float = STEP) -> FloatArray:
    """Points of a line (k, 2) at equal distances of about ``step`` m along it, both ends among them."""
    along = chord_lengths(line)
    kept = np.concatenate([[True], np.diff(along) > 0.0])
    count = max(2, round(along[-1] / step) + 1)
    at = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(at, along[kept], line[kept, axis]) for axis in range(2)], axis=1)


def _smooth(line: FloatArray) -> FloatArray:
    """Gaussian smoothing along a line of equidistant points; its ends stay."""
    width = SMOOTHING / STEP
    pad = min(int(4.0 * width), len(line) - 1)
    front = 2.0 * line[0] - line[pad:0:-1]
    back = 2.0 * line[-1] - line[-2 : -pad - 2 : -1]
    smooth = gaussian_filter1d(np.concatenate([front, line, back]), width, axis=0, mode="nearest")
    return _dense(smooth[pad : len(smooth) - pad])
