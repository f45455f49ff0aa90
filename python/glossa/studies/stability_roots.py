"""Rightmost roots of the characteristic equation of the whole linearised body, by Newton's method.

    T(s) x = [ s^2 M + s C + K + exp(-s d) (1 + mu s) B G' ] x = 0

is kept sparse by the activations a = exp(-s d) (1 + mu s) G' x as further unknowns, and solved by inverse iteration for
nonlinear eigenproblems (Neumaier 1985, SIAM J. Numer. Anal. 22:914; Guettel & Tisseur 2017, Acta Numerica 26:1):
(x, a) <- A(s)^-1 A'(s) (x, a), s <- s - 1 / growth, which converges quadratically. It starts from the spectrum of the
reduced loop (stability_generator.py).
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla

from glossa.checks import not_negative_number, whole_number
from glossa.linear_motion import ComplexArray, LinearMotion
from glossa.studies.stability_basis import ReducedMotion
from glossa.studies.stability_generator import POINTS, spectrum

CONVERGED = 1e-10
"""Backward error of a root: |T x| over the sum of the sizes of its terms."""

SEEN = 1.5 * POINTS
"""Modulus times delay up to which eigenvalues of the generator are near roots."""

_STEPS = 30
_SPARE = 2  # starts beyond the roots that are wanted
_SAME = 1e-6  # relative distance of roots that are one


@dataclass(frozen=True, eq=False)
class Root:
    """A root and its shape.

    Attributes:
        value: s, 1/s: growth rate and angular frequency.
        shape: (u,) displacements of the unknowns, of unit size.
        activations: (f,) m, that go with it.
        residual: backward error, |T x| over the sum of the sizes of its terms.
    """

    value: complex
    shape: ComplexArray
    activations: ComplexArray
    residual: float

    @property
    def converged(self) -> bool:
        """Whether the backward error is that of a root."""
        return self.residual <= CONVERGED

    @property
    def frequency(self) -> float:
        """Hz."""
        return abs(self.value.imag) / (2.0 * np.pi)


def delayed_gain(s: complex, delay: float, velocity_gain: float) -> tuple[complex, complex]:
    """exp(-s d) (1 + mu s), and its derivative."""
    past = cmath.exp(-s * delay)
    value = past * (1.0 + velocity_gain * s)
    return value, velocity_gain * past - delay * value


def rightmost_roots(
    motion: LinearMotion, reduced: ReducedMotion, delay: float, velocity_gain: float, count: int
) -> list[Root]:
    """The rightmost roots with frequency zero or positive, rightmost first; complex ones have a conjugate, too.

    Args:
        motion: of an equilibrium.
        reduced: the same in a reduced basis.
        delay: d, s.
        velocity_gain: mu, s.
        count: roots wanted; fewer come where fewer converge.

    Raises:
        InputError: a negative delay or gain, or no root wanted.
    """
    not_negative_number(delay, "delay (s)")
    not_negative_number(velocity_gain, "velocity gain (s)")
    wanted = whole_number(count, "roots", 1, 1000)
    values, shapes = spectrum(reduced, delay, velocity_gain)
    starts = np.flatnonzero((values.imag >= 0.0) & (np.abs(values) * delay <= SEEN))[: wanted + _SPARE]
    found: list[Root] = []
    for k in starts.tolist():
        root = newton_root(motion, values[k], reduced.basis @ shapes[:, k], delay, velocity_gain)
        if root.converged and all(abs(root.value - one.value) > _SAME * (1.0 + abs(root.value)) for one in found):
            found.append(root)
    return sorted(found, key=lambda one: -one.value.real)[:wanted]


def newton_root(motion: LinearMotion, start: complex, shape: ComplexArray, delay: float, velocity_gain: float) -> Root:
    """The root near an approximate one.

    Args:
        motion: of an equilibrium.
        start: approximate root, 1/s.
        shape: (u,) approximate displacements.
        delay: d, s.
        velocity_gain: mu, s.

    Returns:
        The root; its residual tells whether the iteration has converged.
    """
    pulls, gradients = sp.csc_array(motion.pulls), sp.csc_array(motion.gradients)
    s, x = complex(start), shape / np.linalg.norm(shape)
    best = _root(motion, s, x, delay, velocity_gain)
    for _ in range(_STEPS):
        if best.residual <= CONVERGED:
            break
        gain, gain_slope = delayed_gain(s, delay, velocity_gain)
        lengths = motion.gradients.T @ x
        matrix = sp.block_array([[motion.held(s), pulls], [gain * gradients.T, -sp.eye_array(pulls.shape[1])]])
        right = np.concatenate([2.0 * s * (motion.mass @ x) + motion.damping @ x, gain_slope * lengths])
        try:
            factor = sla.splu(matrix.tocsc(), diag_pivot_thresh=0.01, options={"SymmetricMode": True})
            solution = factor.solve(right)[: motion.size]
        except RuntimeError:  # exactly singular: this is the root
            break
        s -= complex(np.vdot(x, x) / np.vdot(x, solution))
        x = solution / np.linalg.norm(solution)
        if not np.isfinite(x).all() or not cmath.isfinite(s) or abs(s.real * delay) > 100.0:
            break
        found = _root(motion, s, x, delay, velocity_gain)
        best = found
    return best


def _root(motion: LinearMotion, s: complex, x: ComplexArray, delay: float, velocity_gain: float) -> Root:
    gain, _ = delayed_gain(s, delay, velocity_gain)
    activations = gain * (motion.gradients.T @ x)
    terms: list[Any] = [s * s * (motion.mass @ x), s * (motion.damping @ x), motion.stiffness @ x]
    terms.append(motion.pulls @ activations)
    size = sum(float(np.linalg.norm(term)) for term in terms)
    residual = float(np.linalg.norm(sum(terms)))
    return Root(value=s, shape=x, activations=activations, residual=residual / size)
