"""Loci of the loop gain: how many roots are unstable, counted, and the delay up to which none is.

With activations held the body is stable, so that the roots of
    det T(s) / det Z(s) = Prod_j [ 1 + exp(-s d) (1 + mu s) h_j(s) ],   h_j: eigenvalues of G' Z(s)^-1 B,
in the right half plane are the turns of the loci exp(-i w d) (1 + i w mu) h_j(i w) about -1 (generalised Nyquist
criterion; MacFarlane & Postlethwaite 1977, Int. J. Control 25:81). The h_j need the whole body once for each frequency
and serve every delay and velocity gain.

Damping by far outweighs inertia up to some kHz: (1 + i w mu) h_j stays near mu times the eigenvalues of G' C^-1 B, and
the equation behaves like a neutral one, with a chain of roots 1/d apart in frequency and of growth ln(gain) / d. Only
inertia ends it. A discretisation in time sees what its steps resolve of such a chain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse.linalg as sla
from scipy.interpolate import PchipInterpolator
from scipy.optimize import linear_sum_assignment

from glossa.anatomy.arrays import FloatArray
from glossa.linear_motion import ComplexArray, LinearMotion

FREQUENCIES = tuple(np.geomspace(0.05, 5e4, 72).tolist())
"""Hz, at which the whole body is solved: far below the slowest creep and far above where inertia ends the loop."""

_FINE = 24  # samples for each radian of the delay's phase
_LOG_FINE = 200  # and for each power of e in frequency


@dataclass(frozen=True, eq=False)
class LoopLoci:
    """Eigenvalues of G' Z(i w)^-1 B, tracked over frequency.

    Attributes:
        frequencies: (w,) Hz, rising.
        values: (w, f), m/m: lengthening of the fibres per activation held, in each combination.
    """

    frequencies: FloatArray
    values: ComplexArray

    def gains(self, velocity_gain: float) -> ComplexArray:
        """(w, f) loop gains without delay, (1 + i w mu) h."""
        return np.asarray((1.0 + 2j * np.pi * self.frequencies[:, None] * velocity_gain) * self.values)

    def largest_gain(self, velocity_gain: float, above: float = 0.0) -> float:
        """Largest modulus of a loop gain at frequencies above one (Hz)."""
        return float(np.abs(self.gains(velocity_gain)[self.frequencies >= above]).max(initial=0.0))


def loop_loci(motion: LinearMotion, frequencies: Sequence[float] = FREQUENCIES) -> LoopLoci:
    """The loci of a linearised motion, of the whole body."""
    places = np.array(frequencies, dtype=float)
    values = np.empty((len(places), motion.pulls.shape[1]), dtype=complex)
    pulls = motion.pulls.astype(complex)
    for k, frequency in enumerate(places):
        factor = sla.splu(
            motion.held(2j * np.pi * frequency),
            permc_spec="MMD_AT_PLUS_A",  # of a symmetric matrix, whose diagonal is safe to pivot on
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        lengths = motion.gradients.T @ factor.solve(pulls)
        found = np.linalg.eigvals(lengths)
        if k:
            found = found[linear_sum_assignment(np.abs(values[k - 1][:, None] - found[None, :]))[1]]
        values[k] = found
    return LoopLoci(places, values)


def unstable_roots(loci: LoopLoci, delay: float, velocity_gain: float) -> int | None:
    """Number of roots with positive growth, both of a complex pair; None where the loop gain has not died out.

    That is so where inertia has not brought it below 1 at the highest frequency of the loci.
    """
    gains = loci.gains(velocity_gain)
    if np.abs(gains[-1]).max(initial=0.0) >= 1.0:
        return None
    able = np.abs(gains).max(axis=0, initial=0.0) >= 1.0
    if not able.any():
        return 0
    logs = np.log(loci.frequencies)
    last = loci.frequencies[np.flatnonzero(np.abs(gains).max(axis=1) >= 1.0)[-1]]
    top = logs[min(np.searchsorted(loci.frequencies, last, side="right"), len(logs) - 1)]
    fine = _samples(loci.frequencies[0], math.exp(top), delay)
    found = PchipInterpolator(logs, gains[:, able].real)(np.log(fine)) + 1j * PchipInterpolator(
        logs, gains[:, able].imag
    )(np.log(fine))
    turned = np.unwrap(np.angle(1.0 + np.exp(-2j * np.pi * fine * delay)[:, None] * found), axis=0)
    # At frequency zero the product of all is real; a gain below 1 at the top closes without another turn.
    return round(float(np.round(turned[0] / np.pi).sum() - 2.0 * np.round(turned[-1] / (2.0 * np.pi)).sum()))


def _samples(low: float, high: float, delay: float) -> FloatArray:
    """Frequencies that resolve both the loci (evenly in their logarithm) and the phase of the delay."""
    by_log = np.exp(np.linspace(math.log(low), math.log(high), int(_LOG_FINE * math.log(high / low)) + 2))
    by_phase = np.linspace(low, high, int(_FINE * 2.0 * np.pi * high * delay) + 2)
    return np.unique(np.concatenate([by_log, by_phase]))


def delay_margin(loci: LoopLoci, velocity_gain: float) -> float:
    """Delay (s) up to which no root is unstable: the least at which a locus passes through -1; inf: never, 0: always.

    There |(1 + i w mu) h| = 1, and the delay turns it to -1. A gain that is still above 1 at the highest frequency
    counts as if it were 1 there.
    """
    if unstable_roots(loci, 0.0, velocity_gain):
        return 0.0
    gains = loci.gains(velocity_gain)
    logs = np.log(loci.frequencies)
    fine = np.linspace(logs[0], logs[-1], 40 * len(logs))
    smooth = PchipInterpolator(logs, gains.real)(fine) + 1j * PchipInterpolator(logs, gains.imag)(fine)
    size = np.abs(smooth)
    step, locus = np.nonzero((size[:-1] - 1.0) * (size[1:] - 1.0) < 0.0)
    share = (1.0 - size[step, locus]) / (size[step + 1, locus] - size[step, locus])
    left = smooth[-1, size[-1] >= 1.0]
    there = np.concatenate([(1.0 - share) * smooth[step, locus] + share * smooth[step + 1, locus], left])
    omega = 2.0 * np.pi * np.exp((1.0 - share) * fine[step] + share * fine[step + 1])
    omega = np.concatenate([omega, np.full(len(left), 2.0 * np.pi * loci.frequencies[-1])])
    return float((np.mod(np.angle(there) + np.pi, 2.0 * np.pi) / omega).min(initial=math.inf))
