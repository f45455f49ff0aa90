"""The supports carry the gradient of the energy, and the response to small loads is reciprocal.

The energy is written here a second time, in numpy and from the paper's formulas; its gradient is taken with complex
steps, so that nothing but rounding separates the two.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.blocks import FloatArray, block

from glossa import MotorCommands, Posture, Scene, Speaker, Yeoh
from glossa.anatomy.muscle_topology import capacity_shares

ComplexArray = NDArray[np.complex128]
COMMANDS = MotorCommands({"upper": 0.8, "side": 0.95})
LOAD = (0.05, 0.1, 0.3)
"""N in all on the corners, an eighth on each."""
GAUSS = np.array(list(itertools.product((-1, 1), repeat=3))) / np.sqrt(3.0)
SIGNS = np.array([(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)])


def shape_gradients(nodes: FloatArray, hexahedra: NDArray[np.int32]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Shape functions (8, g), gradients in space (m, g, 8, 3) and quadrature weights (m, g) at the Gauss points."""
    factors = 1.0 + GAUSS[:, None, :] * SIGNS  # (g, 8, 3)
    shapes = factors.prod(axis=2) / 8.0
    local = np.stack(
        [SIGNS[:, i] * np.delete(factors, i, axis=2).prod(axis=2) / 8.0 for i in range(3)], axis=2
    )  # (g, 8, 3)
    jacobian = np.einsum("gai,maj->mgij", local, nodes[hexahedra])
    return shapes.T, np.einsum("mgij,gaj->mgai", np.linalg.inv(jacobian), local), np.linalg.det(jacobian)


def determinant(F: ComplexArray) -> ComplexArray:
    return np.asarray(np.einsum("...i,...i->...", F[..., 0, :], np.cross(F[..., 1, :], F[..., 2, :])))


def energy(x: ComplexArray, posture: Posture, tissue: Yeoh, element: str, gravity: FloatArray) -> complex:
    """Of tissue, muscles, weight and loads, J; the factors of eq. 1 are held at those of the posture."""
    speaker = posture.speaker
    shapes, gradients, weights = shape_gradients(speaker.nodes, speaker.hexahedra)
    corners = x[speaker.hexahedra]
    F = np.einsum("mai,mgaj->mgij", corners, gradients)
    J = determinant(F)
    distortion = J ** (-2.0 / 3.0) * np.einsum("mgij,mgij->mg", F, F) - 3.0
    isochoric = tissue.c10 * distortion + tissue.c20 * distortion**2
    total = np.sum(np.asarray(posture.stiffening)[:, None] * weights * isochoric)
    if element == "Q1P0":
        volumes = weights.sum(axis=1)
        total += np.sum(0.5 * tissue.bulk_modulus * volumes * ((weights * J).sum(axis=1) / volumes - 1.0) ** 2)
    else:
        total += np.sum(0.5 * tissue.bulk_modulus * weights * (J - 1.0) ** 2)
    placed = np.einsum("ag,mai->mgi", shapes, corners)
    total -= np.einsum("mg,mgi,i->", tissue.density * weights, placed, gravity)
    total -= x[speaker.node_sets["corners"]].mean(axis=0) @ np.asarray(LOAD)
    return complex(total + muscle_energy(x, posture))


def soft_lengths(x: ComplexArray, rest: FloatArray) -> ComplexArray:
    """(s,) lengths of a polyline's segments, softened by a hundredth of those at rest so that none has a kink at 0."""
    squares = (np.diff(x, axis=0) ** 2).sum(axis=1)
    at_rest = np.linalg.norm(np.diff(rest, axis=0), axis=1)
    return np.asarray(np.sqrt(squares + (0.01 * at_rest) ** 2) - (np.sqrt(1.0001) - 1.0) * at_rest)


def muscle_energy(x: ComplexArray, posture: Posture) -> complex:
    """Integral of eq. 3 over length: rho phi (exp(c A) - 1 - c A) / c, phi the factor of eq. 5 at rest."""
    nodes = posture.speaker.nodes
    assert posture.commands is not None
    at_rest = 0.7109 + 0.712 * np.arctan(0.43)
    total = 0.0 + 0.0j
    for name, muscle in posture.speaker.muscles.items():
        rests = posture.speaker.fibre_rest_lengths(name)
        shares = capacity_shares(posture.speaker.nodes, posture.speaker.hexahedra, muscle)
        for fibre, rest, share in zip(muscle.fibres, rests, shares, strict=True):
            activation = soft_lengths(x[fibre], nodes[fibre]).sum() - posture.commands[name] * rest
            assert activation.real < np.log(2.0) / 40.0  # not saturated
            if activation.real > 0.0:
                stored = (np.expm1(40.0 * activation) - 40.0 * activation) / 40.0
                total += muscle.force_capacity * share * at_rest * stored
    return complex(total)


@pytest.mark.parametrize("stiffening", [True, False])
@pytest.mark.parametrize("element", ["Q1P0", "Q1"])
def test_supports_are_the_gradient_of_the_energy(element: str, stiffening: bool) -> None:
    gravity = np.array([1.0, 2.0, -9.0])
    tissue = Yeoh(1037.0, 486.0, poissons_ratio=0.495)
    cells = (3, 2, 2)
    speaker = block(cells, muscles={"upper": 4.0, "side": 3.0}, distortion=0.2)
    scene = Scene(
        speaker, fixed=["left"], gravity=gravity.tolist(), element=element, tissue=tissue, stiffening=stiffening
    )
    posture = scene.equilibrate(COMMANDS, accuracy="reference", loads={"corners": LOAD})
    assert posture.forces.min() > 0.1
    assert np.asarray(posture.stiffening).max() > 1.2 or not stiffening
    gradient = np.zeros(speaker.nodes.shape)
    for node, axis in np.ndindex(*gradient.shape):
        x = posture.positions.astype(complex)
        x[node, axis] += 1e-20j
        gradient[node, axis] = energy(x, posture, tissue, element, gravity).imag / 1e-20
    supports = np.asarray(posture.support_forces)
    assert np.abs(supports).max() > 0.1
    assert gradient == pytest.approx(supports, abs=1e-9)  # residual at 1e-11 of the force scale, and rounding


def test_small_loads_act_reciprocally(reference: Speaker) -> None:
    """Betti: the work of one small load on the motion due to another is mutual where forces have a potential."""
    scene = Scene(reference, stiffening=False, friction=0.0)
    commands = {"GGp": 0.8, "Sty": 0.95, "MH": 0.9}
    base = scene.equilibrate(commands, accuracy="reference")
    size = 1e-5  # N; quadratic terms are 1e-4 of the linear ones
    forces = {"tip": (0.0, 0.0, size), "dorsum": (size, 0.0, 0.0)}
    moved = {
        name: scene.equilibrate(commands, start=base, loads={name: force}, accuracy="reference")
        for name, force in forces.items()
    }
    work = {
        a: float(((moved[a].node_set(b) - base.node_set(b)) @ np.asarray(forces[b])).sum())
        for a, b in (("tip", "dorsum"), ("dorsum", "tip"))
    }
    assert abs(work["tip"]) > 1e-14  # J: nanometres per load
    assert work["tip"] == pytest.approx(work["dorsum"], rel=1e-3)
