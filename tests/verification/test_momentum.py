"""Balance of forces and moments in equilibrium, and of momentum in movement."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import FloatArray, block

from glossa import Damping, InputError, MotorCommands, Scene, Speaker

GRAVITY = np.array([1.0, 2.0, -9.0])
COMMANDS = MotorCommands({"upper": 0.8, "side": 0.95})
LOADS = {"right": (0.2, -0.1, 0.3), "corners": (0.0, 0.1, 0.0)}


def nodal_masses(speaker: Speaker, density: float = 1040.0) -> FloatArray:
    """(n,) kg, of a block of equal cuboids: an eighth of every cell at its corners."""
    masses = np.zeros(len(speaker.nodes))
    np.add.at(masses, speaker.hexahedra, density * speaker.element_volumes[:, None] / 8.0)
    return masses


@pytest.fixture(scope="module")
def body() -> Speaker:
    return block((5, 3, 3), muscles={"upper": 3.0, "side": 2.0})


@pytest.mark.parametrize("element", ["Q1P0", "Q1"])
def test_forces_and_moments_in_equilibrium(body: Speaker, element: str) -> None:
    scene = Scene(body, fixed=["left"], gravity=GRAVITY.tolist(), element=element)
    posture = scene.equilibrate(COMMANDS, loads=LOADS, accuracy="reference")
    assert posture.forces.min() > 0.1
    supports, x = np.asarray(posture.support_forces), posture.positions
    weight = nodal_masses(body)[:, None] * GRAVITY
    load = np.sum(list(LOADS.values()), axis=0)
    total = weight.sum(axis=0) + load
    assert np.linalg.norm(total) > 0.5
    # Residual at 1e-11 of the force scale, summed over the nodes.
    assert supports.sum(axis=0) == pytest.approx(-total, abs=1e-9)
    assert posture.reactions("left") == pytest.approx(-total, abs=1e-9)
    assert posture.reactions("right") == pytest.approx([0, 0, 0], abs=0)
    # Moments about the origin; loads as the scene spreads them: bilinear traction on the face, equal at lone nodes.
    face = body.node_sets["right"]
    quads = body.surface_quads[np.isin(body.surface_quads, face).all(axis=1)]
    on_face = np.array([(quads == node).sum() for node in face])
    share = np.zeros((len(x), 3))
    share[face] += (on_face / on_face.sum())[:, None] * LOADS["right"]
    share[body.node_sets["corners"]] += np.asarray(LOADS["corners"]) / 8.0
    moment = np.cross(x, supports + weight + share).sum(axis=0)
    assert moment == pytest.approx([0, 0, 0], abs=1e-10)
    assert np.linalg.norm(np.cross(x, supports).sum(axis=0)) > 1e-3


def test_supports_of_a_speaker(reference: Speaker) -> None:
    scene = Scene(reference, contact=False, hyoid="fixed")  # else walls and springs carry their share
    posture = scene.equilibrate({"GGp": 0.8, "Sty": 0.95, "MH": 0.9}, accuracy="reference")
    weight = 1040.0 * reference.volume * 9.81
    # The styloid points are supports too: they carry the tension of Sty.
    styloid = posture.reactions("styloid")
    total = posture.reactions("jaw") + posture.reactions("hyoid") + styloid
    assert np.linalg.norm(styloid) > 0.5
    assert total == pytest.approx([0.0, 0.0, weight], abs=1e-8)


def test_loose_bodies_have_no_equilibrium(body: Speaker) -> None:
    with pytest.raises(InputError, match=r"free to move rigidly \(6 of 6 rigid motions\)"):
        Scene(body, fixed=[]).equilibrate()
    line = {"corners": (None, None, 0.0)}
    with pytest.raises(InputError, match=r"free to move rigidly \(3 of 6 rigid motions\)"):
        Scene(body, fixed=[]).equilibrate(prescribed=line)


@pytest.mark.parametrize("integrator", ["SDIRK2", "BDF2", "trapezoidal"])
def test_free_fall(body: Speaker, integrator: str) -> None:
    """Without supports the centre of mass falls as a point does, whatever the muscles do: v' = g - alpha v."""
    damping = Damping(alpha=0.0, beta=0.03)
    scene = Scene(body, fixed=[], gravity=GRAVITY.tolist(), damping=damping)
    movement = scene.simulate(COMMANDS, 0.05, dt=0.0025, integrator=integrator, accuracy="reference")
    masses = nodal_masses(body) / nodal_masses(body).sum()
    centre = masses @ movement.positions
    t = movement.times[:, None]
    fall = 0.5 * GRAVITY * t**2
    # Second-order methods are exact for a quadratic; what stays is that muscles and tissue balance among themselves.
    assert centre - centre[0] == pytest.approx(fall, abs=1e-9)
    assert np.ptp(movement.positions[-1] - movement.positions[0], axis=0).max() > 1e-3  # it does deform
    assert masses @ movement.velocities == pytest.approx(GRAVITY * t, abs=1e-8)


def test_terminal_speed(body: Speaker) -> None:
    """With alpha the speed is g (1 - exp(-alpha t)) / alpha, and the body stays rigid."""
    scene = Scene(body, fixed=[], damping=Damping(alpha=40.0, beta=0.03))
    movement = scene.simulate(None, 0.1, dt=0.0025, accuracy="reference")
    speed = -9.81 * (1.0 - np.exp(-40.0 * movement.times)) / 40.0
    mean = movement.velocities[:, :, 2].mean(axis=1)
    assert np.ptp(movement.velocities, axis=1).max() < 1e-8
    assert mean == pytest.approx(speed, abs=2e-4 * 9.81 / 40.0)  # second order: (alpha dt)^2 / 50
    assert mean[-1] == pytest.approx(-9.81 / 40.0, rel=0.03)
