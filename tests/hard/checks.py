"""What every solved hard case is asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from glossa import Movement, Posture, SolveReport, Speaker

FloatArray = NDArray[np.float64]

DEEPEST = 5e-5
"""Penetration of a wall that an equilibrium may leave, m."""


def sound(posture: Posture, *, residual: float = 1e-8) -> SolveReport:
    """The report of a posture that is converged, uninverted and inside its walls."""
    report = posture.report
    assert report is not None
    assert report.converged
    # Where no force acts, rounding of the tissue's stresses sets the tolerance: 1e-11 N on the bodies here.
    assert report.residual <= residual * report.force_scale + 1e-11 * posture.speaker.nodes.size
    assert report.least_jacobian > 0.0
    assert report.penetration <= DEEPEST
    assert np.isfinite(posture.positions).all()
    return report


def moved(movement: Movement, *, fastest: float) -> SolveReport:
    """The report of a movement whose every step converged and whose nodes stay slower than ``fastest`` (m/s)."""
    report = movement.report
    assert report.converged
    assert report.least_jacobian > 0.0
    assert np.linalg.norm(movement.velocities, axis=2).max() < fastest
    return report


def farthest(one: FloatArray, other: FloatArray) -> float:
    """m between the same node in two positions (n, 3), the farthest."""
    return float(np.linalg.norm(one - other, axis=-1).max())


def asymmetry(speaker: Speaker, positions: FloatArray) -> float:
    """m between positions (n, 3) and their mirror image about y = 0, the farthest node."""
    from glossa.anatomy.mirror import mirror_pairs

    image = positions[mirror_pairs(speaker.nodes)] * [1.0, -1.0, 1.0]
    return farthest(positions, image)
