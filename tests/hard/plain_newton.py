"""Newton's method without the solver's recoveries, from the public pieces of the core: what fails without them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glossa import Scene, _core

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """How an attempt ended.

    Attributes:
        converged: the residual fell below 1e-8 of the largest one.
        why: "converged", "inverted", "indefinite" or "limit".
        iterations: taken.
        positions: (n, 3) m, the last.
    """

    converged: bool
    why: str
    iterations: int
    positions: FloatArray


def plain_newton(
    scene: Scene,
    commands: dict[str, float],
    *,
    start: FloatArray | None = None,
    shorten: bool = True,
    cure: bool = True,
    renew: bool = True,
    limit: int = 200,
) -> Attempt:
    """Newton's method from ``start`` (rest) on a scene without mirror and mobile hyoid.

    Args:
        scene: whose forces, gravity and contact's penalty included, are to vanish.
        commands: lambda by muscle.
        start: (n, 3) m.
        shorten: halve steps that invert an element or raise the energy.
        cure: go on with a shifted factor where the tangent is indefinite, as the pieces offer one.
        renew: factorise at every iteration; else the first factor serves throughout.
        limit: iterations.
    """
    fractions = np.array([commands.get(name, np.nan) for name in scene.speaker.muscles])
    pieces = _core.Pieces(scene._solver, fractions)
    unknowns = pieces.unknowns
    positions = np.array(scene.speaker.nodes if start is None else start)
    force = pieces.force(positions).ravel()[unknowns]
    energy, largest = pieces.energy(), float(np.linalg.norm(force))
    for iteration in range(limit):
        residual = float(np.linalg.norm(force))
        largest = max(largest, residual)
        if residual <= 1e-8 * largest:
            return Attempt(converged=True, why="converged", iterations=iteration, positions=positions)
        if renew or iteration == 0:
            pieces.assemble()
            if not pieces.factorise() and not cure:
                return Attempt(converged=False, why="indefinite", iterations=iteration, positions=positions)
        step = pieces.solve(force)
        for halving in range(40 if shorten else 1):
            moved = positions.copy()
            moved.ravel()[unknowns] += 0.5**halving * step
            new = pieces.force(moved).ravel()[unknowns]
            fits = bool(np.isfinite(new).all())
            if fits and (not shorten or pieces.energy() <= energy + 1e-13 * (abs(energy) + 1e-6)):
                break
        if not fits:
            return Attempt(converged=False, why="inverted", iterations=iteration, positions=positions)
        positions, force, energy = moved, new, pieces.energy()
    return Attempt(converged=False, why="limit", iterations=limit, positions=positions)
