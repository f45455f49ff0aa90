"""A reduced basis for the linearised reflex loop: slow modes, and what the active fibres do to the body.

Inertia is small beside damping, so that slow free movements creep: they are the lowest eigenvectors of (K, C). The loop
acts through the pulls of the fibres, which hundreds of modes of (K, C) or (K, M) represent badly. The responses
(K + s C + s^2 M)^-1 B at a few real s join them: the reduced transfer function from activations to lengths is then
exact at these s (moments matched; Grimme 1997, Krylov projection methods for model reduction). Of the responses the
combinations of most energy are kept. Projection by one basis from both sides keeps M, C and K symmetric and positive.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse.linalg as sla

from glossa.anatomy.arrays import FloatArray
from glossa.checks import whole_number
from glossa.linear_motion import LinearMotion

MODES = 20
"""Lowest eigenvectors of (K, C) in the basis."""

RESPONSES = 100
"""Combinations of responses in the basis, at most."""

SHIFTS = (100.0, 1000.0)
"""s at which responses are taken, 1/s: the loop's own pace, and its harmonics'."""

_NEGLIGIBLE = 1e-14  # of the largest energy of a combination of responses
_DEPENDENT = 1e-10  # of a basis vector's own size


@dataclass(frozen=True, eq=False)
class ReducedMotion:
    """The matrices of :class:`LinearMotion` in a basis of r vectors with unit mass; f fibres.

    Attributes:
        basis: (u, r).
        damping: (r, r), 1/s.
        stiffness: (r, r), 1/s2.
        pulls: (r, f).
        gradients: (r, f).
    """

    basis: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    pulls: FloatArray
    gradients: FloatArray

    @property
    def size(self) -> int:
        """Number of basis vectors."""
        return len(self.stiffness)


def reduced_motion(motion: LinearMotion, modes: int = MODES, responses: int = RESPONSES) -> ReducedMotion:
    """Galerkin projection of the equation of motion.

    Args:
        motion: of an equilibrium.
        modes: lowest eigenvectors of (K, C).
        responses: combinations of responses of most energy.

    Raises:
        InputError: not whole numbers, or none of both.
    """
    own = min(whole_number(modes, "modes", 0, 10_000), motion.size)
    most = whole_number(responses, "responses", 0, 10_000)
    if own + most >= motion.size:
        basis = np.eye(motion.size)
    else:
        basis = np.hstack([_modes(motion, own), _responses(motion, most)])
    basis = _of_unit_mass(basis, motion)
    return ReducedMotion(
        basis=basis,
        damping=basis.T @ (motion.damping @ basis),
        stiffness=basis.T @ (motion.stiffness @ basis),
        pulls=basis.T @ motion.pulls,
        gradients=basis.T @ motion.gradients,
    )


def _modes(motion: LinearMotion, count: int) -> FloatArray:
    if count == 0:
        return np.zeros((motion.size, 0))
    start = np.ones(motion.size)  # the same basis every time
    return np.asarray(sla.eigsh(motion.stiffness, k=count, M=motion.damping, sigma=0.0, v0=start)[1])


def _responses(motion: LinearMotion, count: int) -> FloatArray:
    if count == 0 or not motion.pulls.shape[1]:
        return np.zeros((motion.size, 0))
    found = np.hstack([np.asarray(sla.splu(motion.held(s).real).solve(motion.pulls)) for s in SHIFTS])
    energy, combinations = la.eigh(found.T @ (motion.stiffness @ found))
    kept = np.flatnonzero(energy > _NEGLIGIBLE * energy[-1])[::-1][:count]
    return np.asarray(found @ (combinations[:, kept] / np.sqrt(energy[kept])))


def _of_unit_mass(basis: FloatArray, motion: LinearMotion) -> FloatArray:
    """Combinations of the vectors that are orthonormal in mass, without those that depend on others."""
    masses = np.sqrt(np.einsum("ui,ui->i", basis, motion.mass @ basis))
    basis = basis / masses
    values, vectors = la.eigh(basis.T @ (motion.mass @ basis))
    kept = values > _DEPENDENT
    return np.asarray(basis @ (vectors[:, kept] / np.sqrt(values[kept])))
