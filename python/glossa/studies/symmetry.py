"""Whether a symmetric tongue stays symmetric: the mirrored model beside the full one, and a nudge sideways.

A mirrored scene cannot leave the midsagittal plane. Where its equilibrium is unstable against sideways motion, as that
of a column that is about to buckle, a real tongue would, and no mirrored result tells of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.mirror import mirror_pairs
from glossa.checks import positive_number
from glossa.errors import SolveError
from glossa.motor.commands import MotorCommands
from glossa.results import Posture
from glossa.scene import Scene

_REFLECTION = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True, kw_only=True, eq=False)
class SymmetryCheck:
    """The mirrored model, the full one, and the full one from a nudge; positions of all the speaker's nodes.

    Attributes:
        mirrored: equilibrium of the mirrored scene.
        asymmetry: m, largest distance of a node of the full equilibrium from the mirror image of its partner; NaN where
            the full scene did not converge.
        apart: m, largest distance between a node in both; NaN likewise.
        returned: m, largest distance from ``mirrored`` of the full equilibrium found after the nudge, or of the last
            state of the solve.
        reason: why one of the two full solves failed, else empty.
        tolerance: m.
    """

    mirrored: Posture
    asymmetry: float
    apart: float
    returned: float
    reason: str
    tolerance: float

    @property
    def symmetric(self) -> bool:
        """The full tongue finds the mirrored equilibrium, and again after a nudge: the mirrored model can be trusted.

        Otherwise the symmetric equilibrium is not the only one near (a bifurcation), or ``reason`` tells what failed.
        """
        return not self.reason and max(self.asymmetry, self.apart, self.returned) <= self.tolerance


def symmetry(
    scene: Scene,
    commands: MotorCommands | Mapping[str, float] | None = None,
    *,
    prescribed: Mapping[str, Any] | None = None,
    nudge: float = 1e-4,
    tolerance: float = 5e-4,
    max_iterations: int = 150,
) -> SymmetryCheck:
    """Solve a symmetric scene mirrored, full, and full once more from a posture that leans to one side.

    Args:
        scene: with a symmetric speaker; whether it is mirrored makes no difference.
        commands: as in :meth:`glossa.Scene.equilibrate`.
        prescribed: likewise; symmetric.
        nudge: m, largest displacement of the lean.
        tolerance: m within which postures count as one. Contact, which is solved to 0.05 mm, leaves 0.1 mm open.
        max_iterations: Newton iterations of each solve.

    Raises:
        InputError: a scene that is not symmetric, or wrong arguments.
        SolveError, SolveInterrupted: the mirrored scene has no equilibrium.
    """
    size, wanted = positive_number(nudge, "nudge (m)"), positive_number(tolerance, "tolerance (m)")
    half, full = (Scene(scene.speaker, **{**scene.options, "mirror": mirror}) for mirror in (True, False))
    arguments: dict[str, Any] = {"prescribed": prescribed, "max_iterations": max_iterations}
    mirrored = half.equilibrate(commands, **arguments)
    pairs = mirror_pairs(scene.speaker.nodes)
    asymmetry = apart = float("nan")
    reason = ""
    try:
        whole = full.equilibrate(commands, **arguments).positions
        asymmetry, apart = _farthest(whole, whole[pairs] * _REFLECTION), _farthest(whole, mirrored.positions)
    except SolveError as error:
        reason = str(error)
    lean = size * _lean(scene.speaker.nodes)
    lean[_held(full, prescribed or {})] = 0.0
    try:
        again = full.equilibrate(commands, start=replace(mirrored, positions=mirrored.positions + lean), **arguments)
    except SolveError as error:
        reason, again = reason or str(error), error.posture
    return SymmetryCheck(
        mirrored=mirrored,
        asymmetry=asymmetry,
        apart=apart,
        returned=_farthest(again.positions, mirrored.positions),
        reason=reason,
        tolerance=wanted,
    )


def _farthest(one: FloatArray, other: FloatArray) -> float:
    return float(np.linalg.norm(one - other, axis=1).max())


def _held(scene: Scene, prescribed: Mapping[str, Any]) -> list[int]:
    """Nodes that do not move freely; those of a mobile hyoid follow it whatever they start from."""
    sets = scene.speaker.node_sets
    names = [*scene.fixed, *(name for name in prescribed if name in sets)]
    return [*(int(node) for name in names for node in sets[name]), *map(int, scene.speaker.outside_points)]


def _lean(nodes: FloatArray) -> FloatArray:
    """(n, 3) of at most 1: sideways bend along x and z and a twist, opposite to its own mirror image."""
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    x, y, z = (2.0 * (nodes - low) / (high - low) - 1.0).T
    field = np.stack([0.3 * y * z, 0.5 + 0.3 * x - 0.4 * z + 0.2 * x * z - 0.5 * x**2, -0.3 * x * y], axis=1)
    return np.asarray(field / np.linalg.norm(field, axis=1).max())
