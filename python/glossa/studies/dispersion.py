"""Dispersion ellipses of points in a plane: where k standard deviations of a normal law with their covariance end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from glossa.anatomy.arrays import FloatArray
from glossa.checks import positive_number
from glossa.errors import InputError

SIGMAS = 3.0
"""k of the paper (section IV.B, fig. 11)."""

_FLAT = 1e-9
"""Minor over major axis under which samples count as lying on one line: rounding of their coordinates."""


@dataclass(frozen=True, kw_only=True)
class Ellipse:
    """A dispersion ellipse; lengths in the unit of the samples.

    Attributes:
        centre: (2,) mean of the samples.
        semi_major: k standard deviations along the direction of most variance.
        semi_minor: the same across it.
        angle: of the major axis to the first axis, degrees in [0, 180), counterclockwise. With x backward and z upward
            (tongue tip on the left, as in fig. 11), more than 90 degrees means that forward goes with upward.
        sigmas: k.
        samples: their number.
        inside: share of the samples inside or on the ellipse.
    """

    centre: FloatArray
    semi_major: float
    semi_minor: float
    angle: float
    sigmas: float
    samples: int
    inside: float

    @property
    def major(self) -> float:
        """Full length of the major axis."""
        return 2.0 * self.semi_major

    @property
    def minor(self) -> float:
        """Full length of the minor axis."""
        return 2.0 * self.semi_minor

    @property
    def coverage(self) -> float:
        """Share of a two-dimensional normal law inside: 1 - exp(-k^2/2), 98.9 % for k = 3 (99.7 % is one dimension's).

        For the law's own mean and covariance; those of few samples cover less on average.
        """
        return coverage(self.sigmas)

    def outline(self, count: int = 121) -> FloatArray:
        """(count, 2) points of the ellipse, the last equal to the first."""
        turn = np.linspace(0.0, 2.0 * math.pi, count)
        across = self._direction[::-1] * [-1.0, 1.0]
        along = self.semi_major * np.cos(turn)[:, None] * self._direction
        return np.asarray(self.centre + along + self.semi_minor * np.sin(turn)[:, None] * across)

    def major_axis(self) -> FloatArray:
        """(2, 2) its two ends."""
        return np.stack(
            [self.centre - self.semi_major * self._direction, self.centre + self.semi_major * self._direction]
        )

    @property
    def _direction(self) -> FloatArray:
        radians = math.radians(self.angle)
        return np.array([math.cos(radians), math.sin(radians)])


def coverage(sigmas: float) -> float:
    """Share of a two-dimensional normal law within ``sigmas`` standard deviations.

    Raises:
        InputError: not a positive number.
    """
    return -math.expm1(-0.5 * positive_number(sigmas, "sigmas") ** 2)


def dispersion_ellipse(samples: ArrayLike, sigmas: float = SIGMAS) -> Ellipse:
    """The ellipse of ``sigmas`` standard deviations of points in a plane.

    Args:
        samples: (n, 2), n at least 3; the covariance is the unbiased one (divisor n - 1).
        sigmas: k.

    Raises:
        InputError: fewer than three samples, a wrong shape, values that are not finite, or samples on one line (or in
            one point), whose ellipse has no area.
    """
    k = positive_number(sigmas, "sigmas")
    points = _points(samples)
    centre = points.mean(axis=0)
    # singular values rather than the eigenvalues of the covariance: exact down to very flat clouds
    _, spreads, axes = np.linalg.svd((points - centre) / math.sqrt(len(points) - 1), full_matrices=False)
    size = max(float(np.abs(points).max()) * np.finfo(float).eps, np.finfo(float).tiny)
    if spreads[0] <= 8.0 * size:
        raise InputError("a dispersion ellipse needs samples that differ; all lie in one point")
    if spreads[1] <= max(_FLAT * spreads[0], 8.0 * size):
        raise InputError("a dispersion ellipse needs samples that spread in two directions; all lie on one line")
    angle = math.degrees(math.atan2(axes[0, 1], axes[0, 0])) % 180.0
    inside = (((points - centre) @ axes.T / spreads) ** 2).sum(axis=1) <= k**2 * (1.0 + 1e-12)
    return Ellipse(
        centre=centre,
        semi_major=k * float(spreads[0]),
        semi_minor=k * float(spreads[1]),
        angle=0.0 if angle == 180.0 else angle,
        sigmas=k,
        samples=len(points),
        inside=float(inside.mean()),
    )


def angle_between(first: float, second: float) -> float:
    """Between two directions without sense, degrees, from 0 to 90."""
    apart = abs(first - second) % 180.0
    return min(apart, 180.0 - apart)


def _points(samples: Any) -> FloatArray:
    try:
        points = np.asarray(samples, dtype=float)
    except (TypeError, ValueError):
        raise InputError("samples must be an array of numbers of shape (n, 2)") from None
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"samples must have shape (n, 2), got {points.shape}")
    if len(points) < 3:
        raise InputError(f"a dispersion ellipse needs at least 3 samples, got {len(points)}")
    if not np.isfinite(points).all():
        row = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise InputError(f"samples must be finite; sample {row} is {points[row].tolist()}")
    return points
