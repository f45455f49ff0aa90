"""The quadratic element with discontinuous linear pressure (Q2P1): its energy, its accuracy, what it refuses.

The energy is written here a second time, in numpy and in another way than in the core: cells from the lattice of the
block, shape functions from a Vandermonde matrix, the pressure's projection by solving for it.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.blocks import FloatArray, block, lattice, nearest
from tests.verification.test_derivatives import ComplexArray, determinant, muscle_energy

from glossa import Damping, InputError, MotorCommands, Posture, Scene, Speaker, Yeoh

POINT = (0.06, 0.02, 0.02)
TISSUE = Yeoh(1037.0, 486.0, poissons_ratio=0.499)


class Cells:
    """The cells of a block: nodes (c, 27), hexahedra (c, 8), and at the 27 Gauss points shape functions (q, a),
    gradients in space (c, q, a, 3), weights (c, q) and the functions of the pressure (q, 4)."""

    def __init__(self, speaker: Speaker, cells: tuple[int, int, int]) -> None:
        self.nodes = _groups(lattice(cells)[2], 3)
        self.hexahedra = _groups(np.arange(np.prod(cells)).reshape(cells), 2)
        points, weights = np.polynomial.legendre.leggauss(3)
        basis = np.linalg.inv(np.vander([-1.0, 0.0, 1.0], increasing=True))
        values = np.vander(points, increasing=True) @ basis
        slopes = np.stack([0.0 * points, 1.0 + 0.0 * points, 2.0 * points], axis=1) @ basis
        self.shapes = _product(values, values, values)
        local = np.stack(
            [_product(*(slopes if i == j else values for j in range(3))) for i in range(3)],
            axis=2,
        )
        jacobian = np.einsum("qaj,cai->cqij", local, speaker.nodes[self.nodes])
        self.gradients = np.einsum("qaj,cqji->cqai", local, np.linalg.inv(jacobian))
        self.weights = np.einsum("i,j,k->ijk", weights, weights, weights).ravel() * np.linalg.det(jacobian)
        self.places = np.stack(np.meshgrid(points, points, points, indexing="ij"), axis=-1).reshape(27, 3)
        self.pressures = np.concatenate([np.ones((27, 1)), self.places], axis=1)
        signs = np.stack(np.meshgrid(*[[-1, 1]] * 3, indexing="ij"), axis=-1).reshape(8, 3)
        touching = np.all(self.places[:, None] * signs > -1e-9, axis=2)
        self.shares = touching / touching.sum(axis=1, keepdims=True)


def _groups(number: NDArray[np.int64], width: int) -> NDArray[np.int64]:
    """The numbers of each 2 x 2 x 2 group of a lattice's cells (width 2) or of the nodes of each (width 3)."""
    starts = [range(0, n - 1, 2) for n in number.shape]
    return np.array(
        [
            number[i : i + width, j : j + width, k : k + width].ravel()
            for i in starts[0]
            for j in starts[1]
            for k in starts[2]
        ]
    )


def _product(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("ai,bj,ck->abcijk", x, y, z).reshape(27, 27))


def energy(x: ComplexArray, posture: Posture, tissue: Yeoh, cells: Cells, gravity: FloatArray) -> complex:
    """Of tissue, muscles and weight, J; the factors of eq. 1 are held at those of the posture."""
    own = x[cells.nodes]
    F = np.einsum("cai,cqaj->cqij", own, cells.gradients)
    J = determinant(F)
    distortion = J ** (-2.0 / 3.0) * np.einsum("cqij,cqij->cq", F, F) - 3.0
    factors = np.asarray(posture.stiffening)[cells.hexahedra] @ cells.shares.T
    total = np.sum(factors * cells.weights * (tissue.c10 * distortion + tissue.c20 * distortion**2))
    phi = cells.pressures
    moments = np.einsum("cq,qm,qn->cmn", cells.weights, phi, phi)
    dilatation = np.linalg.solve(moments, np.einsum("cq,qm->cm", cells.weights * J, phi)[..., None])[..., 0] @ phi.T
    total += np.sum(0.5 * tissue.bulk_modulus * cells.weights * (dilatation - 1.0) ** 2)
    total -= np.einsum("cq,qa,cai,i->", tissue.density * cells.weights, cells.shapes, own, gravity)
    return complex(total + muscle_energy(x, posture))


def test_supports_are_the_gradient_of_the_energy() -> None:
    gravity = np.array([1.0, 2.0, -9.0])
    tissue = Yeoh(1037.0, 486.0, poissons_ratio=0.495)
    speaker = block((4, 2, 2), muscles={"upper": 4.0, "side": 3.0}, distortion=0.2)
    scene = Scene(speaker, fixed=["left"], gravity=gravity.tolist(), element="Q2P1", tissue=tissue)
    posture = scene.equilibrate(MotorCommands({"upper": 0.8, "side": 0.95}), accuracy="reference")
    assert posture.forces.min() > 0.1
    assert np.ptp(np.asarray(posture.stiffening)) > 0.2
    cells = Cells(speaker, (4, 2, 2))
    gradient = np.zeros(speaker.nodes.shape)
    for node, axis in np.ndindex(*gradient.shape):
        x = posture.positions.astype(complex)
        x[node, axis] += 1e-20j
        gradient[node, axis] = energy(x, posture, tissue, cells, gravity).imag / 1e-20
    supports = np.asarray(posture.support_forces)
    assert np.abs(supports).max() > 0.1
    assert gradient == pytest.approx(supports, abs=1e-9)  # residual at 1e-11 of the force scale, and rounding


