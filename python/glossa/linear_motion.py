"""Small movements of a scene about an equilibrium: matrices of its linearised equation of motion.

With q the unknowns of the body, counted from the equilibrium, and the reflex of eq. 2,

    M q'' + C q' + K q + B G' [q(t - d) + mu q'(t - d)] = 0,

M mass, C damping (Rayleigh's, and the force-velocity slope of eq. 5), K the tangent with activations held, G the
derivatives of the lengths of the active fibres, B those of the forces with respect to their activations, by tension
(eq. 3) and stiffening (eq. 1). Points that touch a wall stick to it. Derived in cpp/scene/linear_motion.hpp.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from glossa import _core
from glossa.anatomy.arrays import FloatArray
from glossa.effects import Reflex

ComplexArray: TypeAlias = NDArray[np.complex128]

_RATE = 30.0  # 1/s, about 1 / beta: K and rate C are of one size
_ACCELERATION = 1e6  # 1/s2: K and acceleration M are


@dataclass(frozen=True, eq=False)
class LinearMotion:
    """The matrices; u unknowns, f fibres of the body that are active.

    Attributes:
        mass: (u, u) sparse, kg.
        damping: (u, u) sparse, N s/m.
        stiffness: (u, u) sparse, N/m.
        pulls: (u, f) B, N/m.
        gradients: (u, f) G.
        delay: d, s; 0 where the reflex has none.
        velocity_gain: mu, s.
        activations: (f,) in the equilibrium, m.
        muscles: name of each fibre's muscle.
        nodes_of: makes of a vector of unknowns a field (n, 3) on the speaker's nodes, to first order.
    """

    mass: Any
    damping: Any
    stiffness: Any
    pulls: FloatArray
    gradients: FloatArray
    delay: float
    velocity_gain: float
    activations: FloatArray
    muscles: tuple[str, ...]
    nodes_of: Callable[[FloatArray], FloatArray]

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.pulls)

    def held(self, s: complex) -> Any:
        """s^2 M + s C + K, sparse: the dynamic stiffness with activations held."""
        return (s * s * self.mass + s * self.damping + self.stiffness).tocsc()


def linear_motion(
    core: _core.LinearMotion,
    reflex: Reflex | None,
    *,
    muscles: Sequence[str],
    nodes_of: Callable[[FloatArray], FloatArray],
) -> LinearMotion:
    """The matrices of a core's linearisation.

    Args:
        core: of the scene's solver.
        reflex: of the scene; None: no delay and no velocity gain.
        muscles: name of the muscle of each active fibre.
        nodes_of: from a node field (k, 3) of the body to one of the speaker.
    """
    stiffness = _symmetric(core, 0.0, 0.0)
    damping = (_symmetric(core, _RATE, 0.0) - stiffness) / _RATE
    mass = (_symmetric(core, 0.0, _ACCELERATION) - stiffness) / _ACCELERATION

    return LinearMotion(
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        pulls=np.ascontiguousarray(core.pulls().T),
        gradients=np.ascontiguousarray(core.gradients().T),
        delay=0.0 if reflex is None else reflex.delay,
        velocity_gain=0.0 if reflex is None else reflex.velocity_gain,
        activations=core.activation,
        muscles=tuple(muscles),
        nodes_of=lambda values: nodes_of(core.spread(values)),
    )


def _symmetric(core: _core.LinearMotion, rate: float, acceleration: float) -> Any:
    start, row, value = core.matrix(rate, acceleration)
    count = len(start) - 1
    lower = sp.csc_array((value, row, start), shape=(count, count))
    return (lower + sp.tril(lower, -1).T).tocsc()
