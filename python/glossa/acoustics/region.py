"""Where poles are looked for, in the complex frequency plane: F + jB/2, both in Hz.

A pole at F + jd, d = B/2 > 0, decays as e^{-2πdt}. The region reaches from the lowest frequency at which the wall acts
as a mass (at least 1 Hz) to a top frequency; from just below the real axis (losses keep every pole above it, lossless
ones are on it) to a decay of 600 Hz, a bandwidth of 1200 Hz; and it ends at d = F: an oscillation damped more than
that, a damping ratio above 1/√2, has no resonance peak. This also leaves out the frequencies near the imaginary axis
where a yielding wall makes the line singular.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glossa.acoustics.constants import Complex

WIDEST_RAW = 1200.0
"""Hz of bandwidth up to which poles are listed at all."""


@dataclass(frozen=True, eq=False)
class Region:
    """Regions of m tracts.

    Attributes:
        top: highest frequency (m,), Hz.
        depth: how far the region reaches below the real axis (m,), Hz.
        lowest: lowest frequency, Hz.
    """

    top: NDArray[np.float64]
    depth: NDArray[np.float64]
    lowest: float = 1.0

    @property
    def height(self) -> NDArray[np.float64]:
        """Largest decay, Hz (m,)."""
        return np.minimum(0.5 * WIDEST_RAW, 0.6 * self.top)

    def corners(self) -> Complex:
        """Corners (m, 5), counterclockwise from the lower left."""
        low = np.full_like(self.top, self.lowest)
        columns = [
            low - 1j * self.depth,
            self.top - 1j * self.depth,
            self.top + 1j * self.height,
            self.height * (1.0 + 1.0j),
            low * (1.0 + 1.0j),
        ]
        return np.stack(columns, axis=1)

    def outline(self, steps: int) -> tuple[Complex, slice]:
        """Points along the outlines, (m, s), and which of them are on the lower edge, of ``steps`` steps."""
        counts = (steps, max(8, steps // 12), max(16, steps // 2), 12, 2)
        corners = self.corners()
        edges = []
        for i, count in enumerate(counts):
            begin, end = corners[:, i : i + 1], corners[:, (i + 1) % 5 : (i + 1) % 5 + 1]
            edges.append(begin + (end - begin) * (np.arange(count) / count))
        return np.concatenate(edges, axis=1), slice(0, steps)

    def contains(self, points: Complex) -> NDArray[np.bool_]:
        """Which points (m, g) are inside."""
        inside = (points.real > self.lowest) & (points.real < self.top[:, None])
        inside &= (points.imag > -self.depth[:, None]) & (points.imag < self.height[:, None])
        return inside & (points.imag < points.real)

    def rows(self, chosen: NDArray[np.intp]) -> Region:
        """The regions of some tracts."""
        return Region(self.top[chosen], self.depth[chosen], self.lowest)
