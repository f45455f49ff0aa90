"""The pieces below equilibrate, as scripts use them: force, tangent, factor."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse
from tests.blocks import block

from glossa import InputError, Scene, _core


@pytest.fixture
def pieces() -> tuple[_core.Pieces, np.ndarray]:
    scene = Scene(block((3, 2, 2), muscles={"axial": 4.0}), fixed=["left"], stiffening=False)
    moved = scene.equilibrate({"axial": 0.8}).positions
    rng = np.random.default_rng(3)
    moved = moved + rng.uniform(-2e-4, 2e-4, moved.shape) * (scene.speaker.nodes[:, :1] > 0)
    return _core.Pieces(scene._solver, np.array([0.8])), np.ascontiguousarray(moved)


def matrix(pieces: _core.Pieces) -> np.ndarray:
    start, row, value = pieces.matrix()
    lower = scipy.sparse.csc_array((value, row, start)).toarray()
    return np.asarray(lower + np.tril(lower, -1).T)


def test_tangent_is_the_derivative_of_the_force(pieces: tuple[_core.Pieces, np.ndarray]) -> None:
    core, positions = pieces
    core.force(positions)
    core.assemble()
    tangent, unknowns = matrix(core), core.unknowns
    direction = np.random.default_rng(4).normal(size=len(unknowns))
    step = 1e-7

    def force(sign: float) -> np.ndarray:
        moved = positions.copy()
        moved.ravel()[unknowns] += sign * step * direction
        return np.asarray(core.force(moved).ravel()[unknowns])

    difference = (force(1.0) - force(-1.0)) / (2 * step)
    assert np.abs(difference).max() > 1.0
    # Truncation of the central difference: 1e-9 seen.
    assert np.abs(tangent @ direction - difference).max() < 1e-7 * np.abs(difference).max()


def test_solve_inverts_the_tangent(pieces: tuple[_core.Pieces, np.ndarray]) -> None:
    core, positions = pieces
    core.force(positions)
    core.assemble()
    assert not core.factorise()  # pressures of a disturbed body make it indefinite: a shifted factor stands in
    core.force(block((3, 2, 2)).nodes)
    core.assemble()
    assert core.factorise()
    right = np.random.default_rng(5).normal(size=len(core.unknowns))
    exact, rough = core.solve(right), core.solve(right, roughly=True)
    assert np.abs(matrix(core) @ exact + right).max() < 1e-9  # rounding times the condition; 1e-12 seen
    assert not np.array_equal(exact, rough)
    assert np.abs(exact - rough).max() < 1e-4 * np.abs(exact).max()  # single precision


def test_energy_falls_along_the_force(pieces: tuple[_core.Pieces, np.ndarray]) -> None:
    core, positions = pieces
    force = core.force(positions).ravel()[core.unknowns]
    before = core.energy()
    step = 1e-6 / np.abs(force).max()
    moved = positions.copy()
    moved.ravel()[core.unknowns] -= step * force
    core.force(moved)
    assert core.energy() - before == pytest.approx(-step * float(force @ force), rel=0.05)  # curvature along the step


def test_order_of_calls() -> None:
    scene = Scene(block((2, 1, 1)), fixed=["left"])
    core = _core.Pieces(scene._solver, scene._fractions(None))
    with pytest.raises(InputError, match=r"assemble needs force\(\) first"):
        core.assemble()
    with pytest.raises(InputError, match=r"solve needs a successful factorise\(\) first"):
        core.solve(np.ones(3))
    with pytest.raises(InputError, match=r"positions: shape must be"):
        core.force(np.zeros((2, 3)))
