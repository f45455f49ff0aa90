"""Complex poles of many tracts at once, counted by the argument principle.

The function ratio D is sampled once around the region of every tract. Its turns say how many poles are inside; its
minima along the lower edge start Newton's method, the poles held apart from each other (Ehrlich & Aberth); poles missed
then are started from the power sums that the same samples give. Where the numbers still differ, the region is cut in
pieces until each holds one pole. A tract whose poles cannot all be found is reported, never guessed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glossa.acoustics.bisection import poles_by_bisection
from glossa.acoustics.constants import Complex, TubeConstants
from glossa.acoustics.contour import Count, count_zeros
from glossa.acoustics.region import Region
from glossa.acoustics.transmission_line import Real, flow_ratio, flow_ratio_slope

TWO_PI = 2.0 * np.pi
TOLERANCE = 1e-10
ITERATIONS = 30
SAME = 1e-5
"""Hz below which two poles are one."""


@dataclass(frozen=True, eq=False)
class Tracts:
    """Area functions of m tracts with one number of sections, lengths (m, k) in m and areas (m, k) in m²."""

    lengths: Real
    areas: Real
    constants: TubeConstants

    @property
    def spacing(self) -> Real:
        """c/2L, Hz: mean distance of resonances."""
        return np.asarray(self.constants.sound_speed / (2.0 * self.lengths.sum(axis=1)))

    def rows(self, chosen: NDArray[np.intp]) -> Tracts:
        """Some of the tracts, in the order given; repetitions allowed."""
        return Tracts(self.lengths[chosen], self.areas[chosen], self.constants)

    def ratio(self, frequency: Complex) -> Complex:
        """D at complex frequencies (m, f), Hz."""
        return flow_ratio(TWO_PI * frequency, self.lengths, self.areas, self.constants)

    def newton_step(self, frequency: Complex) -> Complex:
        """D / (dD/dF) at complex frequencies (m, f), Hz."""
        value, slope = flow_ratio_slope(TWO_PI * frequency, self.lengths, self.areas, self.constants)
        return value / (TWO_PI * slope)


@dataclass(frozen=True, eq=False)
class PoleSearch:
    """Poles of m tracts up to their top frequencies.

    Attributes:
        poles: F + jB/2 in Hz, by rising F, for each tract.
        failures: empty, or why the poles of a tract are not known.
    """

    poles: list[Complex]
    failures: list[str]


def find_poles(tracts: Tracts, top: Real) -> PoleSearch:
    """All poles in the region of each tract up to ``top`` (m,), Hz."""
    region = Region(top, 0.05 * tracts.spacing, tracts.constants.lowest_frequency)
    outline, lower = region.outline(_steps(top, tracts.spacing))
    values = tracts.ratio(outline)
    count = count_zeros(lambda points, rows: tracts.rows(rows).ratio(points), outline, values)
    guesses = _minima(outline[:, lower], values[:, lower])
    found = _newton(tracts, region, guesses)
    poles: list[Complex] = []
    failures: list[str] = []
    short = []
    for row, at in enumerate(found):
        poles.append(at)
        failures.append("" if at.size == count.zeros[row] else "open")
        if at.size < count.zeros[row]:
            short.append(row)
    if short:
        _complete(tracts, region, count, np.array(short), poles, failures)
    for row, failure in enumerate(failures):
        if failure:
            poles[row], failures[row] = poles_by_bisection(tracts, region, row)
    return PoleSearch(poles, failures)


def _steps(top: Real, spacing: Real) -> int:
    """Steps along the lower edge: 30 for each resonance expected."""
    return int(np.ceil(30.0 * float((top / spacing).max())))


def _minima(points: Complex, values: Complex) -> Complex:
    """Newton guesses (m, g) from local minima of |D| along a line of equally spaced points; nan where there are fewer.

    The slope at a minimum is the central difference.
    """
    size = np.abs(values)
    lowest = (size[:, 1:-1] < size[:, :-2]) & (size[:, 1:-1] <= size[:, 2:])
    rows, places = np.nonzero(lowest)
    places = places + 1
    order = np.concatenate([np.arange(n) for n in np.bincount(rows, minlength=len(points))]) if rows.size else rows
    guesses = np.full((len(points), int(order.max(initial=-1)) + 1), np.nan + 0.0j)
    spread = values[rows, places + 1] - values[rows, places - 1]
    step = values[rows, places] * (points[rows, places + 1] - points[rows, places - 1]) / spread
    guesses[rows, order] = points[rows, places] - step
    return guesses


def _newton(tracts: Tracts, region: Region, guesses: Complex, fixed: list[Complex] | None = None) -> list[Complex]:
    """Distinct poles inside the regions that Newton's method reaches from guesses (m, g), nan for none, by rising F.

    Fixed poles, known already, repel and are listed too.
    """
    known = _table(fixed) if fixed is not None else np.full((len(guesses), 0), np.nan + 0.0j)
    current = np.concatenate([known, guesses], axis=1)
    settled = np.zeros(current.shape, dtype=np.bool_)
    settled[:, : known.shape[1]] = True
    lost = np.isnan(current)
    for _ in range(ITERATIONS):
        moving = ~(settled | lost)
        active = np.flatnonzero(moving.any(axis=1))
        if not active.size:
            break
        rows, columns = np.nonzero(moving)
        points = current[rows, columns]
        step = tracts.rows(rows).newton_step(points[:, None])[:, 0]
        others = np.where(lost[rows], np.inf, current[rows])
        others[np.arange(rows.size), columns] = np.inf
        distance = points[:, None] - others
        distance[distance == 0] = SAME
        damped = step / (1.0 - step * (1.0 / distance).sum(axis=1))
        limit = 0.5 * tracts.spacing[rows]
        size = np.abs(damped)
        damped = np.where(size > limit, damped * (limit / np.maximum(size, 1e-300)), damped)
        moved = points - damped
        strayed = ~np.isfinite(moved) | (moved.real < 0.5 * region.lowest) | (np.abs(moved.imag) > moved.real)
        current[rows, columns] = np.where(strayed, points, moved)
        lost[rows, columns] |= strayed
        settled[rows, columns] |= ~strayed & (size < TOLERANCE * np.abs(points))
    inside = settled & region.contains(np.where(np.isnan(current), 0.0, current))
    return [_distinct(current[row, inside[row]]) for row in range(len(current))]


def _distinct(poles: Complex) -> Complex:
    ordered = poles[np.argsort(poles.real, kind="stable")]
    kept: list[complex] = []
    for pole in ordered:
        if all(abs(pole - other) > SAME for other in kept):
            kept.append(complex(pole))
    return np.array(kept, dtype=np.complex128)


def _table(poles: list[Complex]) -> Complex:
    """Rows of unequal length as one array filled up with nan."""
    table = np.full((len(poles), max((row.size for row in poles), default=0)), np.nan + 0.0j)
    for row, values in enumerate(poles):
        table[row, : values.size] = values
    return table


def _complete(
    tracts: Tracts,
    region: Region,
    count: Count,
    short: NDArray[np.intp],
    poles: list[Complex],
    failures: list[str],
) -> None:
    """Looks for the poles that the minima did not lead to, starting from the power sums."""
    guesses = _table([count.guesses(int(row), poles[row]) for row in short])
    if not guesses.shape[1]:
        return
    found = _newton(tracts.rows(short), region.rows(short), guesses, [poles[row] for row in short])
    for row, at in zip(short, found, strict=True):
        poles[row] = at
        if at.size == count.zeros[row]:
            failures[row] = ""
