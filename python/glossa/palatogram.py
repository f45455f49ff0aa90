"""Electropalatography: which electrodes of an artificial palate the tongue touches.

The layout is that of the Reading palate (Hardcastle, Gibbon & Jones 1991): 62 electrodes in 8 rows, 6 in front and 8 in
each other row, from behind the upper incisors to the rear end of the hard palate; the rear half of the rows lies twice
as far apart as the front half. Rows stand at constant x and run across the vault from gum to gum.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.ma import MaskedArray
from scipy.spatial import cKDTree

from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray, frozen
from glossa.anatomy.plane_cut import plane_cut
from glossa.anatomy.swept_surface import chord_lengths
from glossa.anatomy.walls import Wall
from glossa.checks import positive_number
from glossa.errors import InputError
from glossa.results import Posture

ROWS = (6, 8, 8, 8, 8, 8, 8, 8)
"""Electrodes in each row, front to back."""

STATIONS = np.array([0, 1, 2, 3, 5, 7, 9, 11]) / 12
"""Places of the rows along the midline of the palate, between its front (0) and its rear end (1)."""

CROWN = 0.4
"""Part of the height of the vault over the edges of the teeth that the teeth cover; the electrodes lie above it."""

FILM = 0.5e-3
"""Gap between tongue and palate that saliva bridges, m; the airway counts as closed at the same gap."""

REACH = 2.5e-3
"""An electrode further than this from every point of the tongue is off, m; the distance of neighbouring points."""

LEAST_HEIGHT = 1e-3
"""Of a vault over the edges of the teeth, m."""

_SAMPLES = 400  # of the midline


@dataclass(frozen=True, kw_only=True, eq=False)
class Palatogram:
    """Electrodes on the hard palate and which of them are touched.

    Attributes:
        electrodes: (62, 3) m, on the palate; row by row from the front, each from y < 0 to y > 0: from left to right
            for who looks from above with the front at the top.
        on: (62,) touched.
    """

    electrodes: FloatArray
    on: BoolArray

    @property
    def rows(self) -> MaskedArray[tuple[int, int], np.dtype[np.bool_]]:
        """(8, 8) ``on`` by row and column, front row first; the two corners without electrode are masked."""
        values = np.zeros((len(ROWS), max(ROWS)), dtype=bool)
        values[_places()] = self.on
        missing = np.ones_like(values)
        missing[_places()] = False
        return np.ma.MaskedArray(values, mask=missing)

    @property
    def percent(self) -> float:
        """Of the electrodes that are on."""
        return float(100.0 * self.on.mean())

    def text(self) -> str:
        """Eight lines, front row first: "#" touched, "." not."""
        signs = np.full((len(ROWS), max(ROWS)), " ")
        signs[_places()] = np.where(self.on, "#", ".")
        return "\n".join(" ".join(row).rstrip() for row in signs.tolist())

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"Palatogram({int(self.on.sum())} of {len(self.on)} electrodes on)"


def palatogram(posture: Posture, wall: str = "hard_palate", *, film: float = FILM) -> Palatogram:
    """Palatogram of a posture.

    An electrode is on if, of all points of the tongue that may touch the palate, the one nearest to it lies within
    ``film`` of the palate. Pressure is not asked for, nor is it by the device: a light touch closes the circuit.

    Args:
        posture: of a scene with contact.
        wall: name of the palate.
        film: gap between tongue and palate that counts as contact, m.

    Raises:
        InputError: a posture without contact, no such wall, or a wall that is no palate.
    """
    positive_number(film, "palatogram: film")
    if wall not in posture.speaker.walls:
        known = ", ".join(posture.speaker.walls) or "none"
        raise InputError(f"a palatogram needs the wall {wall!r}; this speaker has {known}")
    if posture.contact is None:
        raise InputError("a palatogram needs a posture with contact; this one comes from a scene without")
    try:
        electrodes = palate_electrodes(posture.speaker.walls[wall])
    except InputError as error:
        raise InputError(f"no palatogram on wall {wall!r}: {error}") from None
    electrodes = electrodes + posture.wall_displacements.get(wall, np.zeros(3))
    own = posture.contact.at_wall(wall)
    on = np.zeros(len(electrodes), dtype=bool)
    if own.any():
        distance, nearest = cKDTree(posture.contact.points[own]).query(electrodes)
        on = (posture.contact.gaps[own][nearest] < film) & (distance < REACH)
    return Palatogram(electrodes=electrodes, on=on)


@lru_cache(maxsize=32)
def palate_electrodes(wall: Wall) -> FloatArray:
    """(62, 3) m: electrodes on a hard palate with its teeth; x runs backwards and z up.

    Of several surfaces above each other, the lowest is the palate.

    Raises:
        InputError: the wall has no section in y = 0, or no vault.
    """
    x, z = _midline(wall)
    edge = int(z[: len(z) // 2].argmin())
    height = float(z.max() - z[edge])
    if height < LEAST_HEIGHT:
        raise InputError("it does not rise behind its front edge, so that it has no vault to put electrodes on")
    first = edge + int(np.argmax(z[edge:] >= z[edge] + CROWN * height))
    along = chord_lengths(np.column_stack([x[first:], z[first:]]))
    stations = np.interp(STATIONS * along[-1], along, x[first:])
    rows = []
    for station, count in zip(stations.tolist(), ROWS, strict=True):
        across = _row(wall, station, count)
        rows.append(np.column_stack([np.full(count, station), across]))
    return frozen(np.concatenate(rows))


def _midline(wall: Wall) -> tuple[FloatArray, FloatArray]:
    """(n,) each, m: x and z of the lowest points of the wall in the midplane, front to back."""
    cuts = plane_cut(wall, 1)
    if not cuts:
        raise InputError("it does not meet the midplane y = 0")
    pieces = np.concatenate([np.stack([cut[:-1], cut[1:]], axis=1) for cut in cuts])
    low, high = pieces[:, :, 0].min(axis=1), pieces[:, :, 0].max(axis=1)
    x = np.linspace(low.min(), high.max(), _SAMPLES)
    (x1, z1), (x2, z2) = pieces[:, 0].T, pieces[:, 1].T
    over = (low <= x[:, None]) & (x[:, None] <= high) & (low < high)
    share = np.where(over, (x[:, None] - x1) / np.where(low < high, x2 - x1, 1.0), 0.0)
    z = np.where(over, z1 + share * (z2 - z1), np.inf).min(axis=1)
    return x[np.isfinite(z)], z[np.isfinite(z)]


def _row(wall: Wall, x: float, count: int) -> FloatArray:
    """(count, 2) y and z, m: evenly spaced along the section at ``x``, between the gums of both sides."""
    middles = [(line, *middle) for line in plane_cut(wall, 0, x) if (middle := _lowest_crossing(line)) is not None]
    if not middles:
        raise InputError(f"it has no section across the midplane at x = {x * 1e3:.1f} mm")
    line, place, point = min(middles, key=lambda found: float(found[2][1]))
    right_first = line[place + 1, 0] > line[place, 0]
    sides = np.concatenate([point[None], line[: place + 1][::-1]]), np.concatenate([point[None], line[place + 1 :]])
    left, right = (_to_the_gum(side, x) for side in (sides if right_first else sides[::-1]))
    path = np.concatenate([left[:0:-1], right])
    along = chord_lengths(path)
    at = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(at, along, path[:, k]) for k in (0, 1)], axis=1)


def _lowest_crossing(line: FloatArray) -> tuple[int, FloatArray] | None:
    """Where a line (k, 2) in y and z crosses y = 0 lowest: number of the piece, and the point (2,)."""
    beyond = line[:, 0] >= 0.0
    crossed = np.flatnonzero(beyond[1:] != beyond[:-1])
    if len(crossed) == 0:
        return None
    before, after = line[crossed], line[crossed + 1]
    share = (before[:, 0] / (before[:, 0] - after[:, 0]))[:, None]
    points = before + share * (after - before)
    lowest = int(points[:, 1].argmin())
    return int(crossed[lowest]), points[lowest]


def _to_the_gum(side: FloatArray, x: float) -> FloatArray:
    """The part of a half section (k, 2), from the midline outwards, that the teeth leave free."""
    crest = int(side[:, 1].argmin())
    gum = side[crest, 1] + CROWN * (side[0, 1] - side[crest, 1])
    if side[0, 1] - side[crest, 1] < LEAST_HEIGHT:
        raise InputError(f"it is flat across at x = {x * 1e3:.1f} mm, so that it has no vault to put electrodes on")
    k = int(np.argmax(side[:, 1] <= gum))
    before, after = side[k - 1], side[k]
    share = (before[1] - gum) / (before[1] - after[1])
    return np.concatenate([side[:k], (before + share * (after - before))[None]])


def _places() -> tuple[IntArray, IntArray]:
    """Row and column of each electrode."""
    width = max(ROWS)
    rows = np.repeat(np.arange(len(ROWS)), ROWS)
    columns = np.concatenate([(width - count) // 2 + np.arange(count) for count in ROWS])
    return rows.astype(np.int32), columns.astype(np.int32)
