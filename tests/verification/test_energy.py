"""Energy of a released body: damping only takes, and without damping nothing is lost."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import FloatArray, block

from glossa import Damping, Scene, Simulation


def energies(simulation: Simulation, dt: float, steps: int) -> FloatArray:
    """(steps + 1, 2) kinetic and potential energy, J."""
    found = [(simulation.kinetic_energy, simulation.potential_energy)]
    for _ in range(steps):
        simulation.step(dt)
        found.append((simulation.kinetic_energy, simulation.potential_energy))
    return np.array(found)


@pytest.mark.parametrize("integrator", ["SDIRK2", "BDF2", "backward_euler"])
@pytest.mark.parametrize(("alpha", "beta"), [(40.0, 0.03), (40.0, 0.0), (0.0, 0.03), (5.0, 0.001)])
def test_damped_energy_never_grows(alpha: float, beta: float, integrator: str) -> None:
    scene = Scene(block(), fixed=["left"], damping=Damping(alpha=alpha, beta=beta))
    simulation = scene.start(None, dt=0.0025, integrator=integrator, accuracy="reference")
    history = energies(simulation, 0.0025, 80)
    total = history.sum(axis=1)
    lost = total[0] - total[-1]
    assert history[0, 0] == 0.0
    assert history[:, 0].max() > 1e-3 * lost  # it moved
    assert lost > 1e-3  # J
    assert np.diff(total).max() < 1e-9 * lost  # stages are solved to 1e-9 of the force scale


def test_undamped_energy_is_kept() -> None:
    """The trapezoidal rule keeps the energy of the slow motion; stiff modes carry what is missing."""
    scene = Scene(block((3, 2, 2)), fixed=["left"], damping=None)
    history = energies(scene.start(None, dt=0.001, integrator="trapezoidal", accuracy="reference"), 0.001, 100)
    total = history.sum(axis=1)
    assert history[:, 0].max() > 3e-3
    assert np.abs(total - total[0]).max() < 0.02 * history[:, 0].max()
    damped = Scene(block((3, 2, 2)), fixed=["left"])
    loss = energies(damped.start(None, dt=0.001, accuracy="reference"), 0.001, 100).sum(axis=1)
    assert loss[0] - loss[-1] > 10.0 * np.abs(total - total[0]).max()


def test_rest_in_equilibrium() -> None:
    """Started in equilibrium, nothing moves."""
    scene = Scene(block(), fixed=["left"])
    posture = scene.equilibrate(accuracy="reference")
    simulation = scene.start(None, initial=posture, dt=0.005, accuracy="reference")
    history = energies(simulation, 0.005, 10)
    assert simulation.positions == pytest.approx(posture.positions, abs=1e-8)
    assert history[:, 0].max() < 1e-12
    assert history[:, 1] == pytest.approx(history[0, 1], rel=1e-9)
