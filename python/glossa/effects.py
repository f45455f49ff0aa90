"""Parameters of the effects of a scene: tissue, damping, reflex, stiffening, gravity.

Values: Buchaillard, Perrier & Payan 2009, sections II.B to II.D.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from enum import Enum
from typing import Any, Literal

import numpy as np

from glossa.checks import finite_number, not_negative_number, one_of, positive_number, real_array
from glossa.errors import InputError

STANDARD_GRAVITY = 9.81
"""m/s2."""

FIRING_GRADIENT = 40.0
"""c of eq. 3, 1/m (II.C.2; 112 in the literature)."""


class Default(Enum):
    """Marks an argument that was left alone: the scene uses what the speaker has, and says so."""

    DEFAULT = "default"

    def __repr__(self) -> str:
        return "DEFAULT"


DEFAULT = Default.DEFAULT


@dataclass(frozen=True)
class Yeoh:
    """Second-order Yeoh tissue with a quadratic volumetric part.

    W = c10 (I - 3) + c20 (I - 3)^2 + kappa/2 (J - 1)^2, I = J^(-2/3) tr C, kappa from mu = 2 c10 and Poisson's ratio.

    Attributes:
        c10: Pa (1037 passive, 192 fresh cadaver).
        c20: Pa (486 passive, 90 fresh cadaver).
        poissons_ratio: of the tissue at small strain, below 0.5.
        density: kg/m3.
    """

    c10: float = 1037.0
    c20: float = 486.0
    _: KW_ONLY
    poissons_ratio: float = 0.499
    density: float = 1040.0

    def __post_init__(self) -> None:
        positive_number(self.c10, "tissue c10")
        not_negative_number(self.c20, "tissue c20")
        positive_number(self.density, "tissue density")
        ratio = finite_number(self.poissons_ratio, "Poisson's ratio")
        if not 0.0 <= ratio < 0.5:
            raise InputError(f"Poisson's ratio must be at least 0 and below 0.5, got {ratio!r}")

    @property
    def bulk_modulus(self) -> float:
        """Kappa = 2 mu (1 + nu) / (3 (1 - 2 nu)), Pa."""
        return 4.0 * self.c10 * (1.0 + self.poissons_ratio) / (3.0 * (1.0 - 2.0 * self.poissons_ratio))

    def about_as_stiff_as(self, other: Yeoh) -> bool:
        """Whether its stiffness is half to twice the other's, under small and under large shear (I = 4)."""
        pairs = ((self.c10, other.c10), (self.c10 + 2.0 * self.c20, other.c10 + 2.0 * other.c20))
        return all(0.5 <= one / two <= 2.0 for one, two in pairs)


@dataclass(frozen=True, kw_only=True)
class Reflex:
    """Stretch reflex of eq. 2: A(t) = [l(t - d) - lambda(t) + mu l'(t - d)]+.

    Attributes:
        delay: d, s (0.017 after Ito et al. 2004). 0 is allowed.
        velocity_gain: mu, s.
    """

    delay: float = 0.017
    velocity_gain: float = 0.01

    def __post_init__(self) -> None:
        not_negative_number(self.delay, "reflex delay")
        not_negative_number(self.velocity_gain, "reflex velocity gain")


@dataclass(frozen=True, kw_only=True)
class Damping:
    """Rayleigh damping C = alpha M + beta K of eq. 6; K is the tangent of the tissue, stiffened as eq. 1 says.

    The damping ratio alpha / (2 omega) + beta omega / 2 is 1.34 at 3 Hz and 1.26 at 10 Hz.

    Attributes:
        alpha: 1/s.
        beta: s.
        law: which part of K damps. ``"material"``: the part that comes from the material, acting on the rate of
            deformation; a Kelvin-Voigt tissue, whose damping always takes energy. ``"tangent"``: all of it, the
            stress stiffness included. Where strong compression makes K indefinite this feeds energy, and the movement
            of a tongue pressed against its walls blows up; for comparison with other solvers.
    """

    alpha: float = 40.0
    beta: float = 0.03
    law: Literal["material", "tangent"] = "material"

    def __post_init__(self) -> None:
        not_negative_number(self.alpha, "damping alpha")
        not_negative_number(self.beta, "damping beta")
        one_of(self.law, ("material", "tangent"), "damping law")


@dataclass(frozen=True, kw_only=True)
class Stiffening:
    """Activation-dependent stiffness of eq. 1.

    The paper gives no p1. The rule: an element passed by a muscle's usual number of fibres, all saturated, becomes
    ``peak_multiplier`` times as stiff as passive tissue.

    Attributes:
        peak_multiplier: of a saturated element of one muscle, at least 1; None: each muscle's own
            (``Muscle.peak_multiplier``: 10, the maximal law of fig. 3, unless the speaker says otherwise).
        gains: p1 in 1/m for muscles that do not follow the rule.
    """

    peak_multiplier: float | None = None
    gains: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.peak_multiplier is not None and finite_number(self.peak_multiplier, "peak multiplier") < 1.0:
            raise InputError(f"peak multiplier must be at least 1, got {self.peak_multiplier!r}")
        if not isinstance(self.gains, Mapping):
            raise InputError(f"stiffening gains must map muscles to numbers, got {self.gains!r}")
        for muscle, gain in self.gains.items():
            not_negative_number(gain, f"stiffening gain of {muscle!r}")


GravityName = Literal["upright", "supine"]


def gravity_vector(gravity: Any) -> tuple[float, float, float] | None:
    """Field of gravity in m/s2: "upright" is -z, "supine" towards the back of the head, +x; None: no gravity.

    Raises:
        InputError: another name, or not three finite numbers.
    """
    if gravity is None:
        return None
    if isinstance(gravity, str):
        if gravity == "upright":
            return (0.0, 0.0, -STANDARD_GRAVITY)
        if gravity == "supine":
            return (STANDARD_GRAVITY, 0.0, 0.0)
        raise InputError(f"gravity must be 'upright', 'supine', None or three numbers in m/s2, got {gravity!r}")
    vector = real_array(gravity, "gravity must be 'upright', 'supine', None or three numbers in m/s2")
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise InputError(f"gravity must be three finite numbers in m/s2, got {gravity!r}")
    x, y, z = vector.tolist()
    return None if math.hypot(x, y, z) == 0.0 else (x, y, z)
