"""The walls of the built-in speaker: palate, velum, pharynx, larynx and mandible, smooth and mirror symmetric.

Hard palate, velum and the rear wall down to the glottis are pieces of one swept surface; each piece runs on into the
next, with the same vertices, so that a tongue that slides across a cut meets no groove. They do not depend on the
resolution of the tongue. Normals point into the tract.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.landmarks import pchip
from glossa.anatomy.swept_surface import (
    chord_lengths,
    cubic_spline,
    evenly_spaced,
    grid_quads,
    mirrored_wall,
)
from glossa.anatomy.wall_landmarks import Table, WallLandmarks
from glossa.anatomy.walls import Wall

_SPACING = 1.4  # mm between rows
_OVERLAP = 2  # rows that a piece of the outer wall shares with the next one
_OUTER_COLUMNS, _FRONT_COLUMNS, _MANDIBLE_COLUMNS = 24, 12, 40  # quadrilaterals from the midline to one side
_KNEE = 8.0  # sharpness of the knee of the outer wall's profile
_BESIDE = 0.8  # how fast a row of the mandible widens beyond x = 108, over its widening from 90 to 108
_ROW_COLUMNS = ("rise", "step", "half_width", "y90", "y108")
_MILLIMETRE = 1e-3


def reference_walls(landmarks: WallLandmarks) -> dict[str, Wall]:
    """The walls by name: hard_palate, soft_palate, pharynx, larynx (a tube, front and rear), mandible."""
    stations, first = _outer_stations(landmarks)
    outer = _outer_half(landmarks.outer, stations)
    ends = [start + _OVERLAP for start in first[1:]]
    names = ("hard_palate", "soft_palate", "pharynx")
    walls = {name: _sheet(outer[a : b + 1]) for name, a, b in zip(names, first[:-1], ends, strict=True)}
    walls["larynx"] = _larynx(landmarks.larynx_front, outer[first[-1] :])
    walls["mandible"] = _sheet(_mandible_half(landmarks))
    return walls


def _sheet(half: FloatArray) -> Wall:
    """A wall from the half grid (rows, columns, 3) in mm whose first column is the midline."""
    rows, columns, _ = half.shape
    return mirrored_wall(half.reshape(-1, 3) * _MILLIMETRE, grid_quads(rows, columns))


def _outer_stations(landmarks: WallLandmarks) -> tuple[FloatArray, list[int]]:
    """Lengths along the guide of all rows, and the first rows of hard palate, soft palate, pharynx and larynx.

    The larynx starts where the guide passes the rim of the tube's front.
    """
    outer = landmarks.outer
    knots = _guide_knots(outer)
    below = np.linspace(knots[landmarks.starts[2]], knots[-1], 2000)
    height = cubic_spline(knots, outer["z"], below)
    rim = float(np.interp(-landmarks.larynx_front["z"][0], -height, below))
    cuts = [float(knots[start]) for start in landmarks.starts] + [rim, float(knots[-1])]
    pieces, first = [np.array(cuts[:1])], [0]
    for start, end in pairwise(cuts):
        count = round((end - start) / _SPACING)
        pieces.append(start + (end - start) * np.arange(1, count + 1) / count)
        first.append(first[-1] + count)
    return np.concatenate(pieces), first[:-1]


def _guide_knots(outer: Table) -> FloatArray:
    return chord_lengths(np.stack([outer["x"], outer["z"]], axis=1))


def _outer_half(outer: Table, stations: FloatArray) -> FloatArray:
    """(rows, columns, 3) mm of the outer wall's half at ``stations`` (lengths along the guide)."""
    knots = _guide_knots(outer)
    x, z = (cubic_spline(knots, outer[axis], stations)[:, None] for axis in ("x", "z"))
    columns = ("direction", "half_width", "depth", "exponent", "end")
    angle, width, depth, exponent, end = (pchip(knots, outer[name], stations)[:, None] for name in columns)
    angle = np.radians(angle)

    def rows(fraction: FloatArray) -> FloatArray:
        y = fraction * end
        rise = (y / width) ** exponent
        offset = depth * rise / (1.0 + rise**_KNEE) ** (1.0 / _KNEE)
        return np.stack([x + offset * np.cos(angle), y, z + offset * np.sin(angle)], axis=2)

    return evenly_spaced(rows, len(stations), _OUTER_COLUMNS)


def _larynx(front: Table, rear: FloatArray) -> Wall:
    """The tube: ``rear`` (rows, columns, 3) mm, from the midline to its edge, and on along the front to the midline."""
    edge = rear[:, -1]
    heights = -np.clip(edge[:, 2], front["z"][-1], front["z"][0])
    middle = cubic_spline(-front["z"], front["x"], heights)[:, None]
    exponent = pchip(-front["z"], front["exponent"], heights)[:, None]

    def rows(fraction: FloatArray) -> FloatArray:
        beside = 1.0 - fraction
        x = middle + (edge[:, :1] - middle) * beside**exponent
        return np.stack([x, beside * edge[:, 1:2], np.broadcast_to(edge[:, 2:], x.shape)], axis=2)

    return _sheet(np.concatenate([rear, evenly_spaced(rows, len(rear), _FRONT_COLUMNS)[:, 1:]], axis=1))


def _mandible_half(landmarks: WallLandmarks) -> FloatArray:
    """(rows, columns, 3) mm of the mandible's half."""
    table = landmarks.mandible
    knots = chord_lengths(np.stack([table["z"], table["x"]], axis=1))
    at = np.linspace(0.0, knots[-1], round(knots[-1] / _SPACING) + 1)
    z, x = (cubic_spline(knots, table[name], at) for name in ("z", "x"))
    rise, step, width, y90, y108 = (pchip(knots, table[name], at) for name in _ROW_COLUMNS)
    y126 = y108 + _BESIDE * (y108 - y90)
    plan_x = np.stack([x + step, x, x + step, *np.broadcast_to([[90.0], [108.0], [126.0]], (3, len(x)))], axis=1)
    plan_y = np.stack([-width, np.zeros(len(x)), width, y90, y108, y126], axis=1)

    def rows(fraction: FloatArray) -> FloatArray:
        q = fraction * landmarks.mandible_end
        across = np.array([_across(plan_x[row], plan_y[row], q[row]) for row in range(len(q))])
        height = z[:, None] + rise[:, None] * (across[:, 0] - x[:, None]) / landmarks.rise_length
        return np.stack([across[:, 0], across[:, 1], height], axis=2)

    return evenly_spaced(rows, len(at), _MANDIBLE_COLUMNS)


def _across(x: FloatArray, y: FloatArray, q: FloatArray) -> FloatArray:
    """(2, k) x and y at the parameters ``q`` (k,) of a row through its points at -1 (mirrored), 0, 1, 2, 3, 4."""
    return pchip(np.arange(-1.0, 5.0), np.stack([x, y]), q)
