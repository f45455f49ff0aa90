"""A smooth map of space that takes given points to given targets.

The map is a trend plus what the trend leaves over, interpolated by radial basis functions. The trend is the richest of
affine map, similarity (shift, turn about the lateral axis, one scale for all directions) and shift that the points
determine *everywhere* on the speaker: errors of the targets may nowhere be amplified more than LARGEST_AMPLIFICATION
times. Points of the palate alone say nothing about the stretch of the pharynx; an affine map through four of them turns
a millimetre at the vault into a centimetre and more at the glottis.

The basis function is the distance r, rounded off to sqrt(r2 + ROUNDED2). In space r with an affine trend gives the map
of least bending energy, the integral of all squared second derivatives (Duchon 1977). But it has a kink at every point:
the vault of the built-in palate raised by 5 mm alone turns neighbouring faces by 37 degrees there, rounded off by 11.
Smoother functions bend less and overshoot more between points that move differently, so that space folds over earlier:
with targets scattered by 3 mm around all landmarks, r inverts elements in 3 of 15 trials, rounded off and r2 log r in
6, r3 in 9. Without an affine trend the same function goes with a constant; its influence levels off far from points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator

from glossa.anatomy.arrays import FloatArray
from glossa.errors import InputError

LARGEST_AMPLIFICATION = 2.0
"""Of errors of the targets anywhere on the speaker, by the trend."""

ROUNDED = 4e-3
"""Distance within which the basis function is rounded off, m."""

_ROUNDING = 12  # decimals of a displacement in m: the last bits of linear algebra differ between machines
_PLANE = [0, 2]  # x and z
_STEP = 1e-5  # m; of the difference quotients
_FLAT = 1e-9  # m; |y| below this is the midplane


@dataclass(frozen=True, eq=False)
class Similarity:
    """Shift, turn about the lateral axis and uniform scale: x + i z goes to ``factor`` (x + i z) + ``shift``.

    Attributes:
        factor: complex, scale and turn.
        shift: complex, m.
    """

    factor: complex
    shift: complex

    @property
    def scale(self) -> float:
        """Uniform scale."""
        return abs(self.factor)

    @property
    def turn(self) -> float:
        """Angle, radians, from x towards z."""
        return float(np.angle(self.factor))

    def displacement(self, points: FloatArray) -> FloatArray:
        """(n, 3) m at ``points`` (n, 3)."""
        moved = (self.factor - 1.0) * (points[:, 0] + 1j * points[:, 2]) + self.shift
        return np.stack([moved.real, (self.scale - 1.0) * points[:, 1], moved.imag], axis=1)


class Warp:
    """The map through points and targets.

    If points and targets are mirror images of themselves about y = 0, so is the map, bit for bit, and y = 0 stays. If
    all are in that plane, the map is that of the plane at every y, and widths change by the scale of the similarity.

    Args:
        points: (n, 3) m, different from each other.
        targets: (n, 3) m.
        reach: (k, 3) m, where the map will be used.
        symmetric: points and targets are their own mirror images.

    Attributes:
        trend: "affine", "similarity" or "shift".
        scale: of the similarity nearest to the map; 1 where only a shift is determined.

    Raises:
        InputError: targets that are not symmetric and points that determine no affine map.
    """

    def __init__(self, points: FloatArray, targets: FloatArray, reach: FloatArray, *, symmetric: bool) -> None:
        self._symmetric = symmetric
        self._similarity = Similarity(1.0 + 0.0j, complex(*(targets - points).mean(axis=0)[_PLANE]))
        self.trend = "shift"
        if similarity_amplification(points, reach) <= LARGEST_AMPLIFICATION:
            self._similarity = best_similarity(points, targets)
            self.trend = "similarity"
        flat = symmetric and bool((np.abs(points[:, 1]) <= _FLAT).all())
        self._axes = _PLANE if flat else [0, 1, 2]
        if affine_amplification(points[:, self._axes], reach[:, self._axes]) <= LARGEST_AMPLIFICATION:
            self.trend = "affine"
        elif not symmetric:
            raise InputError(
                f"{len(points)} points whose targets are not mirror symmetric about y = 0 do not determine how the "
                f"rest of the speaker follows; give at least four that are spread over the speaker in all directions, "
                f"or targets of one side only"
            )
        self.scale = self._similarity.scale
        self._rest: RBFInterpolator | None = None
        left = targets - points - self._similarity.displacement(points)
        if np.abs(left).max() > 10.0**-_ROUNDING:
            degree = 1 if self.trend == "affine" else 0
            self._rest = RBFInterpolator(
                points[:, self._axes], left, kernel="multiquadric", epsilon=1.0 / ROUNDED, degree=degree
            )

    def __call__(self, points: FloatArray) -> FloatArray:
        """(k, 3) m, where ``points`` (k, 3) go. Equal points go to equal bits, mirror images to mirror images."""
        side = np.where(points[:, 1] < 0.0, -1.0, 1.0) if self._symmetric else np.ones(len(points))
        here = points.copy()
        here[:, 1] *= side
        distinct, place = np.unique(here, axis=0, return_inverse=True)
        moved = self._displacement(distinct)
        if self._symmetric:
            moved[distinct[:, 1] <= _FLAT, 1] = 0.0
        moved = np.round(moved, _ROUNDING)[place.ravel()]
        moved[:, 1] *= side
        return np.asarray(points + moved)

    def gradient(self, points: FloatArray) -> FloatArray:
        """(k, 3, 3) derivatives of the map at ``points`` (k, 3), by central differences."""
        columns = []
        for axis in range(3):
            step = np.zeros(3)
            step[axis] = _STEP
            columns.append(self._displacement(points + step) - self._displacement(points - step))
        return np.eye(3) + np.stack(columns, axis=2) / (2.0 * _STEP)

    def _displacement(self, points: FloatArray) -> FloatArray:
        moved = self._similarity.displacement(points)
        return moved if self._rest is None else moved + self._rest(points[:, self._axes])


def best_similarity(points: FloatArray, targets: FloatArray) -> Similarity:
    """The similarity that takes ``points`` (n, 3) nearest to ``targets`` (n, 3) in the sum of squares.

    Lateral distances count for the scale. Points at a single x and z are only shifted.
    """
    a, b = points - points.mean(axis=0), targets - targets.mean(axis=0)
    p, q = a[:, 0] + 1j * a[:, 2], b[:, 0] + 1j * b[:, 2]
    overlap = complex((np.conj(p) * q).sum())
    if abs(overlap) == 0.0:
        return Similarity(1.0 + 0.0j, complex(*(targets - points).mean(axis=0)[_PLANE]))
    turn = overlap / abs(overlap)
    scale = (abs(overlap) + float(a[:, 1] @ b[:, 1])) / float((a**2).sum())
    factor = scale * turn
    centre, goal = (complex(*array.mean(axis=0)[_PLANE]) for array in (points, targets))
    return Similarity(factor, goal - factor * centre)


def similarity_amplification(points: FloatArray, reach: FloatArray) -> float:
    """Largest displacement anywhere in ``reach`` (k, 3) for errors of the targets of unit sum of squares."""
    centre = points.mean(axis=0)
    spread = float(((points - centre)[:, _PLANE] ** 2).sum())
    if spread == 0.0:
        return np.inf
    far = float(((reach - centre) ** 2).sum(axis=1).max())
    return float(np.sqrt(1.0 / len(points) + far / spread))


def affine_amplification(points: FloatArray, reach: FloatArray) -> float:
    """The same for an affine map through ``points`` (n, d); infinite where they do not determine one."""
    arms = points - points.mean(axis=0)
    lengths, axes = np.linalg.svd(arms, full_matrices=False)[1:]
    if len(lengths) < arms.shape[1] or len(points) <= arms.shape[1] or lengths[-1] < 1e-9 * lengths[0]:
        return np.inf
    along = (reach - points.mean(axis=0)) @ (axes.T / lengths)
    return float(np.sqrt(1.0 / len(points) + (along**2).sum(axis=1).max()))