def sag(cells: tuple[int, int, int], element: str, poissons_ratio: float = 0.499) -> float:
    """Downward displacement in mm of the end of the cantilever under its weight."""
    speaker = block(cells)
    tissue = Yeoh(1037.0, 486.0, poissons_ratio=poissons_ratio)
    posture = Scene(speaker, fixed=["left"], element=element, tissue=tissue).equilibrate()
    return float(-1e3 * posture.displacements[nearest(speaker, POINT), 2])


def test_it_does_not_lock() -> None:
    limit = 24.23  # as in test_locking.py, +- 0.04
    for cells in ((6, 4, 4), (12, 8, 8)):
        # At equal nodes: 0.02 and 0.08 mm from that limit, where Q1P0 is 1.2 and 0.55 mm.
        assert sag(cells, "Q2P1") == pytest.approx(limit, abs=0.12)
        assert abs(sag(cells, "Q2P1") - limit) < 0.25 * abs(sag(cells, "Q1P0") - limit)
    assert sag((6, 4, 4), "Q2P1", 0.4999) == pytest.approx(sag((6, 4, 4), "Q2P1"), rel=0.005)


def stiffness(n: int, element: str) -> float:
    """Work (nJ) that lifts the top of a box with rolling walls into a small cosine. The solution continues by
    reflection in all walls: no edge or corner makes it singular."""
    speaker = block((n, n, n))
    top = speaker.node_sets["top"]
    x, y, _ = (speaker.nodes[top] / np.array([0.06, 0.04, 0.04])).T
    lift = np.full((len(x), 3), None, dtype=object)
    lift[:, 2] = 6e-5 * np.cos(np.pi * x) * (1.0 + 0.5 * np.cos(np.pi * y))
    prescribed: dict[str, object] = {"top": lift, "bottom": (None, None, 0.0)}
    prescribed |= dict.fromkeys(("left", "right"), (0.0, None, None))
    prescribed |= dict.fromkeys(("front", "back"), (None, 0.0, None))
    scene = Scene(speaker, gravity=None, fixed=[], element=element, tissue=TISSUE)
    posture = scene.equilibrate(prescribed=prescribed, accuracy="reference")
    return float(0.5e9 * np.sum(np.asarray(posture.support_forces) * posture.displacements))


def test_order_of_the_energy() -> None:
    """Twice the order of the element's strains: 4, where trilinear elements have 2."""
    coarse, middle, fine = (stiffness(n, "Q2P1") for n in (4, 8, 16))
    order = float(np.log2((middle - coarse) / (fine - middle)))
    assert 3.5 < order < 4.5
    linear = [stiffness(n, "Q1P0") for n in (4, 8, 16)]
    assert 1.6 < float(np.log2((linear[1] - linear[0]) / (linear[2] - linear[1]))) < 2.4
    assert abs(fine - middle) < 0.1 * abs(linear[2] - linear[1])


def fall(element: str, cells: tuple[int, int, int]) -> FloatArray:
    """(times,) mm of the end of the cantilever, released."""
    speaker = block(cells)
    scene = Scene(speaker, fixed=["left"], element=element, tissue=TISSUE, damping=Damping(alpha=40.0, beta=0.03))
    movement = scene.simulate(None, 0.1, dt=0.005)
    return np.asarray(1e3 * (movement.positions - speaker.nodes)[:, nearest(speaker, POINT), 2])


def test_movement() -> None:
    """Trilinear elements tend to the movement that few quadratic ones have; 0.22, 0.095 and 0.03 mm of 14 mm seen."""
    fine = fall("Q2P1", (12, 8, 8))
    coarse = float(np.abs(fall("Q2P1", (6, 4, 4)) - fine).max())
    linear = [float(np.abs(fall("Q1P0", cells) - fine).max()) for cells in ((6, 4, 4), (12, 8, 8))]
    assert np.abs(fine).max() > 10.0
    assert coarse < 0.5 * linear[1]
    assert linear[1] < 0.6 * linear[0]


def test_equilibria_rest() -> None:
    scene = Scene(block(), fixed=["left"], element="Q2P1", tissue=TISSUE)
    start = scene.equilibrate(accuracy="reference")
    movement = scene.simulate(None, 0.05, dt=0.005, initial=start)
    assert np.abs(movement.positions - start.positions).max() < 1e-8


def test_half_is_whole() -> None:
    speaker = block((4, 4, 2), muscles={"upper": 3.0}, centred=True)
    scenes = [
        Scene(speaker, fixed=["left"], gravity=(1.0, 0.0, -9.0), element="Q2P1", mirror=mirror)
        for mirror in (False, True)
    ]
    full, half = (scene.equilibrate({"upper": 0.9}, accuracy="reference") for scene in scenes)
    assert np.abs(full.displacements).max() > 1e-3
    assert half.displacements == pytest.approx(full.displacements, abs=1e-9 * np.abs(full.displacements).max())
    assert np.asarray(half.pressure) == pytest.approx(
        np.asarray(full.pressure), abs=1e-6 * np.abs(np.asarray(full.pressure)).max()
    )


@pytest.mark.parametrize("mirror", [False, True])
def test_a_mesh_of_odd_division_is_refused(mirror: bool) -> None:
    speaker = block((4, 2, 2), centred=True) if mirror else block((3, 2, 2))
    with pytest.raises(InputError, match=r"hexahedron \d+ belongs to no group of 2 x 2 x 2 .*Speaker\.refined\(\)"):
        Scene(speaker, element="Q2P1", fixed=["left"], mirror=mirror).equilibrate()
    Scene(speaker.refined(), element="Q2P1", fixed=["left"], mirror=mirror).equilibrate()
