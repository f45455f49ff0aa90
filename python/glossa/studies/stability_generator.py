"""Rightmost roots of the delayed loop in a reduced basis: the infinitesimal generator, discretised pseudospectrally.

The state of a delay equation is its past. On the Chebyshev points of [-d, 0] the generator of its semigroup becomes a
matrix whose eigenvalues converge to the rightmost roots of the characteristic equation faster than any power of the
number of points (Breda, Maset & Vermiglio 2005, SIAM J. Sci. Comput. 27:482; 2015, Stability of Linear Delay
Differential Equations, chapter 5). Here the past acts through the lengths of the fibres alone, and of these through few
combinations y = G' (x + mu x'), so that only the past of y is kept:

    x' = v,   v' = - C v - K x - B y(-d),   dy/dt = dy/dtheta on (-d, 0),   y(0) = G' (x + mu v).

Roots up to about 1.5 points / d in modulus are seen; those of higher frequency are not (stability_loci.py).
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as la

from glossa.anatomy.arrays import FloatArray
from glossa.linear_motion import ComplexArray
from glossa.studies.stability_basis import ReducedMotion

POINTS = 20
"""Intervals of the delay."""

LEAST_GAIN = 5e-2
"""Combinations of fibres whose loop gain at PACE is less play no part; of the largest gain where that is above 1."""

PACE = 100.0
"""1/s."""


def spectrum(
    motion: ReducedMotion, delay: float, velocity_gain: float, points: int = POINTS, least_gain: float = LEAST_GAIN
) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues of the discretised generator, rightmost first, and their shapes.

    Args:
        motion: in a reduced basis, r vectors.
        delay: d, s; 0: none.
        velocity_gain: mu, s.
        points: intervals of the delay.
        least_gain: of combinations of fibres that are kept.

    Returns:
        (k,) roots, 1/s, and (r, k) displacements.
    """
    pulls, gradients = channels(motion, least_gain)
    r, y = motion.size, pulls.shape[1]
    x_now, v_now = gradients.T, velocity_gain * gradients.T
    delayed = delay > 0.0 and y > 0
    past = y * points if delayed else 0
    generator = np.zeros((2 * r + past, 2 * r + past))
    generator[:r, r : 2 * r] = np.eye(r)
    generator[r : 2 * r, :r] = -motion.stiffness
    generator[r : 2 * r, r : 2 * r] = -motion.damping
    if delayed:
        slope = chebyshev_slope(points) * (2.0 / delay)
        generator[r : 2 * r, -y:] = -pulls
        generator[2 * r :, :r] = np.kron(slope[1:, :1], x_now)
        generator[2 * r :, r : 2 * r] = np.kron(slope[1:, :1], v_now)
        generator[2 * r :, 2 * r :] = np.kron(slope[1:, 1:], np.eye(y))
    else:
        generator[r : 2 * r, :r] -= pulls @ x_now
        generator[r : 2 * r, r : 2 * r] -= pulls @ v_now
    roots, vectors = la.eig(generator)
    order = np.argsort(-roots.real)
    return roots[order], vectors[:r, order]


def channels(motion: ReducedMotion, least_gain: float) -> tuple[FloatArray, FloatArray]:
    """Pulls (r, y) and gradients (r, y) of the combinations of fibres that matter: B G' by singular values.

    They are measured in the dynamic stiffness at the pace of reference: a singular value is a loop gain.
    """
    root = la.cholesky(np.eye(motion.size) * PACE**2 + PACE * motion.damping + motion.stiffness, lower=True)
    own_pulls, pull_factor = la.qr(la.solve_triangular(root, motion.pulls, lower=True), mode="economic")
    own_gradients, gradient_factor = la.qr(la.solve_triangular(root, motion.gradients, lower=True), mode="economic")
    left, gains, right = la.svd(pull_factor @ gradient_factor.T)
    kept = gains > least_gain * max(1.0, float(gains.max(initial=0.0)))
    return root @ own_pulls @ (left[:, kept] * gains[kept]), root @ own_gradients @ right[kept].T


def chebyshev_slope(points: int) -> FloatArray:
    """(n + 1, n + 1) derivative at the Chebyshev points cos(k pi / n) of the interpolating polynomial.

    Trefethen 2000, Spectral Methods in MATLAB, chapter 6.
    """
    place = np.cos(np.pi * np.arange(points + 1) / points)
    weight = np.ones(points + 1)
    weight[[0, -1]] = 2.0
    weight *= (-1.0) ** np.arange(points + 1)
    gap = place[:, None] - place[None, :]
    slope = np.outer(weight, 1.0 / weight) / (gap + np.eye(points + 1))
    return np.asarray(slope - np.diag(slope.sum(axis=1)))
