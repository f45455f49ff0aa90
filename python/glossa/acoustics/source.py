"""The voice source: derivative of the glottal flow, pulse by pulse.

Each pulse is given over one period, from 0 to 1, scaled to a largest negative excitation of 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from glossa.checks import finite_number
from glossa.errors import InputError

Real = NDArray[np.float64]

RD_RANGE = (0.3, 2.7)


@dataclass(frozen=True, kw_only=True)
class LF:
    """Pulse of Fant, Liljencrants & Lin (1985), STL-QPSR 26(4), 1-13, with the shape of Fant (1995).

    E(t) = E₀ e^{αt} sin(πt/t_p) up to the main excitation t_e, then an exponential return with time constant t_a; α
    makes the flow end at zero.

    Attributes:
        rd: Rd of Fant (1995), STL-QPSR 36(2-3), 119-156: 0.3 is pressed, 0.7 to 1 modal, 2.7 breathy.
    """

    rd: float = 0.8

    def __post_init__(self) -> None:
        low, high = RD_RANGE
        if not low <= finite_number(self.rd, "rd") <= high:
            raise InputError(f"rd must be from {low} (pressed) to {high} (breathy), got {self.rd!r}")

    def pulse(self, phase: Real, softness: float = 0.0) -> Real:
        """Flow derivative at parts of the period; softness from 0 to 1 adds up to 1 to Rd, for onset and offset."""
        rd = min(self.rd + softness, RD_RANGE[1])
        te, tp, ta, alpha, epsilon = _lf_parameters(round(rd, 2))
        rate = math.pi / tp
        opening = -np.exp(alpha * (np.minimum(phase, te) - te)) * np.sin(rate * phase) / math.sin(rate * te)
        tail = math.exp(-epsilon * (1.0 - te))
        closing = -(np.exp(-epsilon * np.maximum(phase - te, 0.0)) - tail) / (epsilon * ta)
        return np.where(phase <= te, opening, closing)


@dataclass(frozen=True, kw_only=True)
class Rosenberg:
    """Trigonometric pulse of Rosenberg (1971), J. Acoust. Soc. Am. 49, 583-590, type C.

    Attributes:
        open_quotient: part of the period with flow.
        speed_quotient: duration of opening over that of closing.
    """

    open_quotient: float = 0.6
    speed_quotient: float = 2.0

    def __post_init__(self) -> None:
        if not 0.1 <= finite_number(self.open_quotient, "open_quotient") <= 1.0:
            raise InputError(f"open_quotient must be from 0.1 to 1, got {self.open_quotient!r}")
        if not 0.2 <= finite_number(self.speed_quotient, "speed_quotient") <= 10.0:
            raise InputError(f"speed_quotient must be from 0.2 to 10, got {self.speed_quotient!r}")

    def pulse(self, phase: Real, softness: float = 0.0) -> Real:
        """Flow derivative at parts of the period; softness lengthens the open phase by up to a quarter."""
        opened = min(self.open_quotient * (1.0 + 0.25 * softness), 1.0)
        rise = opened * self.speed_quotient / (1.0 + self.speed_quotient)
        fall = opened - rise
        rising = 0.5 * math.pi / rise * np.sin(math.pi * phase / rise)
        falling = -0.5 * math.pi / fall * np.sin(0.5 * math.pi * (phase - rise) / fall)
        flow = np.where(phase < rise, rising, np.where(phase < opened, falling, 0.0))
        return flow * (fall / (0.5 * math.pi))


Source = LF | Rosenberg


def voice_source(choice: str | Source) -> Source:
    """A source by name, with its default shape, or the object itself.

    Raises:
        InputError: neither.
    """
    if isinstance(choice, LF | Rosenberg):
        return choice
    if isinstance(choice, str) and choice in ("lf", "rosenberg"):
        return LF() if choice == "lf" else Rosenberg()
    raise InputError(f"source must be 'lf', 'rosenberg' or an object LF(...) or Rosenberg(...), got {choice!r}")


@lru_cache(maxsize=512)
def _lf_parameters(rd: float) -> tuple[float, float, float, float, float]:
    """t_e, t_p, t_a, α and ε for a period of 1 (Fant 1995, eqs 2 to 4)."""
    from scipy.optimize import brentq

    ra = (-1.0 + 4.8 * rd) / 100.0
    rk = (22.4 + 11.8 * rd) / 100.0
    rg = 0.25 * rk * (0.5 + 1.2 * rk) / (0.11 * rd - ra * (0.5 + 1.2 * rk))
    tp = 0.5 / rg
    te = tp * (1.0 + rk)
    rest = 1.0 - te
    ta = min(ra, 0.9 * rest)
    epsilon = float(brentq(lambda e: e * ta - 1.0 + math.exp(-e * rest), 1e-6 + 1e-3 / ta, 2.0 / ta))
    tail = math.exp(-epsilon * rest)
    returned = -((1.0 - tail) / epsilon - rest * tail) / (epsilon * ta)
    rate = math.pi / tp
    sine, cosine = math.sin(rate * te), math.cos(rate * te)

    def net_flow(alpha: float) -> float:
        opened = (alpha * sine - rate * cosine + rate * math.exp(-alpha * te)) / (alpha**2 + rate**2)
        return -opened / sine + returned

    alpha = float(brentq(net_flow, -50.0, 200.0))
    return te, tp, ta, alpha, epsilon
