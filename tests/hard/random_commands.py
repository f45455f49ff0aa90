"""Random motor commands: how they are drawn, and what is asked of their equilibria."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from glossa import MUSCLES, Posture, Scene, SolveError, studies
from glossa.anatomy.mirror import mirror_pairs
from glossa.tolerances import Tolerances

FloatArray = NDArray[np.float64]

RANGES = {"wide": (0.5, 1.5), "common": (0.6, 1.3)}
"""Limits of every muscle's lambda: 0.5 shortens all muscles by force, above 1 most are silent."""

SEED = 20091
RESIDUAL = 1e-8
"""Over the force scale; ``accuracy="standard"``."""
DEEPEST = 5e-5
"""Penetration of a wall that contact may leave, m."""
SAME = 5e-5
"""Two equilibria are the same where no node lies further apart, m: the depth that contact leaves open."""
SHARP = Tolerances(residual=1e-9, gap=2e-6)
"""Contact as hard as it takes to tell two equilibria from two depths of the same one."""
NUDGE = 1e-6
"""m, random displacement of every free node from which a stable equilibrium is found again."""


def design(which: str, count: int) -> studies.Design:
    """``count`` commands of all muscles, uniform between the limits of ``which``; fewer are the first of more."""
    return studies.monte_carlo({f"command.{muscle}": RANGES[which] for muscle in MUSCLES}, count, seed=SEED)


def commands_of(study: xr.Dataset, point: int) -> dict[str, float]:
    """Lambda by muscle at a point of a study."""
    return {str(name): float(study["commands"].sel(muscle=name)[point]) for name in study["muscle"].values}


def check(study: xr.Dataset) -> None:
    """Every point converged, no element is inverted and no wall entered."""
    failed = study.where(study["status"] != "converged", drop=True)
    assert failed.sizes["point"] == 0, [
        f"{p}: {r}" for p, r in zip(failed["point"].values, failed["reason"].values, strict=True)
    ]
    assert float(study["residual"].max()) <= RESIDUAL
    assert float(study["least_jacobian"].min()) > 0.0
    assert float(study["penetration"].max()) <= DEEPEST


def distances(cold: xr.Dataset, warm: xr.Dataset) -> FloatArray:
    """(points,) m between the same node in both, the farthest; NaN where one has no equilibrium."""
    apart = np.linalg.norm(cold["positions"].values - warm["positions"].values, axis=2)
    return np.asarray(apart.max(axis=1))


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Two equilibria of the same commands, found from different starts.

    Attributes:
        apart: m, farthest node, as they were found.
        sharp: m, likewise after contact was made hard from each of them.
        residuals: of both then, over the force scale.
        indefinite: tangents that were not positive definite in the solves that found both again after a nudge.
        returned: m, how far from itself each was found again; NaN where the solve failed.
    """

    apart: float
    sharp: float
    residuals: tuple[float, float]
    indefinite: tuple[int, int]
    returned: tuple[float, float]

    @property
    def same(self) -> bool:
        """One equilibrium, at two depths of contact."""
        return self.sharp <= SAME

    @property
    def both_real(self) -> bool:
        """Both satisfy the equations, and are found again from near."""
        # The solver adds to its tolerance what rounding of the tissue's stresses leaves.
        return max(self.residuals) <= 1.1 * SHARP.residual and max(self.returned) <= SAME


def compare(scene: Scene, commands: Mapping[str, float], one: FloatArray, other: FloatArray, seed: int) -> Comparison:
    """Whether two positions (n, 3) m are one equilibrium or two.

    Raises:
        SolveError: contact could not be made hard.
    """
    sharp = [scene.equilibrate(commands, start=start, accuracy=SHARP) for start in (one, other)]
    again = [_found_again(scene, commands, posture, seed) for posture in sharp]
    reports = [posture.report for posture in sharp]
    assert reports[0] is not None
    assert reports[1] is not None
    return Comparison(
        apart=farthest(one, other),
        sharp=farthest(sharp[0].positions, sharp[1].positions),
        residuals=(reports[0].residual / reports[0].force_scale, reports[1].residual / reports[1].force_scale),
        indefinite=(again[0][1], again[1][1]),
        returned=(again[0][0], again[1][0]),
    )


def farthest(one: FloatArray, other: FloatArray) -> float:
    """m between the same node in two positions (n, 3), the farthest."""
    return float(np.linalg.norm(one - other, axis=1).max())


def _found_again(scene: Scene, commands: Mapping[str, float], posture: Posture, seed: int) -> tuple[float, int]:
    """Distance (m) from a posture of what is found from near it, and tangents that needed a cure on the way."""
    nudge = np.random.default_rng(seed).uniform(-NUDGE, NUDGE, posture.positions.shape)
    held = np.zeros(len(nudge), dtype=bool)
    for name in ("jaw", "hyoid"):
        held[posture.speaker.node_sets[name]] = True
    held[posture.speaker.outside_points] = True
    nudge[held] = 0.0
    nudge = 0.5 * (nudge + nudge[mirror_pairs(posture.speaker.nodes)] * [1.0, -1.0, 1.0])
    try:
        found = scene.equilibrate(commands, start=replace(posture, positions=posture.positions + nudge), accuracy=SHARP)
    except SolveError:
        return float("nan"), 0
    assert found.report is not None
    return farthest(found.positions, posture.positions), found.report.indefinite
